"""Tie a garment's contour to the same contour of a scan: where a waistband's friction holds it."""

from __future__ import annotations

import numpy as np

from ..pattern import Garment
from ..segment import Target
from ..simulate import Pins
from .dress import waist_loop


def tie_contour(loop: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """Give each point of a closed loop its place on a closed curve [m], shape [loop_count, 3].

    Both are parametrised by arc length in the same sense of rotation; the start on the curve is the one, of 360, that
    moves the loop least (sum of squares).

    Args:
        loop: Points of the garment's contour in order [m], shape [loop_count, 3].
        curve: Points of the scan's contour in order [m], shape [curve_count, 3].
    """
    steps = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
    share = np.concatenate([[0.0], np.cumsum(steps)[:-1]]) / steps.sum()
    best, best_cost = loop, np.inf
    for candidate in (curve, curve[::-1]):
        closed = np.concatenate([candidate, candidate[:1]])
        arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
        arc /= arc[-1]
        for start in np.linspace(0.0, 1.0, 360, endpoint=False):
            at = (share + start) % 1.0
            points = np.stack([np.interp(at, arc, closed[:, k]) for k in range(3)], axis=1)
            cost = float(((points - loop) ** 2).sum())
            if cost < best_cost:
                best, best_cost = points, cost
    return best


def place_waist(points: np.ndarray, target: Target | None) -> np.ndarray:
    """Find where a waist contour sits: on the target's waist, or where it is if the target has none.

    Args:
        points: The garment's waist in order [m], shape [n, 3].
        target: The scan with its contours, or None.
    """
    waist = None if target is None else target.contour("waist")
    if target is None or waist is None:
        return points
    return tie_contour(points, target.vertices[waist.vertices])


def pin_waist(garment: Garment, target: Target | None = None) -> Pins | None:
    """Pin what hangs from the waist where it sits (`place_waist`); None for what hangs from the shoulders."""
    waist = waist_loop(garment)
    return None if waist is None else Pins(waist, place_waist(garment.nodes[waist], target))
