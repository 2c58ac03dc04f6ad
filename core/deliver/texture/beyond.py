"""Find the places of a garment cut out of a person's scan that show what lies beyond its border."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ...geometry.connectivity import HalfEdges
from ...scan.coloured import ColouredScan

CUT_MARGIN_WIDTH = 0.015
"""Largest distance from the cut at which a surface may be another part's [m]. On the shipped example all foreign
surface was that near."""

INNER_NEIGHBOUR_COUNT = 8
"""Number of vertices further in whose mean colour a vertex near the cut is compared with."""

COLOUR_OUTLIER_RATIO = 3.0
"""Smallest ratio of a vertex's colour difference from the cloth further in to the usual difference there at which the
vertex is another part's. Of normal noise in three channels one vertex in 4000 exceeds it."""


def find_foreign_vertices(scan: ColouredScan) -> np.ndarray:
    """Return which vertices of a garment that was cut out of a person show skin, or the inside of the cloth.

    A vertex near the cut is compared with the mean of the nearest ones beyond `CUT_MARGIN_WIDTH`; how much such a mean
    usually differs from a vertex is measured one width further in. A trim that is narrower than that and of another
    colour is taken for another part.

    Args:
        scan: The garment with colours of its vertices.

    Returns:
        True for what is another part's, shape [vertex_count].
    """
    found = np.zeros(len(scan.vertices), dtype=bool)
    border = HalfEdges.of(scan.faces, len(scan.vertices)).border_vertices
    if scan.colours is None or not border.any():
        return found
    colours = scan.colours.astype(np.float64)
    distance = cKDTree(scan.vertices[border]).query(scan.vertices)[0]
    near = np.flatnonzero(distance < CUT_MARGIN_WIDTH)
    further = np.flatnonzero((distance >= CUT_MARGIN_WIDTH) & (distance < 2.0 * CUT_MARGIN_WIDTH))
    inside = np.flatnonzero(distance >= 2.0 * CUT_MARGIN_WIDTH)
    if len(inside) < INNER_NEIGHBOUR_COUNT or not len(further):
        return found
    usual = np.median(_colour_differences(scan.vertices, colours, further, inside))
    own = _colour_differences(scan.vertices, colours, near, np.concatenate([further, inside]))
    found[near[own > max(COLOUR_OUTLIER_RATIO * float(usual), 1.0)]] = True  # colours are whole numbers
    return found


def _colour_differences(
    vertices: np.ndarray, colours: np.ndarray, chosen: np.ndarray, others: np.ndarray
) -> np.ndarray:
    """Return how far the colours of some vertices are from the mean of the nearest others', shape [n]."""
    count = min(INNER_NEIGHBOUR_COUNT, len(others))
    nearest = cKDTree(vertices[others]).query(vertices[chosen], k=np.arange(1, count + 1))[1]
    return np.asarray(np.linalg.norm(colours[chosen] - colours[others][nearest].mean(axis=1), axis=1))
