"""Find the lap of a wrapped front: an edge that goes on beyond the point of a V neck, on the other front."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_erosion, correlate1d

from ...body.body import Body
from ...scan.contours.contours import arc_length
from ...scan.contours.target import Target
from .front_heights import CELL_SIZE, FRONT_HALF_WIDTH, FrontHeights, front_frame
from .neck_finish import RARE_COST, ShownSides


@dataclass(frozen=True)
class LapSettings:
    """Describe how the step of a lap is looked for.

    Attributes:
        window: Distance from a line up to which heights count [m]: two cells of a fused scan, and less than a fold.
        gap: Distance from a line within which they do not [m]: what fusing rounds.
        max_step: Step above which a place of a line counts no more [m], so that one fold is no lap.
        lengths: Lengths of the lines [m], from the point of the V towards the side, 20 to 35 cm away.
        turns: Least and largest turn of a line downwards from the right front's seen edge [rad]: the edge is straight
            as cut, and hangs more steeply below the point of the V.
        turn_step: Between two lines [rad].
        offsets: Least and largest distance of a line below the border's lowest point [m]: the border of a fused surface
            lies up to 18 mm within the cloth.
        margin: Distance beyond `offsets` from which lines show what folds and noise make [m]: `window`, where a lap
            would still be felt.
        least_scatter: Scatter of steps that is always reckoned with [m]: the thickness of light cloth.
        plain_score, lap_score, score_std: Mean scores of fronts in one piece and of laps, and the standard deviation of
            the former [1], of 20 plain and 13 wrapped tops that were draped and scanned on persons.
    """

    window: float = 0.018
    gap: float = 0.003
    max_step: float = 0.004
    lengths: tuple[float, ...] = (0.16, 0.22, 0.28)
    turns: tuple[float, float] = (float(np.radians(2.5)), float(np.radians(15.0)))
    turn_step: float = float(np.radians(2.5))
    offsets: tuple[float, float] = (-0.003, 0.018)
    margin: float = 0.018
    least_scatter: float = 0.0002
    plain_score: float = 1.1
    lap_score: float = 3.3
    score_std: float = 0.6

    def log_odds(self, score: float) -> float:
        """Return the logarithm of the ratio of likelihoods, of a lap to a front in one piece, of a score: both have
        normal densities of one deviation."""
        middle = 0.5 * (self.plain_score + self.lap_score)
        return (self.lap_score - self.plain_score) * (score - middle) / self.score_std**2

    def kernel(self) -> np.ndarray:
        """Return the weights of the heights across a line, a cell apart, that sum up to its step, shape [n].

        The least-squares fit of a + b s + d sign(s) / 2 for gap <= |s| <= window; the weights give d."""
        count = round(self.window / CELL_SIZE)
        place = np.arange(-count, count + 1) * CELL_SIZE
        counted = np.abs(place) >= self.gap
        basis = np.stack([np.ones(len(place)), place, 0.5 * np.sign(place)], axis=1)[counted]
        weights = np.zeros(len(place))
        weights[counted] = np.linalg.pinv(basis)[2]
        return weights


@dataclass(frozen=True)
class Lap:
    """Describe what a scan shows of a lap, the right front over the left one.

    Attributes:
        extent: Length of the outer front's edge beyond the point of the V [m].
        log_odds: Logarithm of the ratio of the likelihoods of what is seen with a lap and without; infinite where both
            edges are borders of the scan, as nothing else has them.
    """

    extent: float
    log_odds: float


def find_lap(
    target: Target, body: Body, sides: ShownSides = ShownSides.BOTH, settings: LapSettings = LapSettings()
) -> Lap | None:
    """Find a lap below the point of a neckline; None where nothing tells whether there is one.

    A garment that is scanned by itself shows it as the part `wrap` of its border, and rarely its outside alone.
    On one fused surface the outer front ends in a step along a line from the point of the V to the other side. Its
    score is how many standard deviations the best line's mean step is larger than that of the lines beside it, which
    folds and noise make.

    Args:
        target: The scan.
        body: The wearer.
        sides: The sides of the cloth that the scan shows.
        settings: Of the search.
    """
    neck, covered = target.contour("neck"), target.contour("wrap")
    if neck is None or not neck.trusted or target.contour("front.left") is not None:
        return None
    heights = FrontHeights.of(target, body)
    if covered is not None:
        line = target.vertices[covered.vertices]
        if heights is None or not _is_right_over((line - body.joint("neck")) @ front_frame(body), heights):
            return None
        farthest = int((line @ body.sideways("shoulder")).argmax())
        return Lap(arc_length(line[farthest:]) if len(line) - farthest > 2 else 0.0, np.inf)
    loop = (target.vertices[neck.vertices] - body.joint("neck")) @ front_frame(body)
    vee = _find_vee(loop)
    if heights is None or vee is None:
        return None
    scores, extent = [], 0.0
    for length in settings.lengths:
        score, extent = _score_lines(heights, vee, length, settings)
        scores.append(score)
    rare = 0.5 * RARE_COST**2 if sides is ShownSides.BOTH else 0.0
    return Lap(extent, settings.log_odds(float(np.mean(scores))) - rare)


def _is_right_over(line: np.ndarray, heights: FrontHeights) -> bool:
    """Check whether the right front lies over the left one: its edge, the end of the covered border, has less before it
    than the left one's, the beginning.

    Args:
        line: The covered border to the left, above and ahead of the neck joint [m], shape [n, 3].
        heights: Of the front.
    """
    covered = []
    for edge in (line, line[::-1]):
        travel = np.linalg.norm(np.diff(edge, axis=0, prepend=edge[:1]), axis=1).cumsum()
        near = edge[travel < min(LapSettings.lengths)]
        covered.append(float(np.median(heights.sample(near[:, 0], near[:, 1])[0] - near[:, 2])))
    return covered[1] < covered[0]


VEE_HALF_WIDTH = 0.12
"""Distance from the middle within which a neckline's front lies [m]: that of wide side neck points."""

