"""Triangulate flat panels: a hexagonal lattice inside samples of the outline, relaxed by spring forces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from ..geometry.curves import Curve
from .curves import edge_length, edge_points, panel_area
from .pattern import EdgeRef, Panel, Pattern

LATTICE_VERTEX_AREA = np.sqrt(3.0) / 2.0
"""Area per vertex of a lattice of equilateral triangles of edge 1 [squared edges], and its rows' distance [edges]."""

MAX_POINT_SIDE_PAIRS = 2**19
"""Number of pairs of a point and a polygon's side that are compared at once: 30 MB."""


@dataclass(frozen=True)
class MeshSettings:
    """Describe how panels are meshed.

    Attributes:
        sweeps: Number of force sweeps; angles stop improving after about 20.
        clearance: Distance to the outline [edge lengths] below which lattice points are left out: 0.6 is between the
            height of an equilateral triangle and half of it, so that boundary triangles are neither flat nor tall.
        push: Rest length of springs [mean edges]; above 1 they fill the panel (DistMesh's 1.2).
        step: Fraction of a spring's force that moves its ends in a sweep (DistMesh's 0.2).
        retriangulation: Motion of any point [edge lengths] after which the points are triangulated anew (DistMesh's
            0.1).
        refinements: Number of rounds in which an edge that the triangulation lost gets 1.5 times its samples.
    """

    sweeps: int = 24
    clearance: float = 0.6
    push: float = 1.2
    step: float = 0.2
    retriangulation: float = 0.1
    refinements: int = 8


@dataclass(frozen=True)
class FlatMesh:
    """Describe the triangles of one panel: boundary vertices first, in order.

    Attributes:
        vertices: Flat positions [m], shape [n, 2].
        faces: Counter-clockwise triangles, shape [m, 3].
        boundary_count: Number of vertices on the outline, the first ones, counter-clockwise from control point 0.
        corner: Index of each control point among them, shape [control_count].
    """

    vertices: np.ndarray
    faces: np.ndarray
    boundary_count: int
    corner: np.ndarray


def choose_edge_length(pattern: Pattern, vertex_count: int) -> float:
    """Return the edge length [m] at which the sewn mesh has about this many nodes. n = A / (sqrt(3)/2 h^2) + L / (2 h),
    A the panels' area and L the length of open edges: a node on an open contour belongs to half as many triangles as
    one inside, one on a seam counts as one inside."""
    sewn = {ref for seam in pattern.seams for ref in (seam.a, seam.b)}
    area = sum(panel_area(panel) for panel in pattern.panels)
    open_length = sum(
        edge_length(panel, i)
        for panel in pattern.panels
        for i in range(len(panel.edges))
        if EdgeRef(panel.name, i) not in sewn
    )
    half = open_length / 4.0
    return float((half + np.sqrt(half * half + vertex_count * area / LATTICE_VERTEX_AREA)) / vertex_count)


def count_segments(pattern: Pattern, size: float) -> dict[EdgeRef, int]:
    """Return the number of segments of every edge; both sides of a seam get that of their mean length. It is at least
    two: with a vertex between, no two edges, sewn or open, join the same two nodes."""
    counts = {}
    for panel in pattern.panels:
        for i in range(len(panel.edges)):
            counts[EdgeRef(panel.name, i)] = max(2, round(edge_length(panel, i) / size))
    for seam in pattern.seams:
        mean = sum(edge_length(pattern.panel(ref.panel), ref.edge) for ref in (seam.a, seam.b)) / 2.0
        counts[seam.a] = counts[seam.b] = max(2, round(mean / size))
    return counts


def refine_counts(pattern: Pattern, counts: dict[EdgeRef, int], coarse: set[EdgeRef]) -> dict[EdgeRef, int]:
    """Return the counts with 1.5 times the segments for lost edges and the edges sewn to them."""
    partner = {seam.a: seam.b for seam in pattern.seams} | {seam.b: seam.a for seam in pattern.seams}
    grown = coarse | {partner[ref] for ref in coarse if ref in partner}
    return {ref: int(np.ceil(1.5 * count)) if ref in grown else count for ref, count in counts.items()}


def mesh_panel(panel: Panel, counts: list[int], size: float, settings: MeshSettings) -> tuple[FlatMesh, set[int]]:
    """Mesh one panel with the given segments to each edge.

    Returns:
        The mesh, and the edges of which a segment is missing from it (the mesh is invalid where there are any).
    """
    boundary = np.concatenate([edge_points(panel, i, count)[:-1] for i, count in enumerate(counts)])
    corner = np.cumsum([0] + counts[:-1])
    owner = np.repeat(np.arange(len(counts)), counts)
    inside = _lattice(boundary, size, settings.clearance)
    inside = _relax_points(boundary, inside, size, settings)
    vertices = np.concatenate([boundary, inside])
    faces = _triangles(vertices, boundary)
    faces = _flip_ear_edges(vertices, faces, len(boundary))
    missing = _missing_segments(faces, len(boundary))
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    used[: len(boundary)] = True
    number = np.cumsum(used) - 1
    return FlatMesh(vertices[used], number[faces], len(boundary), corner), {int(owner[k]) for k in missing}


