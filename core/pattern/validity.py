"""Checks of a panel's outline: it encloses an area and does not cross itself."""

from __future__ import annotations

import numpy as np

from .curves import panel_outline
from .errors import PanelCrossing, PanelDegenerate
from .pattern import Panel
from .polygon import polygon_area

SEGMENTS = 12
"""Segments to a curve for the crossing test; a drawn curve then strays from its chords by less than 1 % of them."""

LEAST_AREA = 1e-6
"""The smallest area of a panel [m2]: a square of 1 mm."""


def check_outline(panel: Panel) -> None:
    """Refuse a panel without area or with an outline that crosses itself.

    Raises:
        PanelDegenerate, PanelCrossing: naming the panel.
    """
    polygon = panel_outline(panel, SEGMENTS)
    if crosses_itself(polygon):
        raise PanelCrossing(f"the outline of panel '{panel.name}' crosses itself; redraw it as a simple closed loop.")
    if abs(polygon_area(polygon)) < LEAST_AREA:
        raise PanelDegenerate(f"panel '{panel.name}' has no area; remove it or check the file's units.")


def crosses_itself(polygon: np.ndarray) -> bool:
    """Tell whether two segments of a closed polygon, shape [n, 2], cross in their insides."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    count = len(polygon)
    low, high = np.minimum(start, end), np.maximum(start, end)
    for i in range(count - 2):
        other = np.arange(i + 2, count - 1 if i == 0 else count)
        near = np.all((low[other] <= high[i]) & (high[other] >= low[i]), axis=1)
        other = other[near]
        if not len(other):
            continue
        one = _side(start[i], end[i], start[other]) * _side(start[i], end[i], end[other])
        two = _side(start[other], end[other], start[i]) * _side(start[other], end[other], end[i])
        if np.any((one < 0) & (two < 0)):
            return True
    return False


def _side(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Give the sign of the turn a -> b -> c, zero within rounding (1e-12 m2)."""
    turn = (b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]
    return np.where(np.abs(turn) < 1e-12, 0.0, np.sign(turn))
