"""Keep panels regular: no fold-over, smooth curves smooth, centre lines at right angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....garment.control import ControlMap, map_controls
from ....garment.curves import edge_points
from ....garment.garment import Garment
from ....garment.pattern import Panel, Pattern
from ....garment.symmetry import Symmetry, find_symmetry
from ....geometry.geometry import signed_areas

FOLD_PENALTY_AREA_SHARE = 0.3
"""Share of its area below which a flat triangle is penalised: well before it turns over."""

MAX_SMOOTH_TURN_ANGLE = np.radians(5.0)
"""Largest turn of the outline at a control point that counts as smooth [rad]; drawn corners are far sharper."""

RIGHT_ANGLE_TOLERANCE = np.radians(3.0)
"""Largest difference from a right angle, at the end of a centre line, that counts as right [rad]."""


@dataclass(frozen=True)
class PanelLoss:
    """Penalise flat triangles that shrink towards turning over, and changes of corners to be kept [m2].

        L = sum_f A_f relu(s - a_f / A_f)^2 + mean_c l_c^2 (turn_c - turn0_c)^2

    Notation: a_f area of flat triangle f [m2], A_f at first, s `FOLD_PENALTY_AREA_SHARE`; turn_c [rad] the outline's
    turn at a kept control point c, turn0_c in the template; l_c mean length of the two chords that meet there [m], so
    that l_c times an angle is the swing of an edge's end. Kept are points where the template's outline is smooth, and
    right angles at both ends of a centre line: a seam between an edge and its own mirror image.

    Attributes:
        control: The map from control points to the flat mesh.
        uv: The flat mesh at first [m], shape [uv_count, 2].
        uv_faces: Its triangles, shape [face_count, 3].
        before, points, after: The kept control points with their neighbours on the outline, shape [kept_count] each.
        turns: turn0 between the chords [rad], shape [kept_count].
        arms: l [m], shape [kept_count].
    """

    control: ControlMap
    uv: np.ndarray
    uv_faces: np.ndarray
    before: np.ndarray
    points: np.ndarray
    after: np.ndarray
    turns: np.ndarray
    arms: np.ndarray

    @classmethod
    def of(cls, garment: Garment, base: Pattern) -> PanelLoss:
        """Prepare for a meshed pattern; the template `base` gives the corners to keep."""
        corners = _kept_corners(base, find_symmetry(base))
        rows = np.array(corners, dtype=np.int64).reshape(-1, 3)
        points = base.points
        ends = points[rows]
        arms = 0.5 * np.linalg.norm(np.diff(ends, axis=1), axis=2).sum(1)
        turns = _turn(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 1])
        return cls(map_controls(garment), garment.uv, garment.uv_faces, rows[:, 0], rows[:, 1], rows[:, 2], turns, arms)

    def evaluate(self, points: np.ndarray) -> tuple[float, np.ndarray]:
        """Return L [m2] and dL/dc [m], shape [point_count, 2], at all control points [m], shape [point_count, 2]."""
        value, gradient = self._folds(points)
        if len(self.points):
            one, two = points[self.points] - points[self.before], points[self.after] - points[self.points]
            swung = _wrap(_turn(one, two) - self.turns)
            count = len(swung)
            value += float((self.arms**2 @ swung**2) / count)
            pull = (2.0 * self.arms**2 * swung / count)[:, None]
            by_one, by_two = -pull * _slope(one), pull * _slope(two)
            np.add.at(gradient, self.before, -by_one)
            np.add.at(gradient, self.points, by_one - by_two)
            np.add.at(gradient, self.after, by_two)
        return value, gradient

    def _folds(self, points: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the first sum and its gradient."""
        at = self.control.apply(points - self.control.points) + self.uv
        start = signed_areas(self.uv[self.uv_faces])
        corners = at[self.uv_faces]
        short = np.maximum(FOLD_PENALTY_AREA_SHARE - signed_areas(corners) / start, 0.0)
        # d(2 a)/d corner k is the opposite edge rotated by 90 degrees
        opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
        slope = np.stack([-opposite[..., 1], opposite[..., 0]], axis=-1)
        by_uv = np.zeros_like(at)
        np.add.at(by_uv, self.uv_faces, -short[:, None, None] * slope)
        return float(start @ short**2), self.control.pull_back(by_uv)


def _kept_corners(base: Pattern, symmetry: Symmetry) -> list[tuple[int, int, int]]:
    """Find the control points whose turn is kept, each with its neighbours, as indices into all control points."""
    centre = _centre_lines(base, symmetry)
    kept = []
    for panel, first in zip(base.panels, base.point_starts, strict=False):
        count = len(panel.points)
        for i in range(count):
            turn = _tangent_turn(panel, i)
            lines = {(panel.name, i), (panel.name, (i - 1) % count)} & centre
            if abs(turn) < MAX_SMOOTH_TURN_ANGLE or (lines and abs(abs(turn) - np.pi / 2) < RIGHT_ANGLE_TOLERANCE):
                kept.append((int(first) + (i - 1) % count, int(first) + i, int(first) + (i + 1) % count))
    return kept


def _centre_lines(base: Pattern, symmetry: Symmetry) -> set[tuple[str, int]]:
    """Return the edges (panel, edge) that are sewn to their own mirror image."""
    image = {}
    for mirror in symmetry.mirrors:
        source, target = base.panels[mirror.source].name, base.panels[mirror.target].name
        for i in range(len(mirror.order)):
            # edge i of the target runs backwards along edge order[i] - 1 of the source
            edge = int(mirror.order[i] - 1) % len(mirror.order)
            image[target, i] = (source, edge)
            image[source, edge] = (target, i)
    found = set()
    for seam in base.seams:
        one, two = (seam.a.panel, seam.a.edge), (seam.b.panel, seam.b.edge)
        if image.get(one) == two:
            found |= {one, two}
    return found


def _tangent_turn(panel: Panel, index: int) -> float:
    """Return the turn of the drawn outline at a control point [rad], between the tangents of its curves."""
    segments = 64
    into = edge_points(panel, (index - 1) % len(panel.points), segments)
    out = edge_points(panel, index, segments)
    return float(_turn((into[-1] - into[-2])[None], (out[1] - out[0])[None])[0])


def _turn(one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Return the signed angles between directions [rad], shape [n]."""
    cross = one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]
    return np.asarray(np.arctan2(cross, (one * two).sum(1)))


def _wrap(angle: np.ndarray) -> np.ndarray:
    """Wrap angles to -pi to pi."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


def _slope(direction: np.ndarray) -> np.ndarray:
    """Return the derivative of directions' angles by them [1/m], shape [n, 2]."""
    found: np.ndarray = np.stack([-direction[:, 1], direction[:, 0]], axis=1) / (direction**2).sum(1, keepdims=True)
    return found
