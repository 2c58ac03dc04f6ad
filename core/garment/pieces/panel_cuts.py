"""Cut flat panels by lines that are level or upright in their places."""

from __future__ import annotations

import numpy as np

from ..orientation import place_points
from ..pattern import Panel
from .finished_points import Line


def cut_level(panel: Panel, outline: np.ndarray, height: float) -> list[np.ndarray]:
    """Return the parts within a panel's outline of its level line at a height in its place [m], shape [2, 2] each."""
    return _cut_outline(outline, panel.rotation[1, :2], height - float(panel.translation[1]))


def cut_upright(panel: Panel, outline: np.ndarray, x: float, top: float) -> list[Line]:
    """Return the part of a panel's upright line at x in its place [m], below a height; across gaps, such as a vent."""
    found = _cut_outline(outline, panel.rotation[0, :2], x - float(panel.translation[0]))
    below = [one for one in found if place_points(panel, one)[:, 1].min() < top - 1e-6]
    if not below:
        return []
    points = np.concatenate(below)
    heights = place_points(panel, points)[:, 1]
    return [(panel.name, points[[heights.argmax(), heights.argmin()]])]


def _cut_outline(outline: np.ndarray, normal: np.ndarray, level: float) -> list[np.ndarray]:
    """Return the parts within an outline, shape [n, 2], of the line normal . p = level, shape [2, 2] each."""
    length = float(np.linalg.norm(normal))
    if length < 1e-6:
        return []
    unit, level = normal / length, level / length
    along = np.array([-unit[1], unit[0]])
    side = outline @ unit - level
    after = np.roll(side, -1)
    crossed = np.flatnonzero((side > 0.0) != (after > 0.0))
    share = side[crossed] / (side[crossed] - after[crossed])
    points = outline[crossed] + share[:, None] * (np.roll(outline, -1, axis=0)[crossed] - outline[crossed])
    points = points[np.argsort(points @ along)]
    return [points[i : i + 2] for i in range(0, len(points) - 1, 2)]


def walk_along(points: np.ndarray, distance: float) -> np.ndarray:
    """Return the point of a polyline, shape [n, 2], at a distance along it [m]; its end where it is shorter."""
    steps = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return np.array([np.interp(distance, steps, points[:, k]) for k in range(2)])


def chord_through(outline: np.ndarray, point: np.ndarray, axis: np.ndarray) -> np.ndarray | None:
    """Return the chord of an outline that is square to an axis and passes nearest to a point, shape [2, 2]."""
    found = _cut_outline(outline, axis, float(axis @ point))
    if not found:
        return None
    along = np.array([-axis[1], axis[0]])
    at = float(along @ point)
    return min(found, key=lambda one: float(np.abs(one @ along - at).min()))
