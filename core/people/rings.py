"""Find closed rings around unrolled limbs (hems, cuffs, waists and necklines) by dynamic programming."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import correlate1d, uniform_filter1d

from ..run.kernels import kernel
from .unrolled import LIMB_COLUMN_COUNT, STATION_STEP

STEP_ROW_COUNT = 6
"""Number of rows on either side to which lines are fitted for a step's height: 5 cm, over which hems are straight."""
MAX_RING_SLOPE = 3
"""Largest number of rows that a ring goes up or down from one column to the next: 45 degrees and more on every limb."""
BEND_COST = 0.8
"""Log-probability lost by a row up or down: a tilt of 10 cm and back costs what five columns of a clear step gain."""
HALF_CONFIDENCE_MARGIN = 8.0
"""Log-probability margin at which a ring is as likely wrong as right. Simulated sleeves' and legs' rings with margins
of 0 to 5, 5 to 15, 15 to 30 and more were within 2 cm of the true end in 0.21, 0.65, 0.67 and 0.81 of cases."""
CORRELATED_COLUMN_COUNT = 4.0
"""Number of columns whose evidence is as good as that of one: folds and the fit's errors are 3 to 8 cm wide."""
MIN_RING_DISTANCE = 0.04
"""Mean distance below which two rings count as one [m]; the second best ring is farther away."""

MIN_STEP_NOISE = 0.001
"""Least standard deviation of a step's noise [m]: that of a fit's errors. A scan's own noise is measured."""
MIN_RIDGE_NOISE = 0.05
"""Least standard deviation of the noise of a difference of curvature between rows, times 2 cm [1]."""
CONTRAST_NOISE = 6.0
"""Difference of mean colour [CIE76, lightness by 0.4] that shade and prints make over 10 cm."""
EDGELESS_CELL_SHARE = 0.6
"""Share of a limb's cells without an edge, whose values give the noise: a limb with frills needs stronger edges."""


@dataclass(frozen=True)
class Ring:
    """Describe the best ring and its certainty.

    Attributes:
        rows: Row of its first cell beyond, for each column, shape [LIMB_COLUMN_COUNT].
        score: Its log-probability against no ring at all.
        second: The same of the best ring elsewhere.
        weights: Probability of each start row's best ring, shape [rows].
        paths: Those rings, shape [rows, LIMB_COLUMN_COUNT].
    """

    rows: np.ndarray
    score: float
    second: float
    weights: np.ndarray
    paths: np.ndarray

    @property
    def confidence(self) -> float:
        """Return the probability that it is within 2 cm of the true one: m / (m + `HALF_CONFIDENCE_MARGIN`).

        The margin m is the score less the second best ring's, or less 0 (no ring) where that is more.
        """
        margin = max(self.score - max(self.second, 0.0), 0.0)
        return margin / (margin + HALF_CONFIDENCE_MARGIN)

    def probability_beyond(self, rows: int) -> np.ndarray:
        """Compute the probability that each cell is beyond the ring, shape [rows, LIMB_COLUMN_COUNT]."""
        count = np.zeros((rows + 1, LIMB_COLUMN_COUNT))
        for weight, path in zip(self.weights, self.paths, strict=True):
            if weight > 1e-4:
                count[np.clip(path, 0, rows), np.arange(LIMB_COLUMN_COUNT)] += weight
        return np.asarray(np.clip(np.cumsum(count[:rows], axis=0), 0.0, 1.0))


def find_ring(
    edge: np.ndarray, region: np.ndarray | None = None, warmth: float = 1.0, bend_cost: float = BEND_COST
) -> Ring:
    """Find the best closed ring on an unrolled limb.

    A ring r(a) maximises sum over columns a of edge[r(a), a] + region gain - bend_cost |r(a + 1) - r(a)|, with steps of
    at most `MAX_RING_SLOPE` rows and r closed. The best one through each row of the first column is found by dynamic
    programming, so the best of all is the optimum, and their scores are a distribution over rings.

    Args:
        edge: Log-probability of an edge at each cell against none, shape [rows, LIMB_COLUMN_COUNT].
        region: Log-probability of each cell's being inside (smaller station) against beyond; a ring gains what is on
            its right side. None: nothing is known.
        warmth: Divisor of the scores for the probabilities of rings: above 1, evidence counts less.
        bend_cost: Log-probability that each row up or down costs.
    """
    gain = edge / CORRELATED_COLUMN_COUNT
    if region is not None:
        before = np.cumsum(region, axis=0) - region
        gain = gain + 2.0 * before - region.sum(axis=0)
    gain = np.ascontiguousarray(gain)
    scores, paths = _closed_paths(gain, bend_cost / CORRELATED_COLUMN_COUNT, MAX_RING_SLOPE)
    best = int(scores.argmax())
    is_distinct = np.abs(paths - paths[best]).mean(axis=1) * STATION_STEP > MIN_RING_DISTANCE
    second = float(scores[is_distinct].max()) if is_distinct.any() else -np.inf
    weights = np.exp((scores - scores[best]) / warmth)
    return Ring(paths[best], float(scores[best]), second, weights / weights.sum(), paths)


def score_ring(edge: np.ndarray, rows: np.ndarray, bend_cost: float = BEND_COST) -> float:
    """Compute the log-probability of a given ring against none, as `find_ring` does without a region.

    Args:
        edge: Log-probability of an edge at each cell against none, shape [rows, LIMB_COLUMN_COUNT].
        rows: Row of the ring's first cell beyond, for each column, shape [LIMB_COLUMN_COUNT].
        bend_cost: Log-probability that each row up or down costs.
    """
    bends = np.abs(np.diff(rows, append=rows[:1])).sum()
    return float(edge[rows, np.arange(len(rows))].sum() - bend_cost * bends) / CORRELATED_COLUMN_COUNT


