"""Cut the garment out of a clothed scan along a smooth line."""

from __future__ import annotations

import numpy as np

from ..geometry.connectivity import HalfEdges, adjacency_matrix
from . import refusal
from .repair import RepairedMesh, clean_cut
from .scan import Scan

CUT_SMOOTHING_STD = 0.008
"""Standard deviation of the averaging of the labels along the surface before the cut [m]: wider than a scan's triangles
(3 to 5 mm), whose zigzag would show, and than single wrong labels; narrower than a shoulder strap (3 cm)."""
MIN_CUT_EDGE_SHARE = 0.1
"""Least distance of the cut from either end of an edge, as a share of the edge's length, to avoid slivers."""
MAX_CUT_SMOOTHING_ITERATIONS = 60
"""Largest number of averaging iterations; reached only where triangles are smaller than 2 mm."""


def cut_garment(scan: Scan, cloth: np.ndarray) -> Scan:
    """Return the part of a scan where `cloth` is set, bool, shape [vertex_count], as a surface of its own.

    The marks are averaged over neighbours to a smooth function f. The garment is where f > 1/2; triangles are cut at
    f = 1/2, so that contours are smooth curves on the scan. Pieces below 5 % of the largest are dropped.

    Raises:
        LabelUnknown: where no surface is left.
    """
    edges = HalfEdges.of(scan.faces, len(scan.vertices))
    field = _average_marks(scan.vertices, edges, cloth)
    vertices, faces, ends, share = _cut_level(scan.vertices, edges, field)
    surface = RepairedMesh(vertices, faces, np.arange(len(vertices)))
    surface = clean_cut(surface) if len(faces) else surface
    if len(surface.faces) == 0:
        raise refusal.LabelUnknown(f"the labels leave no surface of {scan.name}; check --keep.")
    first, second = ends[surface.origin].T
    t = share[surface.origin][:, None]
    colours, border = scan.colours, edges.border_vertices
    return Scan(
        vertices=surface.vertices,
        faces=surface.faces,
        name=scan.name,
        sha256=scan.sha256,
        units=scan.units,
        up_axis=scan.up_axis,
        colours=None if colours is None else (1.0 - t) * colours[first] + t * colours[second],
        labels=None if scan.labels is None else scan.labels[first],
        repairs=(*scan.repairs, *surface.repairs),
        unseen=border[first] & border[second],
    )


def _average_marks(vertices: np.ndarray, half_edges: HalfEdges, cloth: np.ndarray) -> np.ndarray:
    """Average marks along the surface over `CUT_SMOOTHING_STD`, shape [vertex_count].

    An iteration f <- f / 2 + (mean over neighbours) / 2 adds a variance of edge^2 / 4 in each direction.
    """
    tail, head = half_edges.tail, half_edges.head
    links = adjacency_matrix(np.stack([tail, head], axis=1), len(vertices))
    degree = np.maximum(np.asarray(links.sum(axis=1)).ravel(), 1.0)
    edge = float(np.median(np.linalg.norm(vertices[tail] - vertices[head], axis=1)))
    field = cloth.astype(np.float64)
    for _ in range(int(np.clip(round(4.0 * (CUT_SMOOTHING_STD / edge) ** 2), 1, MAX_CUT_SMOOTHING_ITERATIONS))):
        field = 0.5 * field + 0.5 * (links @ field) / degree
    return field


def _cut_level(
    vertices: np.ndarray, half_edges: HalfEdges, field: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Keep where field > 1/2; return vertices, faces, and of each vertex its edge [n, 2] and the share along it [n]."""
    faces, inside = half_edges.faces, field > 0.5
    edges, edge = half_edges.edges, half_edges.edge
    crossed = np.flatnonzero(inside[edges[:, 0]] != inside[edges[:, 1]])
    a, b = edges[crossed].T
    share = np.clip((0.5 - field[a]) / (field[b] - field[a]), MIN_CUT_EDGE_SHARE, 1.0 - MIN_CUT_EDGE_SHARE)
    place = np.full(len(edges), -1)
    place[crossed] = len(vertices) + np.arange(len(crossed))
    points = np.concatenate([vertices, (1.0 - share)[:, None] * vertices[a] + share[:, None] * vertices[b]])
    count = inside[faces].sum(axis=1)
    kept = [faces[count == 3]]
    of_face = place[edge.reshape(-1, 3)]
    for number in (1, 2):
        # Turn each face until the corner that differs from the two others comes first.
        rows = np.flatnonzero(count == number)
        single = np.argmax(inside[faces[rows]] == (number == 1), axis=1)
        turn = (single[:, None] + np.arange(3)) % 3
        corner = np.take_along_axis(faces[rows], turn, axis=1)
        cut = np.take_along_axis(of_face[rows], turn, axis=1)
        first, last = cut[:, 0], cut[:, 2]
        if number == 1:
            kept.append(np.stack([corner[:, 0], first, last], axis=1))
        else:
            kept.append(np.stack([first, corner[:, 1], corner[:, 2]], axis=1))
            kept.append(np.stack([first, corner[:, 2], last], axis=1))
    numbers = np.arange(len(vertices))
    ends = np.concatenate([np.stack([numbers, numbers], axis=1), edges[crossed]])
    return points, np.concatenate(kept), ends, np.concatenate([np.zeros(len(vertices)), share])
