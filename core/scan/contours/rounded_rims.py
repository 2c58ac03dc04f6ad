"""The rounded edge of a garment that was cut out of a dressed person's surface, straightened."""

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
"""Width of the strip along a cut in which the surface bends off to what lies beyond [m], three cells of 4 mm of a fused
surface: on four garments of such scans it lies 3 to 6 mm inside the cloth at the cut, 1 to 3 at 5 to 8 mm, 0.3 to 1 at
8 to 11, and not at all from 15 on."""

MAX_RIM_FIT_DISTANCE = 0.030
"""Distance from a cut up to which the cloth is fitted to find where the surface would go on [m]: half a fold."""

MAX_RIM_FIT_COUNT = 48
"""Largest number of vertices in a fit: of a surface with edges of 4 mm those of 2 x 3 cm."""

RIM_FIT_SPACING = 0.004
"""Edge length of a surface of which every vertex is fitted [m]; of a finer one every n-th."""

MIN_RIM_FIT_COUNT = 12
"""Least number of vertices in a fit; fewer are of a surface so coarse that its edge cannot be rounded."""

MIN_RIM_NORMAL_COSINE = 0.5
"""Least cosine between the normals of the fitted vertices and the nearest one's: it leaves out the far side of a sharp
fold."""


RIM_SMOOTHING_LENGTH = 0.005
"""Length over which a cut edge is smoothed [m]: half of a wave of 3 cm is left, and a seventeenth of one of 15 mm. A
person's parts are labelled at samples 7 mm apart, so that the borders between them wave by two to four of these."""

MIN_RIM_EDGE_LENGTH = 1e-4
"""Least length of a rim's edge in the smoothing [m]: shorter ones are divided by as if they had this length."""

STRAIGHTENED_RIM_NOTE = "edges that the scan rounds towards what lies beyond them were straightened over 12 mm"
"""What a person is told."""


def straighten_scan(scan: Scan) -> Scan:
    """Return a garment's scan with straight rims where it was cut out of a larger surface; others as they are.

    What is rounded there is no cloth, so neither target nor metrics are of it.
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
    """Move what is rounded along a garment's cut edges to where the cloth beside it leads [m], [vertex_count, 3].

    A scanner's software joins cloth and skin by one surface, which leaves the cloth before its end and bends over the
    step to the skin. Cut there, cuffs came out 6 mm too narrow, an eighth of their length. Around each vertex of a cut
    a surface z = a + b u + c v + e u^2 is fitted (least squares) to the vertices `ROUNDED_RIM_WIDTH` to
    `MAX_RIM_FIT_DISTANCE` away from it, v pointing away from these, u across, z along their mean normal; the vertex
    moves along z onto it, by at most `ROUNDED_RIM_WIDTH`. Outward only, for beyond lies the skin, and what rises there
    is skin that was taken for cloth; where the garment goes on hidden, either way. Then the rim is evened out
    (`_smooth_rim`) and what lies within `ROUNDED_RIM_WIDTH` of it is laid as a plate between it and the cloth
    (`_fit_thin_plate`): moved one by one, a tenth of its faces were folded over.

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
    way = shortest_paths(edges, lengths, rim, MAX_RIM_FIT_DISTANCE)[0]
    straight = np.flatnonzero((way >= ROUNDED_RIM_WIDTH) & (way < MAX_RIM_FIT_DISTANCE))
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
        _smooth_rim(moved, edges, rim), edges, np.flatnonzero((way < ROUNDED_RIM_WIDTH) & ~edges.border_vertices)
    )


