"""Find seams at which stripes or checks turn, or end: where the direction of a scan's colours makes a step."""

from __future__ import annotations

import numpy as np

from .seam_strips import ROW_SPACING, SEARCH_STEP, SeamStrip, SeamTrace, pool_rows

ROWS_PER_PLACE = 5
"""Rows of a strip of stripes at each place along a seam [1]: one each 3 mm, a third of a narrow stripe."""

STRIPE_WINDOW_COLUMNS = 5
"""Width of the window across a seam in which a direction is averaged [1]: 1 cm, the edge of a stripe."""

STRIPE_COLOUR_NOISE = 0.05
"""Standard deviation of a camera's colours [1, of RGB in 0..1]."""

MIN_TURN_SHARE = 0.3
"""Share of the directions' variance that a turn explains [1]: of right angles half, since a camera's noise turns the
rest."""

MIN_STRIPE_CLEARNESS = 0.3
"""Mean weight of a row's directions from which it has stripes [1]: those of one side, or narrow ones on both."""

MIN_STRIPE_TURN = np.radians(15.0)
"""Angle between stripes at both sides of a seam from which they turn [rad]: more than cloth is cut off grain."""


def find_stripe_trace(strip: SeamStrip, colours: np.ndarray, blur: int) -> SeamTrace | None:
    """Find where stripes turn along a seam; None where they do not.

    Args:
        strip: The scan along the seam.
        colours: RGB in 0..1 of the points of a strip with `ROWS_PER_PLACE` rows for each of this one's, shape
            [ROWS_PER_PLACE * row_count, column_count, 3].
        blur: Columns before and behind a step in which the scan mixes both colours.
    """
    directions, clearness = measure_stripes(colours)
    return strip.trace(*find_turns(directions, clearness * strip.near, blur + STRIPE_WINDOW_COLUMNS // 2))


def measure_stripes(colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the direction of stripes at the points of a strip, shape [row_count, m, 2], and how clear it is, shape
    [row_count, m].

    With J the mean of the colours' squared gradients over a window (structure tensor; J. Bigun, G. Granlund 1987) the
    direction is (J_xx - J_yy, 2 J_xy) / (J_xx + J_yy): c (cos 2 a, sin 2 a) for stripes across the angle a with a
    coherence c. It counts by 1 - J_0 / (J_xx + J_yy), at least 0, with J_0 of a camera's noise.

    Args:
        colours: In 0..1, of a strip with `ROWS_PER_PLACE` rows a place, shape [row_count * ROWS_PER_PLACE, m,
            channel_count].
    """
    from scipy.ndimage import uniform_filter1d

    along = np.gradient(colours, ROW_SPACING / ROWS_PER_PLACE, axis=0)
    across = np.gradient(colours, SEARCH_STEP, axis=1)

    def average(one: np.ndarray, other: np.ndarray) -> np.ndarray:
        product = (one * other).sum(axis=2).reshape(-1, ROWS_PER_PLACE, colours.shape[1]).mean(axis=1)
        return np.asarray(uniform_filter1d(product, STRIPE_WINDOW_COLUMNS, axis=1, mode="nearest"))

    xx, yy, xy = average(across, across), average(along, along), average(across, along)
    noise = colours.shape[2] * (STRIPE_COLOUR_NOISE / SEARCH_STEP) ** 2
    energy = np.maximum(xx + yy, 1e-9)
    return np.stack([xx - yy, 2.0 * xy], axis=2) / energy[:, :, None], np.maximum(1.0 - noise / energy, 0.0)


def find_turns(directions: np.ndarray, weights: np.ndarray, blur: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Find where stripes turn once in each row.

    The turn is where the mean directions of both sides, but for what the scan blurs, explain most of the variance of
    directions in a row and its neighbours. It is seen where that is `MIN_TURN_SHARE` of it, where the directions
    are clear, and where they differ by `MIN_STRIPE_TURN` more than the halves of each side: stripes on bent cloth turn
    all the way.

    Args:
        directions: c (cos 2 a, sin 2 a) of each point, shape [row_count, m, 2].
        weights: Of each, shape [row_count, m].
        blur: Columns before and behind a turn in which the scan mixes both sides.

    Returns:
        The places of the turns in columns, and which rows show one, both of shape [row_count].
    """
    columns = weights.shape[1]
    tried = range(blur + 2, columns - blur - 1)
    shares, turns = [], []
    for column in tried:
        first, second = slice(0, column - blur), slice(column + blur, columns)
        (left, left_weight, left_bend), (right, right_weight, right_bend) = (
            _average_side(directions[:, side], weights[:, side]) for side in (first, second)
        )
        total = left_weight + right_weight
        common = (left_weight[:, None] * left + right_weight[:, None] * right) / total[:, None]
        off = np.linalg.norm(right - left, axis=1)
        bend = ((left_bend + right_bend) * (right - left)).sum(axis=1) / np.maximum(off, 1e-9)
        between, spread = left_weight * right_weight / total * off**2, total * (1.0 - (common**2).sum(axis=1))
        shares.append(pool_rows(between) / pool_rows(spread))
        beyond = pool_rows(total * (off - bend)) / pool_rows(total)
        turns.append(beyond > 2.0 * np.sin(MIN_STRIPE_TURN))
    best, row = np.argmax(shares, axis=0), np.arange(len(weights))
    is_clear = pool_rows(weights.mean(axis=1)) > MIN_STRIPE_CLEARNESS
    is_seen = is_clear & np.array(turns)[best, row] & (np.array(shares)[best, row] > MIN_TURN_SHARE)
    return np.array(tried)[best] - 0.5, is_seen


def _average_side(directions: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the mean direction at one side of each row, shape [row_count, 2], its weight, shape [row_count], and the
    difference of the means of its halves, shape [row_count, 2]."""
    half = directions.shape[1] // 2
    sums, counts = [], []
    for part in (slice(None, half), slice(half, None)):
        counts.append(weights[:, part].sum(axis=1) + 1e-9)
        sums.append((weights[:, part, None] * directions[:, part]).sum(axis=1))
    bend = sums[1] / counts[1][:, None] - sums[0] / counts[0][:, None]
    return (sums[0] + sums[1]) / (counts[0] + counts[1])[:, None], counts[0] + counts[1], bend
