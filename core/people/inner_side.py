"""Find the inner side of cloth, seen through cuffs and under hems, which is no part of a garment's surface."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import Body
from ..geometry.connectivity import HalfEdges, find_components
from ..geometry.geometry import vertex_normals
from ..geometry.surface import TriangleSurface
from ..scan.scan import Scan

MAX_SCANNED_CLOTH_THICKNESS = 0.015
"""Largest distance between both sides of one cloth in a scan [m]: three cells of 4 mm of a fused surface, and noise."""

MIN_BACKED_SHARE = 0.3
"""Least share of an inward-facing piece with the outer side behind it: with less, the piece is a fold, or noise."""

MAX_MEAN_NORMAL_LENGTH = 2.0 / np.pi
"""Largest length of the mean of an inner side's unit normals [1]: that of half a tube, since it goes around a limb or
the trunk. The back of a pleat, which has the pleat's front behind it, faces one way."""

INNER_SIDE_QUERY_COUNT = 20_000
"""Approximate number of vertices at which an outer side is searched: every n-th of a dense scan."""

MIN_INNER_SIDE_COSINE = 0.3
"""Least cosine between a normal and the direction to the skin, and between both sides' normals, one reversed: 73
degrees. This finds 86 % of a person's insides that have a label of their own, and 0.3 % of the outer side."""


def find_inner_side(whole: Scan, is_garment: np.ndarray, body: Body, other: np.ndarray | None = None) -> np.ndarray:
    """Find the inner side of a garment's cloth, as far as it is seen through an opening, bool, shape [vertex_count].

    A piece that faces the skin is an inner side where it goes around the wearer, and the outer side of the same cloth
    is within `MAX_SCANNED_CLOTH_THICKNESS`, farther from the skin, for more than `MIN_BACKED_SHARE` of it. A recovery
    fits one sheet: with both, the sheet would turn inward at the hem, and its contours would be inside the garment.
    Part of an inner side in another colour may be labelled OTHER, so pieces extend over `other`.

    Args:
        whole: The person's surface.
        is_garment: The garment's vertices, bool, shape [vertex_count].
        body: The wearer.
        other: Vertices labelled OTHER, bool, shape [vertex_count], or None.
    """
    normals = vertex_normals(whole.vertices, whole.faces)
    edges = HalfEdges.of(whole.faces, len(whole.vertices))
    smooth = edges.adjacency @ normals + normals
    normals = smooth / np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-12)
    rows = np.flatnonzero(is_garment if other is None else is_garment | other)
    feet = TriangleSurface(body.vertices, body.faces).closest(whole.vertices[rows])
    offset = whole.vertices[rows] - feet.foot
    height = np.linalg.norm(offset, axis=1)
    facing = (normals[rows] * offset).sum(axis=1) < -MIN_INNER_SIDE_COSINE * height
    tree = cKDTree(whole.vertices[rows])
    queried = np.flatnonzero(facing)
    queried = queried[:: max(1, len(queried) // INNER_SIDE_QUERY_COUNT)]
    backed = np.zeros(len(queried), bool)
    for number, row in enumerate(queried):
        candidates = np.array(tree.query_ball_point(whole.vertices[rows[row]], MAX_SCANNED_CLOTH_THICKNESS))
        opposite = normals[rows[candidates]] @ normals[rows[row]] < -MIN_INNER_SIDE_COSINE
        backed[number] = bool((opposite & is_garment[rows[candidates]] & (height[candidates] > height[row])).any())
    turned = np.zeros(len(whole.vertices), bool)
    turned[rows[facing]] = True
    linked = turned[edges.tail] & turned[edges.head]
    count, piece = find_components(len(whole.vertices), edges.tail[linked], edges.head[linked])
    piece_of_query = piece[rows[queried]]
    shown = np.bincount(piece_of_query, backed, count) > MIN_BACKED_SHARE * np.bincount(piece_of_query, minlength=count)
    mean = np.stack([np.bincount(piece, turned * normals[:, axis], count) for axis in range(3)], axis=1)
    size = np.bincount(piece, turned, count)
    around = np.linalg.norm(mean, axis=1) <= MAX_MEAN_NORMAL_LENGTH * size
    return np.asarray(is_garment & turned & (shown & around)[piece])
