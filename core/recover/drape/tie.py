"""Tie a garment's contour to the same contour of a scan: where a waistband's friction holds it."""

from __future__ import annotations

import numpy as np

from ...cloth.pins import Pins
from ...garment.garment import Garment
from ...geometry.curves import ClosedCurve
from ...scan.contours.loop import smooth_ragged_loop
from ...scan.contours.target import Target
from .waist import waist_loop

LOOP_START_COUNT = 360
"""Number of places along the curve at which the loop may start: 3 mm apart on a waist."""

MIN_SMOOTHED_WAIST_SHARE = 0.95
"""Share of its length that a waist keeps when it is smoothed, below which it has the teeth of a border that labels cut
along triangles: four such kept 0.83 to 0.94, ten that garments end at 0.97 to 0.998."""


def tie_contour(loop: np.ndarray, curve: np.ndarray, lengths: np.ndarray | None = None) -> np.ndarray:
    """Return each point of a closed loop its place on a closed curve [m], shape [loop_count, 3].

    The loop is spread over the curve in proportion to the lengths, and both run in the same sense of rotation; of
    `LOOP_START_COUNT` starts on the curve the one counts that moves the loop least (sum of squares).

    Args:
        loop: Points of the garment's contour in order [m], shape [loop_count, 3].
        curve: Points of the scan's contour in order [m], shape [curve_count, 3].
        lengths: Length from each point of the loop to the next [m], shape [loop_count]; without it their distances.
    """
    lengths = ClosedCurve(loop).lengths if lengths is None else lengths
    starts = np.linspace(0.0, 1.0, LOOP_START_COUNT, endpoint=False)
    shares = (np.cumsum(lengths) - lengths) / lengths.sum() + starts[:, None]
    places = np.concatenate([ClosedCurve(line).at_shares(shares) for line in (curve, curve[::-1])])
    return np.asarray(places[((places - loop) ** 2).sum(axis=(1, 2)).argmin()])


def place_waist(points: np.ndarray, target: Target | None, lengths: np.ndarray | None = None) -> np.ndarray:
    """Find where a waist contour sits: on the target's waist, or where it is if none is known of the target.

    The teeth of a waist that labels cut along triangles are smoothed: their length would count, and cloth would lie
    crumpled where they are longest, and be drawn out elsewhere.

    Args:
        points: The garment's waist in order [m], shape [n, 3].
        target: The scan with its contours, or None.
        lengths: How the waist is spread (`tie_contour`).

    Returns:
        Places of the points [m], shape [n, 3].
    """
    waist = None if target is None else target.waist
    if target is None or waist is None:
        return points
    curve = target.vertices[waist.vertices]
    smooth = smooth_ragged_loop(curve)
    is_toothed = ClosedCurve(smooth).length < MIN_SMOOTHED_WAIST_SHARE * ClosedCurve(curve).length
    return tie_contour(points, smooth if is_toothed else curve, lengths)


def pin_waist(garment: Garment, target: Target | None = None) -> Pins | None:
    """Pin what hangs from the waist where it sits (`place_waist`), spread as it is; None for what does not."""
    waist = waist_loop(garment)
    return None if waist is None else Pins(waist, place_waist(garment.nodes[waist], target))
