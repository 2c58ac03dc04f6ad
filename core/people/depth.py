"""How far below cloth the wearer is: by how much a body that was fitted below it is too thick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .limbs import BodyPlace, Limb
from .part import GARMENTS, PARTS, Part


@dataclass(frozen=True)
class Excess:
    """By how much a body that was fitted below loose cloth is too thick along a limb.

    Attributes:
        stations: Lengths along the limb, as `BodyPlace.station` [m].
        mean: By how much at each [m].
        spread: Standard deviation of that [m], from person to person and from point to point.
    """

    stations: tuple[float, ...]
    mean: tuple[float, ...]
    spread: tuple[float, ...]


HANGING = Excess(
    (0.10, 0.18, 0.26, 0.34, 0.42, 0.50, 0.58, 0.66, 0.74),
    (0.0015, 0.0035, 0.009, 0.0145, 0.016, 0.013, 0.010, 0.0095, 0.012),
    (0.004, 0.007, 0.011, 0.0135, 0.014, 0.0135, 0.011, 0.011, 0.015),
)
OVER = Excess(
    (0.10, 0.18, 0.26, 0.34, 0.42, 0.50, 0.58, 0.66, 0.74),
    (0.0045, 0.009, 0.016, 0.0235, 0.027, 0.021, 0.0175, 0.019, 0.025),
    (0.0045, 0.007, 0.009, 0.0125, 0.015, 0.014, 0.0125, 0.0145, 0.0195),
)
HELD = Excess(
    (0.42, 0.50, 0.58, 0.66, 0.74), (0.0065, 0.0055, 0.0075, 0.0115, 0.010), (0.0065, 0.0075, 0.009, 0.0115, 0.016)
)
ARM = Excess((0.0, 0.1, 0.2, 0.3, 0.4), (0.003, 0.0045, 0.005, 0.0075, 0.009), (0.006, 0.008, 0.008, 0.013, 0.016))
LEG = Excess(
    (0.0, 0.2, 0.4, 0.6, 0.8, 0.96),
    (0.007, 0.008, 0.0055, 0.007, 0.010, 0.012),
    (0.010, 0.010, 0.008, 0.009, 0.011, 0.014),
)
TRUNK = {Part.UPPER: HANGING, Part.ONE_PIECE: HANGING, Part.OUTER: OVER, Part.LOWER: HELD}
"""Of simulated persons (`training/depth.py`): what hangs from the shoulders spans the waist, and a body fitted below it
fills what it spans; what is worn over that spans more, and what the waist holds lies on it there."""

LIMBS = {Limb.LEFT_ARM: ARM, Limb.RIGHT_ARM: ARM, Limb.LEFT_LEG: LEG, Limb.RIGHT_LEG: LEG}
"""Likewise, whatever is worn there; nothing is known of what is worn around a neck."""

CHEST = 0.2
"""Station of the trunk [m] above which cloth rests on it, however loose it is."""

TIGHT, LOOSE = 0.002, 0.005
"""Median height of a garment over the fit [m] up to which it is as tight as skin, of which a fit is 2 mm off, and from
which the fit's excess is the full one: looser ones of simulated persons have hidden no more."""

FEWEST = 50
"""Samples of a garment below the chest that its looseness on the trunk is taken from; from all where there are less."""


def find_depth(place: BodyPlace, posterior: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find how far below each sample the wearer's surface is to be expected.

    The depth is max(h + l e, 0): h the sample's height over the fit, e the excess at its station, l from 0 to 1
    by the median h of its garment on its limb, from `TIGHT` to `LOOSE`.

    Args:
        place: Where the samples lie on the last fit.
        posterior: Of the parts, shape [n, part_count].

    Returns:
        The depth [m], NaN at what is likelier no garment, and its standard deviation [m], shape [n] each.
    """
    best = posterior.argmax(axis=1)
    depth, spread = np.full((2, len(best)), np.nan)
    for limb in (Limb.TRUNK, *LIMBS):
        for part in GARMENTS:
            excess = TRUNK[part] if limb is Limb.TRUNK else LIMBS[limb]
            mine = (place.limb == limb) & (best == PARTS.index(part))
            if mine.any():
                at, height = place.station[mine], place.offset[mine]
                hidden = find_looseness(height, at, limb) * np.interp(at, excess.stations, excess.mean)
                depth[mine] = np.maximum(height + hidden, 0.0)
                spread[mine] = np.interp(at, excess.stations, excess.spread)
    return depth, spread


def find_looseness(height: np.ndarray, station: np.ndarray, limb: Limb) -> float:
    """Find how loose a garment is on a limb, from 0 to 1, by the heights of its samples over the fit [m], shape [n]."""
    below = station > CHEST
    if limb is Limb.TRUNK and below.sum() >= FEWEST:
        height = height[below]
    return float(np.clip((np.median(height) - TIGHT) / (LOOSE - TIGHT), 0.0, 1.0))
