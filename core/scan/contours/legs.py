"""Split a hem around both legs: where trouser legs touch, a scan joins them, and their hems become one loop."""

from __future__ import annotations

import numpy as np

from ...geometry.curves import Curve
from .loop import smoothed_length

MAX_PINCH_CHORD_RATIO = 0.15
"""Largest ratio of the chord across a pinch to the shorter way around: 0.01 to 0.05 where scanned legs touch; 0.6 for a
round skirt's hem, 0.25 for one four times as wide as deep."""

MAX_PINCH_CHORD = 0.08
"""Largest chord across a pinch [m]: scanned legs touch to within 3 cm. Tiered hems of 2.5 to 3.4 m have chords of 15 to
18 cm across folds, which are short only relative to their length."""

MIN_LEG_HEM_SHARE = 0.25
"""Least share of the loop's length on either side of a pinch: two legs are alike."""

MAX_PINCH_POINT_COUNT = 600
"""Largest number of points that are compared in pairs; of a longer loop every second, third, ... point is."""


def split_legs(points: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Split a closed curve at its narrowest pinch, if it has one: an eight that is nearly closed in the middle.

    Ways around are measured along the smoothed curve, since noise makes a ragged one half as long again.

    Args:
        points: Along the curve [m], shape [n, 3].

    Returns:
        Indices of the points of the two parts, each in order, closed across the pinch; or None.
    """
    stride = -(-len(points) // MAX_PINCH_POINT_COUNT)
    coarse = points[::stride]
    if len(coarse) < 8:
        return None
    steps = Curve(coarse).lengths * (smoothed_length(points) / Curve(coarse).length)
    place = np.concatenate([[0.0], np.cumsum(steps)[:-1]])
    length = float(steps.sum())
    arc = np.abs(place[:, None] - place)
    arc = np.minimum(arc, length - arc)
    chord = np.linalg.norm(coarse[:, None] - coarse, axis=2)
    ratio = np.where(arc >= MIN_LEG_HEM_SHARE * length, chord / np.maximum(arc, 1e-12), np.inf)
    i, j = sorted(int(k) for k in np.unravel_index(ratio.argmin(), ratio.shape))
    if ratio[i, j] > MAX_PINCH_CHORD_RATIO or chord[i, j] > MAX_PINCH_CHORD:
        return None
    i, j = i * stride, j * stride
    return np.arange(i, j + 1), np.concatenate([np.arange(j, len(points)), np.arange(i + 1)])
