"""Simplify a triangle mesh by collapsing edges, the shortest first; borders do not change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..run.kernels import kernel
from .geometry import edge_lengths


@dataclass(frozen=True)
class CollapseSettings:
    """Describe which edges are collapsed.

    Attributes:
        edge_share: Share of the edges, the shortest, that one iteration may collapse; lengths are recomputed after it.
        cosine: Smallest cosine of the angle by which a face may turn: 60 degrees, more than folds turn within an edge.
        height_ratio: Smallest ratio of height to longest side of faces that a collapse changes, unless they had less,
            as along a border that is finer than the inside.
        face_share: Smallest share of the faces that an iteration must remove; else the next may turn faces further.
            Where noise is as large as an edge, normals differ so much that few collapses are allowed.
        iterations: Largest number of iterations; 2.2 million faces become 100 thousand in 20.
    """

    edge_share: float = 0.4
    cosine: float = 0.5
    height_ratio: float = 0.15
    face_share: float = 0.01
    iterations: int = 200


@dataclass(frozen=True)
class CollapsedMesh:
    """Describe a mesh with fewer faces.

    Attributes:
        vertices: Positions, shape [vertex_count, 3]: on a border those of the given mesh, elsewhere the mean of the
            merged vertices, which averages noise.
        faces: Vertex indices, shape [face_count, 3].
        origin: Index of each vertex in the given mesh, ascending, shape [vertex_count].
        place: Vertex into which each given vertex was merged, shape [mesh_vertex_count]; -1 where no face uses it.
    """

    vertices: np.ndarray
    faces: np.ndarray
    origin: np.ndarray
    place: np.ndarray


def collapse_edges(
    vertices: np.ndarray, faces: np.ndarray, most: int, settings: CollapseSettings = CollapseSettings()
) -> CollapsedMesh:
    """Reduce a surface to at most `most` faces; borders, openings and handles remain.

    An edge is collapsed into the mean of the vertices merged into its ends, or into the end on a border. It is
    collapsed only if both ends have exactly the two common neighbours of its faces (the link condition, Dey et al.,
    "Topology preserving edge contraction", 1999), if no face turns over, and unless both ends are on a border. So every
    border edge remains, with the same positions.

    The result is deterministic. A mesh with no more faces is returned as given; one whose borders need more keeps them.

    Args:
        vertices: Positions, shape [vertex_count, 3].
        faces: Consistently oriented, no edge with more than two faces, shape [face_count, 3].
        most: Largest number of faces.
        settings: Which edges are collapsed.
    """
    count = len(vertices)
    if len(faces) <= most:
        return CollapsedMesh(vertices, faces, np.arange(count), np.arange(count))
    points = np.array(vertices, dtype=np.float64)
    table = np.array(faces, dtype=np.int64)
    weights, stands = np.ones(count), np.arange(count)
    fixed = np.zeros(count, dtype=bool)
    fixed[_border_vertices(table, count)] = True
    turn, left = settings.cosine, len(table)
    for _ in range(settings.iterations):
        edges = _inner_edges(table)
        shortest = edges[_shortest(edge_lengths(points, edges), max(1, int(settings.edge_share * len(edges))))]
        limits = turn, settings.height_ratio
        alive, removed = _collapse(points, table, weights, stands, fixed, shortest, left - most, limits)
        table, left = table[alive], left - removed
        is_slow = removed < settings.face_share * left
        if left <= most or (is_slow and turn <= -1.0):
            break
        turn = turn - 0.5 if is_slow else turn
    origin = np.unique(table)
    place = np.full(count, -1)
    place[origin] = np.arange(len(origin))
    return CollapsedMesh(points[origin], place[table], origin, place[_roots(stands)])


def _shortest(lengths: np.ndarray, count: int) -> np.ndarray:
    """Return the indices of the `count` smallest values, ascending, ties by index."""
    if count >= len(lengths):
        return np.argsort(lengths, kind="stable")
    within = np.flatnonzero(lengths <= np.partition(lengths, count)[count])
    return within[np.argsort(lengths[within], kind="stable")[:count]]


def _border_vertices(faces: np.ndarray, count: int) -> np.ndarray:
    """Find the vertices on edges of a single face."""
    tail, head = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    edge, times = np.unique(np.minimum(tail, head) * count + np.maximum(tail, head), return_counts=True)
    single = edge[times != 2]
    return np.unique(np.concatenate([single // count, single % count]))


def _inner_edges(faces: np.ndarray) -> np.ndarray:
    """Return each edge that two faces run along in opposite directions once, shape [edge_count, 2]."""
    tail, head = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    once = tail < head  # of an edge on a border this finds some; these are never collapsed
    return np.stack([tail[once], head[once]], axis=1)


@kernel()
def _roots(stands):  # type: ignore[no-untyped-def]
    """Find the vertex into which each vertex is finally merged."""
    found = stands.copy()
    for v in range(len(stands)):
        root = v
        while stands[root] != root:
            root = stands[root]
        found[v] = root
    return found


@kernel()
def _collapse(points, faces, weights, stands, fixed, edges, most, limits):  # type: ignore[no-untyped-def]
    """Collapse edges in their order, each vertex at most once, until `most` faces are removed; modifies all but
    `edges`. Return which faces remain, and the number of removed ones."""
    count, corners = len(points), 3 * len(faces)
    first, following = np.full(count, -1), np.full(corners, -1)
    for corner in range(corners - 1, -1, -1):
        v = faces[corner // 3, corner % 3]
        following[corner] = first[v]
        first[v] = corner
    alive = np.ones(len(faces), np.bool_)
    moved = np.zeros(count, np.bool_)
    seen = np.full(count, -1)
    goal = np.zeros(3)
    removed = 0
    fans = faces, alive, first, following
    for e in range(len(edges)):
        if removed >= most:
            break
        u, v = edges[e, 0], edges[e, 1]
        if moved[u] or moved[v] or (fixed[u] and fixed[v]):
            continue
        if fixed[u]:
            u, v = v, u
        if not _has_two_common(fans, seen, u, v, e):
            continue
        total = weights[u] + weights[v]
        share = 0.0 if fixed[v] else weights[u] / total
        for k in range(3):
            goal[k] = share * points[u, k] + (1.0 - share) * points[v, k]
        if not _keeps_shape(points, fans, u, v, goal, limits):
            continue
        if not fixed[v] and not _keeps_shape(points, fans, v, u, goal, limits):
            continue
        last = -1
        corner = first[u]
        while corner >= 0:
            face = corner // 3
            if alive[face]:
                if faces[face, 0] == v or faces[face, 1] == v or faces[face, 2] == v:
                    alive[face] = False
                    removed += 1
                else:
                    faces[face, corner % 3] = v
            last = corner
            corner = following[corner]
        following[last] = first[v]
        first[v] = first[u]
        for k in range(3):
            points[v, k] = goal[k]
        weights[v] = total
        stands[u] = v
        moved[u] = moved[v] = True
    return alive, removed


@kernel()
def _has_two_common(fans, seen, u, v, token):  # type: ignore[no-untyped-def]
    """Check the link condition: exactly two vertices are neighbours of both ends."""
    faces, alive, first, following = fans
    corner = first[u]
    while corner >= 0:
        face = corner // 3
        if alive[face]:
            for k in range(3):
                seen[faces[face, k]] = 2 * token
        corner = following[corner]
    common = 0
    corner = first[v]
    while corner >= 0:
        face = corner // 3
        if alive[face]:
            for k in range(3):
                w = faces[face, k]
                if w != u and w != v and seen[w] == 2 * token:
                    seen[w] = 2 * token + 1
                    common += 1
        corner = following[corner]
    return common == 2


@kernel()
def _keeps_shape(points, fans, u, v, goal, limits):  # type: ignore[no-untyped-def]
    """Check that no face of u without v turns over or becomes thin where u moves to the goal."""
    (faces, alive, first, following), (turn, height_ratio) = fans, limits
    corner = first[u]
    while corner >= 0:
        face = corner // 3
        k = corner % 3
        b, c = faces[face, (k + 1) % 3], faces[face, (k + 2) % 3]
        if alive[face] and b != v and c != v:
            x, y, z, slim = _normal(points[u, 0], points[u, 1], points[u, 2], points, b, c)
            p, q, r, thin = _normal(goal[0], goal[1], goal[2], points, b, c)
            if x * p + y * q + z * r < turn or thin < min(height_ratio, slim):
                return False
        corner = following[corner]
    return True


@kernel()
def _normal(x, y, z, points, b, c):  # type: ignore[no-untyped-def]
    """Return the unit normal of a triangle from (x, y, z) to vertices b and c, and its height over its longest side."""
    px, py, pz = points[b, 0] - x, points[b, 1] - y, points[b, 2] - z
    qx, qy, qz = points[c, 0] - x, points[c, 1] - y, points[c, 2] - z
    rx, ry, rz = qx - px, qy - py, qz - pz
    nx, ny, nz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    size = np.sqrt(nx * nx + ny * ny + nz * nz)
    if size == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    longest = max(px * px + py * py + pz * pz, qx * qx + qy * qy + qz * qz, rx * rx + ry * ry + rz * rz)
    return nx / size, ny / size, nz / size, size / longest
