"""Find parts of a garment cut out of a person's scan that show something beyond its border."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ...geometry.connectivity import HalfEdges
from ...scan.coloured import ColouredScan

CUT_MARGIN_WIDTH = 0.015
"""Largest distance from the cut of a surface that may be another part's [m]; on the shipped example all was nearer."""

INNER_NEIGHBOUR_COUNT = 8
"""Number of inner vertices whose mean colour is compared with that of a vertex near the cut."""

COLOUR_OUTLIER_RATIO = 3.0
"""Smallest ratio of a vertex's colour difference from the inner cloth to the usual difference there at which the vertex
is another part's. Normal noise in three channels exceeds it for one vertex in 4000."""


def find_foreign_vertices(scan: ColouredScan) -> np.ndarray:
    """Find the vertices of a garment cut out of a person that show skin, or the inside of the cloth.

    A vertex near the cut is compared with the mean of the nearest ones beyond `CUT_MARGIN_WIDTH`; the usual difference
    is measured one width further in. A narrower trim of another colour is taken for another part.

    Args:
        scan: The garment with colours of its vertices.

    Returns:
        True for another part's vertices, shape [vertex_count].
    """
    found = np.zeros(len(scan.vertices), dtype=bool)
    border = HalfEdges.of(scan.faces, len(scan.vertices)).border_vertices
    if scan.colours is None or not border.any():
        return found
    colours = scan.colours.astype(np.float64)
    distance = cKDTree(scan.vertices[border]).query(scan.vertices)[0]
    at_cut = np.flatnonzero(distance < CUT_MARGIN_WIDTH)
    further = np.flatnonzero((distance >= CUT_MARGIN_WIDTH) & (distance < 2.0 * CUT_MARGIN_WIDTH))
    inside = np.flatnonzero(distance >= 2.0 * CUT_MARGIN_WIDTH)
    if len(inside) < INNER_NEIGHBOUR_COUNT or not len(further):
        return found
    usual = np.median(_colour_differences(scan.vertices, colours, further, inside))
    difference = _colour_differences(scan.vertices, colours, at_cut, np.concatenate([further, inside]))
    found[at_cut[difference > max(COLOUR_OUTLIER_RATIO * float(usual), 1.0)]] = True  # colours are whole numbers
    return found


def _colour_differences(
    vertices: np.ndarray, colours: np.ndarray, chosen: np.ndarray, others: np.ndarray
) -> np.ndarray:
    """Return the distances of vertices' colours from the mean of the nearest others', shape [n]."""
    count = min(INNER_NEIGHBOUR_COUNT, len(others))
    nearest = cKDTree(vertices[others]).query(vertices[chosen], k=np.arange(1, count + 1))[1]
    return np.asarray(np.linalg.norm(colours[chosen] - colours[others][nearest].mean(axis=1), axis=1))
