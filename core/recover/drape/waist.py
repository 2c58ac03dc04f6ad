"""Find the waist from which a garment hangs: its nodes and its flat length."""

from __future__ import annotations

import numpy as np

from ...garment.garment import Garment
from ...geometry.connectivity import HalfEdges
from ...scan.contours.loop import find_loops

MIN_FRONT_HEIGHT_SHARE = 0.5
"""Share of a garment's height over which a border runs, from which it is that of an open front [1]: it goes from the
hem to the neckline, a waist or a hem is level."""


def waist_loop(garment: Garment) -> np.ndarray | None:
    """Find the loop of nodes by which a garment hangs from the waist, or None where it hangs from the shoulders.

    A garment with at most three open contours has no neck and no arms: its highest contour is a waist (a tube top and a
    poncho are the exceptions; both then hang from where their highest contour is placed). The border of an open front
    is two of them, neckline and hem.
    """
    loops, height = find_loops(garment.faces), MIN_FRONT_HEIGHT_SHARE * float(np.ptp(garment.nodes[:, 1]))
    fronts = [loop for loop in loops if np.ptp(garment.nodes[loop, 1]) > height]
    if len(loops) + len(fronts) > 3 or not loops:
        return None
    return max(loops, key=lambda loop: garment.nodes[loop, 1].mean())


def flat_length(garment: Garment, loop: np.ndarray) -> float:
    """Compute the flat length of a loop of nodes [m]."""
    return float(flat_lengths(garment, loop).sum())


def flat_lengths(garment: Garment, loop: np.ndarray) -> np.ndarray:
    """Compute the flat length from each node of a loop along a border to the next [m], shape [loop_count]."""
    count, edges = len(garment.nodes), HalfEdges.of(garment.faces)
    sides = np.sort(np.column_stack([loop, np.roll(loop, -1)]), axis=1) @ [count, 1]
    order = np.argsort(sides)
    keys = (edges.edges @ [count, 1])[edges.edge]
    on_loop = np.isin(keys, sides)
    lengths = np.linalg.norm(np.roll(garment.rest, -1, axis=1) - garment.rest, axis=2).ravel()
    place = order[np.searchsorted(sides[order], keys[on_loop])]
    return np.bincount(place, lengths[on_loop], len(loop))
