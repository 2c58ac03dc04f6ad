"""Straighten the rounded edge of a garment that was cut out of a dressed person's surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sparse
from scipy.spatial import cKDTree

from ...geometry.connectivity import HalfEdges, shortest_paths
from ...geometry.geometry import edge_lengths, unit, vertex_normals
from ...geometry.linear import factor_symmetric
from ..scan import Scan

ROUNDED_RIM_WIDTH = 0.012
"""Width of the strip along a cut in which the surface bends towards what is beyond [m], three cells of 4 mm of a fused
surface: on four garments 3 to 6 mm inside the cloth at the cut, 1 to 3 at 5 to 8 mm, 0.3 to 1 at 8 to 11, 0 from 15."""

MAX_RIM_FIT_DISTANCE = 0.030
"""Distance from a cut up to which the cloth is fitted to extrapolate the surface [m]: half a fold."""

MAX_RIM_FIT_COUNT = 48
"""Largest number of vertices in a fit: 2 x 3 cm of a surface with edges of 4 mm."""

RIM_FIT_SPACING = 0.004
"""Edge length of a surface of which every vertex is fitted [m]; of a finer one every n-th."""

MIN_RIM_FIT_COUNT = 12
"""Least number of vertices in a fit; a surface with fewer is so coarse that its edge cannot be rounded."""

MIN_RIM_NORMAL_COSINE = 0.5
"""Least cosine between the fitted vertices' normals and the nearest one's: excludes the far side of sharp folds."""


RIM_SMOOTHING_LENGTH = 0.005
"""Length over which a cut edge is smoothed [m]: half of a wave of 3 cm is left, a seventeenth of one of 15 mm. Borders
between labelled parts have waves of two to four samples, which are 7 mm apart."""

MIN_RIM_EDGE_LENGTH = 1e-4
"""Lower bound of the length of a rim's edge in the smoothing, which divides by it [m]."""

STRAIGHTENED_RIM_NOTE = "edges that the scan rounds towards what lies beyond them were straightened over 12 mm"
"""Note to the user."""


def straighten_scan(scan: Scan) -> Scan:
    """Return a garment's scan with straight rims where it was cut out of a larger surface; others as they are.

    What is rounded there is no cloth, so neither target nor metrics have it.
    """
    if scan.unseen is None:
        return scan
    vertices = straighten_rims(scan.vertices, scan.faces, scan.unseen, scan.hidden)
    if np.array_equal(vertices, scan.vertices):
        return scan
    return replace(scan, vertices=vertices, repairs=(*scan.repairs, STRAIGHTENED_RIM_NOTE))


def straighten_rims(
    vertices: np.ndarray, faces: np.ndarray, unseen: np.ndarray, hidden: np.ndarray | None = None
) -> np.ndarray:
    """Move what is rounded along a garment's cut edges to the extrapolated cloth beside it [m], [vertex_count, 3].

    A scanner's software joins cloth and skin by one surface, which leaves the cloth before its end and bends over the
    step to the skin; cut there, cuffs were 6 mm too narrow, an eighth of their length. Around each vertex of a cut a
    surface z = a + b u + c v + e u^2 is fitted (least squares) to the vertices `ROUNDED_RIM_WIDTH` to
    `MAX_RIM_FIT_DISTANCE` away from it, v pointing away from these, u across, z along their mean normal; the vertex
    moves along z onto it, by at most `ROUNDED_RIM_WIDTH`. It moves outward only, since what rises above the fit is skin
    that was taken for cloth; where the garment goes on hidden, either way. Then the rim is smoothed (`_smooth_rim`),
    and the vertices within `ROUNDED_RIM_WIDTH` of it are moved onto a plate between rim and cloth (`_fit_thin_plate`):
    moved one by one, a tenth of its faces were folded over.

    Args:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: Vertex indices, shape [face_count, 3].
        unseen: True at vertices where the scan itself ends: an edge there is no cut, shape [vertex_count].
        hidden: True at vertices of edges beyond which the garment goes on hidden, shape [vertex_count]; None: nowhere.
    """
    edges = HalfEdges.of(faces, len(vertices))
    rim = np.flatnonzero(edges.border_vertices & ~unseen)
    if not len(rim):
        return vertices
    lengths = edge_lengths(vertices, edges.edges)
    distance = shortest_paths(edges, lengths, rim, MAX_RIM_FIT_DISTANCE)[0]
    straight = np.flatnonzero((distance >= ROUNDED_RIM_WIDTH) & (distance < MAX_RIM_FIT_DISTANCE))
    straight = straight[:: max(1, round((RIM_FIT_SPACING / float(np.median(lengths[edges.edge]))) ** 2))]
    if len(straight) < MIN_RIM_FIT_COUNT:
        return vertices
    lifted, height, normal = _height_over_cloth(vertices, faces, rim, straight)
    covered = np.zeros(len(lifted), dtype=bool) if hidden is None else hidden[lifted]
    lift = np.clip(-height, np.where(covered, -ROUNDED_RIM_WIDTH, 0.0), ROUNDED_RIM_WIDTH)
    if not lift.any():
        return vertices
    moved = vertices.copy()
    moved[lifted] += lift[:, None] * normal
    return _fit_thin_plate(
        _smooth_rim(moved, edges, rim), edges, np.flatnonzero((distance < ROUNDED_RIM_WIDTH) & ~edges.border_vertices)
    )


