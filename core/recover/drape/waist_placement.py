"""Place a garment's waist on that of a scan, where a waistband's friction keeps it."""

from __future__ import annotations

import numpy as np

from ...cloth.pins import Pins
from ...garment.garment import Garment
from ...geometry.curves import Curve
from ...scan.contours.loop import smooth_ragged_loop
from ...scan.contours.target import Target
from .waist import waist_loop

LOOP_START_COUNT = 360
"""Number of places along the curve at which the loop may start: 3 mm apart on a waist."""

MIN_SMOOTHED_WAIST_SHARE = 0.95
"""Share of its length that a waist keeps when smoothed, below which it has teeth because labels cut its border along
triangles: four such kept 0.83 to 0.94, ten waists of garments that end there 0.97 to 0.998."""


def tie_contour(loop: np.ndarray, curve: np.ndarray, lengths: np.ndarray | None = None) -> np.ndarray:
    """Return the place of each point of a closed loop on a closed curve [m], shape [loop_count, 3].

    The loop is spread over the curve in proportion to the lengths. Of both directions and `LOOP_START_COUNT` starts on
    the curve, the one is taken that moves the loop least (sum of squares).

    Args:
        loop: Points of the garment's contour in order [m], shape [loop_count, 3].
        curve: Points of the scan's contour in order [m], shape [curve_count, 3].
        lengths: Length from each point of the loop to the next [m], shape [loop_count]; if None, their distances.
    """
    lengths = Curve(loop).lengths if lengths is None else lengths
    starts = np.linspace(0.0, 1.0, LOOP_START_COUNT, endpoint=False)
    shares = (np.cumsum(lengths) - lengths) / lengths.sum() + starts[:, None]
    places = np.concatenate([Curve(line).at_shares(shares) for line in (curve, curve[::-1])])
    return np.asarray(places[((places - loop) ** 2).sum(axis=(1, 2)).argmin()])


def place_waist(points: np.ndarray, target: Target | None, lengths: np.ndarray | None = None) -> np.ndarray:
    """Return the places of a waist contour's points [m], shape [n, 3]: on the target's waist, else unchanged.

    A waist with teeth (labels cut along triangles) is smoothed first: the teeth would add to its length, and the cloth
    would be crumpled where they are longest and stretched elsewhere.

    Args:
        points: The garment's waist in order [m], shape [n, 3].
        target: The scan with its contours, or None.
        lengths: How the waist is spread (`tie_contour`).
    """
    waist = None if target is None else target.waist
    if target is None or waist is None:
        return points
    curve = target.vertices[waist.vertices]
    smooth = smooth_ragged_loop(curve)
    is_toothed = Curve(smooth).length < MIN_SMOOTHED_WAIST_SHARE * Curve(curve).length
    return tie_contour(points, smooth if is_toothed else curve, lengths)


def pin_waist(garment: Garment, target: Target | None = None) -> Pins | None:
    """Return pins of a garment's waist at its place (`place_waist`), or None where it does not hang from the waist."""
    waist = waist_loop(garment)
    return None if waist is None else Pins(waist, place_waist(garment.nodes[waist], target))
