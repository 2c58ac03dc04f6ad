"""Measure how much an open edge turns in its cloth, and find its corners."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.curves import Curve
from ...geometry.geometry import rim_turns
from .target import Contour, Target

NARROW_WINDOW_STD, BROAD_WINDOW_STD = 0.01, 0.02
"""Standard deviations of the windows over which an edge's turn is summed [m]: one and two edges of a scan's mesh."""

MIN_RIM_CORNER_ANGLE = np.radians(5.0)
"""Least turn of a corner of an outline [rad] (`core/garment/fairness.py`)."""

MIN_NARROW_TURN_RATIO = 0.7
"""Least ratio of a corner's turn in the narrow window to the broad one's: 1 at a corner, 0.5 on a wide curve."""

MIN_CORNER_NOISE_RATIO = 6.0
"""Least ratio of a corner's turn to the median along its edge: four standard deviations, which noise exceeds on one of
300 edges (50 independent windows each)."""

MIN_RIM_CORNER_DISTANCE = 0.08
"""Least distance of two corners of one edge [m]: four times `BROAD_WINDOW_STD`."""

MAX_EDGE_TURN_RMS = np.radians(2.5)
"""Largest root mean square of an edge's turn away from its corners for which these are accepted [rad]: simulated scans
have 0.0 to 1.5 degrees on hems, cut or noisy ones 10 to 40, and teeth of up to 260 degrees."""


@dataclass(frozen=True)
class EdgeTurn:
    """Describe how much an open edge turns in its cloth.

    At a vertex it turns by pi less the sum of its faces' angles there: as its pattern does, in whatever folds. Gaussian
    windows find corners anywhere on an edge. `recover/fit/rim_corners.py` tests given places, the ends of seams, and
    takes all turn within a box there, since registration finds such a place to a centimetre only.

    Attributes:
        places: Arc lengths along the edge [m], a quarter of `NARROW_WINDOW_STD` apart, shape [count].
        points: The edge there [m], shape [count, 3].
        length: Of the edge [m].
        turn: Turns around each place, weighted by a Gaussian as wide as `NARROW_WINDOW_STD` [rad], positive where the
            edge bulges out, shape [count].
        broad: The same with `BROAD_WINDOW_STD`.
    """

    places: np.ndarray
    points: np.ndarray
    length: float
    turn: np.ndarray
    broad: np.ndarray

    @classmethod
    def of(cls, line: np.ndarray, turns: np.ndarray) -> EdgeTurn:
        """Sum the turns of an edge.

        Args:
            line: Its vertices in order, closed [m], shape [n, 3].
            turns: At each [rad], shape [n].
        """
        curve = Curve(line)
        arc, length = curve.arc[:-1], float(curve.arc[-1])
        places = np.arange(0.0, length, NARROW_WINDOW_STD / 4)
        offset = (places[:, None] - arc[None] + length / 2) % length - length / 2
        turn, broad = (
            np.asarray(np.exp(-0.5 * (offset / width) ** 2) @ turns) for width in (NARROW_WINDOW_STD, BROAD_WINDOW_STD)
        )
        return cls(places, curve.at_shares(places / length), length, turn, broad)

    @classmethod
    def of_target(cls, contour: Contour, target: Target) -> EdgeTurn:
        """Sum the turns of a target's edge."""
        turns = rim_turns(target.vertices[target.faces], target.faces, contour.vertices)
        return cls.of(target.vertices[contour.vertices], turns)

    def corners(self) -> list[int]:
        """Return the indices of the places that are corners, the largest turn first."""
        turn, broad = np.abs(self.turn), np.abs(self.broad)
        least = max(MIN_RIM_CORNER_ANGLE, MIN_CORNER_NOISE_RATIO * float(np.median(turn)))
        found: list[int] = []
        for place in np.argsort(-turn):
            if turn[place] < least:
                break
            if (self._distance(self.places[[place]], found) > MIN_RIM_CORNER_DISTANCE).all() and turn[
                place
            ] > MIN_NARROW_TURN_RATIO * broad[place]:
                found.append(int(place))
        return found

    def is_clear(self, corners: list[int]) -> bool:
        """Check whether the edge turns little enough, away from its corners, for these to be accepted.

        Places within half of `MIN_RIM_CORNER_DISTANCE` of a corner do not count; without others the result is False.
        """
        elsewhere = self.turn[(self._distance(self.places, corners) > MIN_RIM_CORNER_DISTANCE / 2).all(axis=1)]
        return len(elsewhere) > 0 and float(np.sqrt(np.mean(elsewhere**2))) <= MAX_EDGE_TURN_RMS

    def _distance(self, places: np.ndarray, chosen: list[int]) -> np.ndarray:
        """Return distances of arc lengths from some of its places along the edge [m], shape [n, len(chosen)]."""
        offset = places[:, None] - self.places[chosen][None]
        return np.asarray(np.abs((offset + self.length / 2) % self.length - self.length / 2))