def _height_over_cloth(
    vertices: np.ndarray, faces: np.ndarray, rim: np.ndarray, straight: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a rim's vertices with enough cloth beside them, their heights over where it leads [m], and unit normals.

    `rim` and `straight` are indices of vertices: of the rim, and of the cloth that is fitted.
    """
    distance, nearest = cKDTree(vertices[straight]).query(
        vertices[rim], k=min(MAX_RIM_FIT_COUNT, len(straight)), distance_upper_bound=MAX_RIM_FIT_DISTANCE
    )
    normals = vertex_normals(vertices, faces)[straight]
    is_near = np.isfinite(distance)
    nearest = np.where(is_near, nearest, 0)
    is_near &= (normals[nearest] * normals[nearest[:, :1]]).sum(axis=2) > MIN_RIM_NORMAL_COSINE
    is_known = is_near.sum(axis=1) >= MIN_RIM_FIT_COUNT
    nearest, is_near = nearest[is_known], is_near[is_known]
    normal = unit((is_near[..., None] * normals[nearest]).sum(axis=1))
    return rim[is_known], _height_over(vertices[rim[is_known]], vertices[straight][nearest], is_near, normal), normal


def _smooth_rim(vertices: np.ndarray, edges: HalfEdges, rim: np.ndarray) -> np.ndarray:
    """Return vertices [m] with those in `rim` minimising int |x - x0|^2 + a^4 |x''|^2 ds, a = `RIM_SMOOTHING_LENGTH`.

    The integral is along the border; other vertices are fixed. A wave of length l keeps 1 / (1 + (2 pi a / l)^4) of its
    height; a circle of radius r loses (a / r)^4 of it: a cuff nothing.
    """
    ends = edges.edges[edges.face_counts == 1]
    lengths = np.maximum(edge_lengths(vertices, ends), MIN_RIM_EDGE_LENGTH)
    share = np.bincount(ends.ravel(), 0.5 * np.repeat(lengths, 2), len(vertices))
    share[share == 0.0] = 1.0
    links = sparse.csr_matrix((1.0 / lengths, tuple(ends.T)), shape=(len(vertices),) * 2)
    bend = sparse.csgraph.laplacian(links + links.T)
    system = sparse.csr_matrix(
        sparse.diags(share) + RIM_SMOOTHING_LENGTH**4 * (bend @ sparse.diags(1.0 / share) @ bend)
    )
    return _solve_free_vertices(vertices, system[rim], (share[:, None] * vertices)[rim], rim)


def _fit_thin_plate(vertices: np.ndarray, edges: HalfEdges, free: np.ndarray) -> np.ndarray:
    """Return vertices [m] with those in `free`, none on a border, minimising squared sums of differences to neighbours.

    Neighbours have equal weights: with cotangents, slivers would be stiff, and folds stay.
    """
    differences = sparse.csr_matrix(sparse.csgraph.laplacian(sparse.csr_matrix(edges.adjacency, dtype=np.float64)))
    plate = differences[free] @ sparse.diags((~edges.border_vertices).astype(np.float64)) @ differences
    return _solve_free_vertices(vertices, plate, np.zeros((len(free), 3)), free)


def _solve_free_vertices(
    vertices: np.ndarray, rows: sparse.csr_matrix, load: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """Return vertices with those in `free` minimising x^T K x / 2 - load^T x, the others fixed, [vertex_count, 3].

    `rows` are the free vertices' rows of K, shape [free_count, vertex_count]; `load` is theirs, shape [free_count, 3].
    """
    if not len(free):
        return vertices
    settled = vertices.copy()
    settled[free] = 0.0
    settled[free] = factor_symmetric(rows[:, free]).solve(load - rows @ settled)
    return settled


def _height_over(points: np.ndarray, neighbours: np.ndarray, is_used: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return the heights of points, shape [count, 3], over the surfaces fitted beside each [m], shape [count].

    `neighbours` are points beside each [m], shape [count, most, 3]; `is_used` marks those that are used, shape [count,
    most]; `normal` is the unit normal of each surface, shape [count, 3].
    """
    weight = (is_used / is_used.sum(axis=1, keepdims=True))[..., None]
    middle = (weight * neighbours).sum(axis=1)
    out = points - middle
    out = unit(out - (out * normal).sum(axis=1, keepdims=True) * normal)
    frame = np.stack([np.cross(normal, out), out, normal], axis=2)
    u, v, z = np.moveaxis((neighbours - middle[:, None]) @ frame, 2, 0) / ROUNDED_RIM_WIDTH
    terms = np.stack([np.ones_like(u), u, v, u**2], axis=2)
    system = np.swapaxes(terms, 1, 2) @ (weight * terms) + 1e-6 * np.eye(4)
    fitted = np.linalg.solve(system, np.swapaxes(terms, 1, 2) @ (weight * z[..., None]))[..., 0]
    u, v, z = np.moveaxis(((points - middle)[:, None] @ frame)[:, 0], 1, 0) / ROUNDED_RIM_WIDTH
    return np.asarray(ROUNDED_RIM_WIDTH * (z - (fitted * np.stack([np.ones_like(u), u, v, u**2], axis=1)).sum(axis=1)))