def points_in_polygon(polygon: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return which points, shape [n, 2], are inside a polygon, by the crossing rule, shape [n]."""
    if not len(points):
        return np.zeros(0, bool)
    start, end = polygon, np.roll(polygon, -1, axis=0)
    rise = np.where(end[:, 1] == start[:, 1], 1.0, end[:, 1] - start[:, 1])
    order = np.argsort(points[:, 1])
    x, y = points[order].T
    low, high = (np.searchsorted(y, choose(start[:, 1], end[:, 1])) for choose in (np.minimum, np.maximum))
    spanned = high - low  # points at the height of the side: those between low and high
    crossed = np.zeros(len(points), np.int64)
    for sides in np.split(
        np.arange(len(polygon)), np.flatnonzero(np.diff(np.cumsum(spanned) // MAX_POINT_SIDE_PAIRS)) + 1
    ):
        count = spanned[sides]
        side = np.repeat(sides, count)
        at = np.arange(count.sum()) + np.repeat(low[sides] - (np.cumsum(count) - count), count)
        meets = start[side, 0] + (y[at] - start[side, 1]) / rise[side] * (end[side, 0] - start[side, 0])
        crossed += np.bincount(at[x[at] < meets], minlength=len(points))
    inside = np.zeros(len(points), bool)
    inside[order] = crossed % 2 == 1
    return inside


def _lattice(boundary: np.ndarray, size: float, clearance: float) -> np.ndarray:
    """Return the points of a hexagonal lattice inside the outline, centred on it."""
    low, high = boundary.min(axis=0), boundary.max(axis=0)
    middle = (low + high) / 2.0
    reach = np.ceil((high - low) / 2.0 / np.array([size, size * LATTICE_VERTEX_AREA])).astype(int) + 1
    rows = np.arange(-reach[1], reach[1] + 1)
    columns = np.arange(-reach[0], reach[0] + 1)
    x = columns[None, :] + 0.5 * (rows[:, None] % 2)
    points = (
        np.stack([x, np.broadcast_to(LATTICE_VERTEX_AREA * rows[:, None], x.shape)], axis=-1).reshape(-1, 2) * size
        + middle
    )
    points = points[points_in_polygon(boundary, points)]
    found: np.ndarray = points[_sample_outline(boundary, size).query(points)[0] > clearance * size]
    return found


def _sample_outline(boundary: np.ndarray, size: float) -> cKDTree:
    """Return a search tree of samples of the outline a tenth of the edge length apart: the distance to the nearest is
    that to the outline within 2 % of the edge length."""
    start, step = boundary, np.roll(boundary, -1, axis=0) - boundary
    count = np.maximum(1, np.ceil(np.linalg.norm(step, axis=1) / (0.1 * size)).astype(int))
    index = np.repeat(np.arange(len(boundary)), count)
    part = (np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)) / count[index]
    return cKDTree(start[index] + part[:, None] * step[index])


def _relax_points(boundary: np.ndarray, inside: np.ndarray, size: float, settings: MeshSettings) -> np.ndarray:
    """Move inner points apart until springs balance (Persson and Strang 2004); the outline stays. A spring's rest
    length follows the size of the outline's segments near it, so that gathered or short edges get smaller triangles. A
    step that takes a point out of the outline or within a third of an edge of it is undone."""
    if not len(inside):
        return inside
    fixed = len(boundary)
    local = Curve(boundary).lengths
    local = (local + np.roll(local, 1)) / 2.0
    points = np.concatenate([boundary, inside])
    targets = np.concatenate([local, np.full(len(inside), size)])
    outline = _sample_outline(boundary, size)
    triangulated = np.full(points.shape, np.inf)
    for _ in range(settings.sweeps):
        if np.linalg.norm(points - triangulated, axis=1).max() > settings.retriangulation * size:
            triangulated, bars = points.copy(), _list_edges(_triangles(points, boundary), len(points))
        vector = points[bars[:, 0]] - points[bars[:, 1]]
        length = np.linalg.norm(vector, axis=1)
        rest = targets[bars].mean(axis=1)
        rest *= settings.push * np.sqrt((length**2).sum() / (rest**2).sum())
        force = (np.maximum(rest - length, 0.0) / np.maximum(length, 1e-12))[:, None] * vector
        total = np.stack(
            [
                np.bincount(bars[:, 0], force[:, k], len(points)) - np.bincount(bars[:, 1], force[:, k], len(points))
                for k in (0, 1)
            ],
            axis=1,
        )
        moved = points[fixed:] + settings.step * total[fixed:]
        # A step is far shorter than an edge, so only points near the outline can have left it.
        distance = outline.query(moved, distance_upper_bound=size)[0]
        good = distance > 0.33 * size
        is_near = good & (distance < size)
        good[is_near] = points_in_polygon(boundary, moved[is_near])
        points[fixed:] = np.where(good[:, None], moved, points[fixed:])
    return points[fixed:]


def _list_edges(faces: np.ndarray, count: int) -> np.ndarray:
    """Return the edges of faces over `count` points, each once, the smaller end first, shape [n, 2]."""
    ends = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    codes = np.unique(ends[:, 0] * count + ends[:, 1])
    return np.stack([codes // count, codes % count], axis=1)


def _triangles(points: np.ndarray, boundary: np.ndarray) -> np.ndarray:
    """Return the counter-clockwise Delaunay triangles inside the outline, without flat ones. Only triangles between
    three vertices of the outline, the first ones, are tested by their centroid; one that reaches from an inner vertex
    across the outline leaves a segment of it without a triangle, which `_missing_segments` finds."""
    faces = Delaunay(points).simplices
    a, b, c = (points[faces[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    faces = np.where(area[:, None] < 0, faces[:, [0, 2, 1]], faces)
    longest = np.max([((b - a) ** 2).sum(axis=1), ((c - b) ** 2).sum(axis=1), ((a - c) ** 2).sum(axis=1)], axis=0)
    keep = np.abs(area) > 1e-5 * longest
    doubtful = keep & (faces < len(boundary)).all(axis=1)
    keep[doubtful] = points_in_polygon(boundary, ((a + b + c) / 3.0)[doubtful])
    found: np.ndarray = faces[keep].astype(np.int64)
    return found


def _missing_segments(faces: np.ndarray, boundary_count: int) -> np.ndarray:
    """Return the outline's segments (by first vertex) that border no triangle or are crossed by one."""
    count = int(faces.max(initial=0)) + 1
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    codes = edges[:, 0] * count + edges[:, 1]
    first = np.arange(boundary_count)
    second = (first + 1) % boundary_count
    keys = first * count + second
    missing = ~np.isin(keys, codes)
    back = edges[:, 1] * count + edges[:, 0]
    loose = edges[~np.isin(codes, back) & ~np.isin(codes, keys)]
    ends = np.unique(loose)
    return np.flatnonzero(missing | np.isin(first, ends[ends < boundary_count]))


def _flip_ear_edges(vertices: np.ndarray, faces: np.ndarray, boundary_count: int) -> np.ndarray:
    """Flip the inner edge of triangles with two sides on the outline, so that each corner has an inner edge. Such a
    triangle cannot bend, and two of them sewn corner to corner would share an edge four times. The edge is flipped only
    where both new triangles have a smallest angle above 20 degrees."""
    faces = faces.copy()
    owner = {(int(f[k]), int(f[(k + 1) % 3])): i for i, f in enumerate(faces) for k in range(3)}
    for i in range(len(faces)):
        for k in range(3):
            corner, a, b = (int(faces[i, (k + j) % 3]) for j in range(3))
            on = corner < boundary_count and a == (corner + 1) % boundary_count and b == (corner - 1) % boundary_count
            other = owner.get((b, a)) if on else None
            if other is None:
                continue
            opposite = next(int(v) for v in faces[other] if v not in (a, b))
            new = np.array([[corner, a, opposite], [corner, opposite, b]])
            if _angles(vertices, new).min() < np.radians(20.0):
                continue
            for j in range(2):
                faces[(i, other)[j]] = new[j]
                for m in range(3):
                    owner[int(new[j, m]), int(new[j, (m + 1) % 3])] = (i, other)[j]
            owner.pop((a, b), None)
            owner.pop((b, a), None)
            break
    return faces


def _angles(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the signed corner angles [rad], shape [n, 3]; negative for an inverted triangle."""
    angles = np.zeros(faces.shape)
    for k in range(3):
        a, b, c = (vertices[faces[:, (k + j) % 3]] for j in range(3))
        u, v = b - a, c - a
        angles[:, k] = np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1))
    return angles


def corner_angles(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the corner angles [rad] of flat triangles, shape [n, 3]; negative for an inverted one."""
    return _angles(vertices, faces)


def split_edges(mesh: FlatMesh, pairs: np.ndarray) -> FlatMesh:
    """Insert a vertex in the middle of inner edges, shape [n, 2]; each becomes two and divides its two triangles."""
    vertices, faces = list(mesh.vertices), [tuple(face) for face in mesh.faces.tolist()]
    for a, b in pairs.tolist():
        middle = len(vertices)
        vertices.append(
            (mesh.vertices[a] + mesh.vertices[b]) / 2.0
            if max(a, b) < len(mesh.vertices)
            else (vertices[a] + vertices[b]) / 2.0
        )
        cut = []
        for face in faces:
            if a in face and b in face:
                cut += [tuple(middle if v == a else v for v in face), tuple(middle if v == b else v for v in face)]
            else:
                cut.append(face)
        faces = cut
    return replace(mesh, vertices=np.array(vertices), faces=np.array(faces, dtype=np.int64))
