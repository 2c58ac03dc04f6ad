"""Check a panel's outline: its edges have lengths, it encloses an area and does not cross itself."""

from __future__ import annotations

import numpy as np

from .curves import chord, panel_outline
from .errors import PanelCrossing, PanelDegenerate, Place
from .pattern import Panel
from .polygon import polygon_area

CROSSING_SEGMENT_COUNT = 12
"""Number of segments of a curve in the crossing test; a drawn curve is then within 1 % of the chords of them."""

MIN_PANEL_AREA = 1e-6
"""Smallest area of a panel [m2]: a square of 1 mm."""


MIN_PANEL_EDGE_LENGTH = 1e-6
"""Smallest length of a panel's edge, from end to end [m]."""


def check_outline(panel: Panel) -> None:
    """Check that a panel's edges have lengths, that it has an area, and that its outline does not cross itself.

    Raises:
        PanelDegenerate, PanelCrossing: with the panel and the place.
    """
    for index in range(len(panel.edges)):
        start, end = chord(panel, index)
        if np.linalg.norm(end - start) < MIN_PANEL_EDGE_LENGTH:
            place = Place(panel.name, edge=index, vertex=index, point=_pair(start))
            raise PanelDegenerate(f"panel '{panel.name}' edge {index} has no length; remove it.", place)
    owner, polygon = _outline(panel)
    crossing = find_crossing(polygon)
    if crossing is not None:
        point = _meet(polygon, *crossing)
        places = [Place(panel.name, edge=int(owner[k]), point=point) for k in crossing]
        raise PanelCrossing(
            f"the outline of panel '{panel.name}' crosses itself; redraw it as a simple closed loop.", *places
        )
    if abs(polygon_area(polygon)) < MIN_PANEL_AREA:
        raise PanelDegenerate(
            f"panel '{panel.name}' has no area; remove it or check the file's units.", Place(panel.name)
        )


def find_crossing(polygon: np.ndarray) -> tuple[int, int] | None:
    """Find two segments of a closed polygon, shape [n, 2], that cross in their insides, by their first corners."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    count = len(polygon)
    low, high = np.minimum(start, end), np.maximum(start, end)
    left, right = low[:, 0].copy(), high[:, 0].copy()  # contiguous in memory: most pairs are excluded by these
    for i in range(count - 2):
        others = slice(i + 2, count - 1 if i == 0 else count)
        other = i + 2 + np.flatnonzero((left[others] <= right[i]) & (right[others] >= left[i]))
        other = other[(low[other, 1] <= high[i, 1]) & (high[other, 1] >= low[i, 1])]
        if not len(other):
            continue
        one = _side(start[i], end[i], start[other]) * _side(start[i], end[i], end[other])
        two = _side(start[other], end[other], start[i]) * _side(start[other], end[other], end[i])
        crossed = (one < 0) & (two < 0)
        if np.any(crossed):
            return i, int(other[np.argmax(crossed)])
    return None


def _outline(panel: Panel) -> tuple[np.ndarray, np.ndarray]:
    """Return the edge of each segment of a panel's outline, shape [n], and its corners [m], shape [n, 2]."""
    counts = [1 if edge.kind == "line" else CROSSING_SEGMENT_COUNT for edge in panel.edges]
    return np.repeat(np.arange(len(counts)), counts), panel_outline(panel, CROSSING_SEGMENT_COUNT)


def _meet(polygon: np.ndarray, i: int, j: int) -> tuple[float, float]:
    """Return the crossing of the segments i and j of a polygon."""
    count = len(polygon)
    a, u = polygon[i], polygon[(i + 1) % count] - polygon[i]
    b, v = polygon[j], polygon[(j + 1) % count] - polygon[j]
    along = ((b - a)[0] * v[1] - (b - a)[1] * v[0]) / (u[0] * v[1] - u[1] * v[0])
    return _pair(a + along * u)


def _pair(point: np.ndarray) -> tuple[float, float]:
    return float(point[0]), float(point[1])


def _side(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return the sign of the turn a -> b -> c, zero within rounding (1e-12 m2)."""
    turn = (b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]
    return np.where(np.abs(turn) < 1e-12, 0.0, np.sign(turn))