@kernel()
def _closed_paths(gain, cost, steepest):  # type: ignore[no-untyped-def]
    """Return for each first row the score of the best closed path and the path."""
    rows, columns = gain.shape
    scores = np.full(rows, -np.inf)
    paths = np.zeros((rows, columns), dtype=np.int64)
    back = np.zeros((columns, rows), dtype=np.int64)
    for start in range(rows):
        value = np.full(rows, -np.inf)
        value[start] = gain[start, 0]
        for a in range(1, columns + 1):
            # A closed path cannot be further from its start than its remaining steps can return.
            reach = min(a, columns - a) * steepest
            fresh = np.full(rows, -np.inf)
            for r in range(max(start - reach, 0), min(start + reach + 1, rows)):
                best, at = -np.inf, r
                for q in range(max(r - steepest, 0), min(r + steepest + 1, rows)):
                    cost_here = value[q] - cost * abs(q - r)
                    if cost_here > best:
                        best, at = cost_here, q
                if a < columns:
                    fresh[r] = best + gain[r, a]
                    back[a, r] = at
                else:
                    scores[start] = best
                    r_last = at
            value = fresh
        r = r_last
        for a in range(columns - 1, 0, -1):
            paths[start, a] = r
            r = back[a, r]
        paths[start, 0] = start
    return scores, paths


def step_heights(offset: np.ndarray) -> np.ndarray:
    """Compute how much higher the side before each cell is than the side beyond [m], shape [rows, LIMB_COLUMN_COUNT].

    Straight lines are fitted to the `STEP_ROW_COUNT` rows before and those from the cell on, and compared at the cell's
    near edge: an even change along the limb (a sleeve that widens, a fit's error) is no step.
    """
    k = np.arange(STEP_ROW_COUNT) + 0.5
    line = 1 / STEP_ROW_COUNT - k.mean() * (k - k.mean()) / ((k - k.mean()) ** 2).sum()
    kernel = np.concatenate([line[::-1], -line])
    # The kernel is even in length: its middle is before the cell.
    return _smooth_columns(correlate1d(offset, kernel, axis=0, mode="nearest", origin=0))


def ridge_strengths(curvature: np.ndarray, rows: int = 2) -> np.ndarray:
    """Compute how much more convex the rows before each cell are than those beyond it, shape as given.

    Args:
        curvature: Mean of each cell, shape [rows, LIMB_COLUMN_COUNT].
        rows: Number of rows compared on either side.
    """
    kernel = np.concatenate([np.full(rows, 1 / rows), np.full(rows, -1 / rows)])
    return _smooth_columns(correlate1d(curvature, kernel, axis=0, mode="nearest", origin=0))


def _smooth_columns(values: np.ndarray) -> np.ndarray:
    """Average over five columns: a ring is nearly level over 3 to 10 cm, and noise is not."""
    return np.asarray(correlate1d(values, np.array([1.0, 2.0, 3.0, 2.0, 1.0]) / 9, axis=1, mode="wrap"))


CONTRAST_WINDOW_SIZE = (12, 17)
"""Number of rows on either side and of columns around, 10 cm and a third of the way, over which colours are averaged
for a comparison: wider than stripes and most prints, which are no edge."""


def colour_contrasts(colours: np.ndarray, window: tuple[int, int] = CONTRAST_WINDOW_SIZE) -> np.ndarray:
    """Compute the difference of mean colour before and beyond each cell, shape [rows, LIMB_COLUMN_COUNT].

    Args:
        colours: CIE Lab, shape [rows, LIMB_COLUMN_COUNT, 3].
        window: Rows on either side and columns around whose colours are averaged.
    """
    rows, columns = window
    kernel = np.concatenate([np.full(rows, 1 / rows), np.full(rows, -1 / rows)])
    difference = correlate1d(colours, kernel, axis=0, mode="nearest", origin=0)
    return np.asarray(np.linalg.norm(uniform_filter1d(difference, columns, axis=1, mode="wrap"), axis=2))


def edge_evidence(step: np.ndarray, ridge: np.ndarray, contrast: np.ndarray | None = None) -> np.ndarray:
    """Compute the log-probability of a garment's end at each cell against none, shape as given.

    Each cue x with noise s, the limb's own, counts as log N(x; 2 s, s) / N(x; 0, s) = 2 (x / s) - 2, clamped to the
    range -1.5 to 4: an edge is seen at twice the noise, and no cue excludes it alone.

    Args:
        step: Height of the garment's side over the other [m].
        ridge: Convexity of the garment's side over the other's, times 2 cm.
        contrast: Difference of colour, or None where there is none.
    """
    cues = [step / measure_noise(step, MIN_STEP_NOISE), ridge / measure_noise(ridge, MIN_RIDGE_NOISE)]
    if contrast is not None:
        cues.append(contrast / CONTRAST_NOISE)
    return np.asarray(sum(np.clip(2.0 * cue - 2.0, -1.5, 4.0) for cue in cues))


def measure_noise(values: np.ndarray, least: float) -> float:
    """Return the deviation of a normal with the values' `EDGELESS_CELL_SHARE` quantile of size, at least `least`."""
    return max(float(np.quantile(np.abs(values), EDGELESS_CELL_SHARE)) / 0.8416, least)
