"""Find the places of a garment cut out of a person's scan that show what lies beyond its border."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ...geometry import HalfEdges
from ...scan.coloured import ColouredScan

BESIDE_CUT = 0.015
"""Distance from the cut up to which a surface may be another part's [m]; on the shipped example all that was, was."""

NEIGHBOURS = 8
"""Vertices further in whose mean colour is what a vertex near the cut is compared with."""

UNLIKE = 3.0
"""Difference from the cloth further in, by what cloth usually differs there, from which a vertex is another part's: of
normal noise in three channels one vertex in 4000 is."""


def find_beyond(scan: ColouredScan) -> np.ndarray:
    """Return which vertices of a garment that was cut out of a person show skin, or the inside of the cloth.

    A vertex near the cut is compared with the mean of the nearest ones beyond `BESIDE_CUT`; how much such a mean
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
    near = np.flatnonzero(distance < BESIDE_CUT)
    further = np.flatnonzero((distance >= BESIDE_CUT) & (distance < 2.0 * BESIDE_CUT))
    inside = np.flatnonzero(distance >= 2.0 * BESIDE_CUT)
    if len(inside) < NEIGHBOURS or not len(further):
        return found
    usual = np.median(_differ(scan.vertices, colours, further, inside))
    own = _differ(scan.vertices, colours, near, np.concatenate([further, inside]))
    found[near[own > max(UNLIKE * float(usual), 1.0)]] = True  # colours are whole numbers
    return found


def _differ(vertices: np.ndarray, colours: np.ndarray, chosen: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return how far the colours of some vertices are from the mean of the nearest others', shape [n]."""
    count = min(NEIGHBOURS, len(others))
    nearest = cKDTree(vertices[others]).query(vertices[chosen], k=np.arange(1, count + 1))[1]
    return np.asarray(np.linalg.norm(colours[chosen] - colours[others][nearest].mean(axis=1), axis=1))