VEE_POINT_HEIGHT = 0.01
"""Height above a neckline's lowest place up to which its points are that of the V [m]: teeth of a cut."""

VEE_SIDE_OFFSET = 0.015
"""Distance aside of and above the point of a V from which points belong to a front's edge [m]."""


@dataclass(frozen=True)
class _Vee:
    """Describe the point of a V to the wearer's left and above the neck joint [m], shape [2], and how steeply the right
    front's edge goes down to it [rad]."""

    point: np.ndarray
    slope: float


def _find_vee(loop: np.ndarray) -> _Vee | None:
    """Return the point of a neckline and the slope of its right edge; None without points there.

    Args:
        loop: To the left, above and ahead of the neck joint [m], shape [n, 3].
    """
    front = loop[(loop[:, 2] > 0.0) & (np.abs(loop[:, 0]) < VEE_HALF_WIDTH)][:, :2]
    if not len(front):
        return None
    lowest = float(front[:, 1].min())
    point = front[front[:, 1] < lowest + VEE_POINT_HEIGHT].mean(axis=0)
    down = point - front[(front[:, 0] < point[0] - VEE_SIDE_OFFSET) & (front[:, 1] > lowest + VEE_SIDE_OFFSET)]
    if len(down) < 3:
        return None
    return _Vee(point, float(np.median(np.arctan2(-down[:, 1], down[:, 0]))))


def _score_lines(heights: FrontHeights, vee: _Vee, length: float, settings: LapSettings) -> tuple[float, float]:
    """Return the score of the best line of some length [m], and how far it goes on over cloth that is seen [m]."""
    first, last = settings.offsets
    best, extent, beside = -settings.max_step, 0.0, []
    for turn in np.arange(settings.turns[0], settings.turns[1] + 0.5 * settings.turn_step, settings.turn_step):
        offsets, steps, reach = _measure_steps(heights, vee, turn, length, settings)
        near = (offsets >= first) & (offsets <= last) & np.isfinite(steps)
        if near.any() and float(steps[near].max()) > best:
            one = int(np.flatnonzero(near)[steps[near].argmax()])
            best, extent = float(steps[one]), float(reach[one])
        beside.append(steps[(offsets < first - settings.margin) | (offsets > last + settings.margin)])
    others = np.concatenate(beside)
    others = others[np.isfinite(others)]
    if not len(others):
        return settings.plain_score, extent
    return float((best - others.mean()) / np.hypot(others.std(), settings.least_scatter)), extent


def _measure_steps(
    heights: FrontHeights, vee: _Vee, turn: float, length: float, settings: LapSettings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Measure the mean steps along lines that run beside each other.

    Args:
        heights: Of the front.
        vee: The point that one of them begins in, and its slope.
        turn: Of all lines downwards from this slope [rad].
        length: Of the lines [m].
        settings: Of the search.

    Returns:
        The lines' distances below the point [m], shape [n]; the mean height of the lower side over the upper one [m],
        NaN where less than half of a line is seen; and the length that is seen [m].
    """
    angle = vee.slope + turn
    right, down = np.cos(angle), np.sin(angle)
    along = np.arange(0.01, length, CELL_SIZE)[:, None]
    across = np.arange(-0.75 * FRONT_HALF_WIDTH, 0.75 * FRONT_HALF_WIDTH, CELL_SIZE)[None]
    x, y = vee.point[0] + along * right - across * down, vee.point[1] - along * down - across * right
    ahead, known = heights.sample(x, y)
    kernel = settings.kernel()
    steps = np.clip(correlate1d(ahead, kernel, axis=1), -settings.max_step, settings.max_step)
    counted = binary_erosion(known, np.ones((1, len(kernel)), dtype=bool))
    count = counted.sum(axis=0)
    mean = (steps * counted).sum(axis=0) / np.maximum(count, 1)
    return across[0], np.where(2 * count > len(along), mean, np.nan), count * CELL_SIZE