def _height_over_cloth(
    vertices: np.ndarray, faces: np.ndarray, rim: np.ndarray, straight: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return how far a rim lies over where the cloth beside it leads [m]: vertices of it, heights, unit normals.

    Args:
        vertices: Shape [vertex_count, 3].
        faces: Shape [face_count, 3].
        rim: Indices of the vertices that are asked for; those without enough cloth beside them are left out.
        straight: Of the cloth's.
    """
    away, near = cKDTree(vertices[straight]).query(
        vertices[rim], k=min(MAX_RIM_FIT_COUNT, len(straight)), distance_upper_bound=MAX_RIM_FIT_DISTANCE
    )
    normals = vertex_normals(vertices, faces)[straight]
    is_near = np.isfinite(away)
    near = np.where(is_near, near, 0)
    is_near &= (normals[near] * normals[near[:, :1]]).sum(axis=2) > MIN_RIM_NORMAL_COSINE
    told = is_near.sum(axis=1) >= MIN_RIM_FIT_COUNT
    near, is_near = near[told], is_near[told]
    normal = unit((is_near[..., None] * normals[near]).sum(axis=1))
    return rim[told], _height_over(vertices[rim[told]], vertices[straight][near], is_near, normal), normal


def _smooth_rim(vertices: np.ndarray, edges: HalfEdges, rim: np.ndarray) -> np.ndarray:
    """Return vertices [m] with those of a rim where int |x - x0|^2 + `RIM_SMOOTHING_LENGTH`^4 |x''|^2 ds along the
    border is least.

    A wave of length l keeps 1 / (1 + (2 pi `RIM_SMOOTHING_LENGTH` / l)^4) of its height, and a circle of radius r loses
    (`RIM_SMOOTHING_LENGTH` / r)^4 of it: a cuff nothing.

    Args:
        vertices: Shape [vertex_count, 3].
        edges: The mesh.
        rim: Indices of those that may move; the others are held.
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
    """Return vertices [m] with the free ones where the squared sums of their differences to neighbours are least.

    All neighbours weigh alike: with cotangents, slivers would be stiff, and folds stay.

    Args:
        vertices: Shape [vertex_count, 3].
        edges: The mesh.
        free: Indices of the vertices that may move, none on a border; the others are held.
    """
    differences = sparse.csr_matrix(sparse.csgraph.laplacian(sparse.csr_matrix(edges.adjacency, dtype=np.float64)))
    plate = differences[free] @ sparse.diags((~edges.border_vertices).astype(np.float64)) @ differences
    return _solve_free_vertices(vertices, plate, np.zeros((len(free), 3)), free)


def _solve_free_vertices(
    vertices: np.ndarray, rows: sparse.csr_matrix, load: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """Return vertices with the free ones where x^T K x / 2 - load^T x is least, the others held, [vertex_count, 3].

    Args:
        vertices: Shape [vertex_count, 3].
        rows: The free vertices' rows of K, shape [free_count, vertex_count].
        load: Of the free vertices, shape [free_count, 3].
        free: Their indices.
    """
    if not len(free):
        return vertices
    settled = vertices.copy()
    settled[free] = 0.0
    settled[free] = factor_symmetric(rows[:, free]).solve(load - rows @ settled)
    return settled


def _height_over(points: np.ndarray, beside: np.ndarray, asked: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return how far points lie over the surfaces that are fitted beside each [m], shape [count].

    Args:
        points: Shape [count, 3].
        beside: Points beside each [m], shape [count, most, 3].
        asked: Which of them are, bool, shape [count, most].
        normal: Unit normal of each surface, shape [count, 3].
    """
    weight = (asked / asked.sum(axis=1, keepdims=True))[..., None]
    middle = (weight * beside).sum(axis=1)
    out = points - middle
    out = unit(out - (out * normal).sum(axis=1, keepdims=True) * normal)
    frame = np.stack([np.cross(normal, out), out, normal], axis=2)
    u, v, z = np.moveaxis((beside - middle[:, None]) @ frame, 2, 0) / ROUNDED_RIM_WIDTH
    terms = np.stack([np.ones_like(u), u, v, u**2], axis=2)
    system = np.swapaxes(terms, 1, 2) @ (weight * terms) + 1e-6 * np.eye(4)
    fitted = np.linalg.solve(system, np.swapaxes(terms, 1, 2) @ (weight * z[..., None]))[..., 0]
    u, v, z = np.moveaxis(((points - middle)[:, None] @ frame)[:, 0], 1, 0) / ROUNDED_RIM_WIDTH
    return np.asarray(ROUNDED_RIM_WIDTH * (z - (fitted * np.stack([np.ones_like(u), u, v, u**2], axis=1)).sum(axis=1)))
