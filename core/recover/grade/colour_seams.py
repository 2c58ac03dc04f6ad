"""Find seams between cloths of two colours: where along a seam the scan's colours make one step."""

from __future__ import annotations

import numpy as np

from .seam_strips import SeamStrip, SeamTrace, pool_rows

MIN_EXPLAINED_SHARE = 0.5
"""Share of the colours' variance across a seam from which one step explains them [1]: most of it. Of prints and noise
it explains less; a stripe has two steps."""

MIN_TONE_DIFFERENCE = 0.15
"""Difference of a channel over the mean one from which two colours are two cloths and not one in light and shade [1]:
three times what a camera's noise of 5 % makes of it."""

MAX_LIGHTING_RATIO = 3.0
"""Ratio of light and shade on one cloth [1]: key light and fill light of a portrait are 2 to 3 times the fill alone."""

MIN_BRIGHTNESS = 0.02
"""Brightness of black cloth [1, of RGB in 0..1]."""


def find_colour_trace(strip: SeamStrip, colours: np.ndarray, blur: int) -> SeamTrace | None:
    """Find where colours make a step along a seam; None where they do not.

    Args:
        strip: The scan along the seam.
        colours: RGB in 0..1 of its points, shape [row_count, column_count, 3].
        blur: Columns before and behind a step in which the scan mixes both colours.
    """
    return strip.trace(*find_steps(colours, strip.near, blur))


def find_steps(colours: np.ndarray, near: np.ndarray, blur: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Find one step in each row of colours, a seam's between two cloths.

    At the step k the least squares of c(x) = a + b x + h H(x - x_k) over the colours of a row and its neighbours, but
    for those that the scan blurs, are least. It is seen where the step h explains most of their variance and the model
    more than a cubic, which shades follow; where the colours differ by more than a shade; and where most rows' steps
    are alike.

    Args:
        colours: Shape [row_count, m, channel_count].
        near: Whether each is on the scan, shape [row_count, m].
        blur: Columns before and behind a step in which the scan mixes both colours.

    Returns:
        The places of the steps in columns, between 0 and m - 1, and which rows show one, both of shape [row_count].
    """
    columns = near.shape[1]
    at = np.linspace(-1.0, 1.0, columns)
    cubic = np.stack([at**k for k in range(4)], axis=1)
    tried = range(blur + 2, columns - blur - 1)
    shares, sides, explained = [], [], []
    for column in tried:
        behind = np.arange(columns) >= column
        clear = near & (np.abs(np.arange(columns) + 0.5 - column) > blur)
        model = np.stack([np.ones(columns), at, np.where(behind, 0.5, -0.5)], axis=1)
        fitted, rest = _fit(model, colours, clear)
        counts = clear.sum(axis=1) * (np.minimum((clear & behind).sum(axis=1), (clear & ~behind).sum(axis=1)) > 2)
        spread, smooth = (pool_rows(_fit(terms, colours, clear)[1]) for terms in (np.ones((columns, 1)), cubic))
        rest, height = pool_rows(rest), pool_rows(fitted[:, 2])
        middle = pool_rows(fitted[:, 0] + fitted[:, 1] * at[[column - 1, column]].mean())
        by_step = 0.25 * pool_rows(counts.astype(float)) * (height**2).sum(axis=1)
        shares.append(np.where(spread > 0.0, rest / np.maximum(spread, 1e-12), np.inf))
        explained.append((by_step > MIN_EXPLAINED_SHARE * spread) & (rest < smooth))
        sides.append((middle - 0.5 * height, middle + 0.5 * height))
    best, row = np.argmin(shares, axis=0), np.arange(len(near))
    left, right = np.moveaxis(np.array(sides)[best, :, row], 1, 0)
    height, is_seen = right - left, np.array(explained)[best, row] & _differ_by_more_than_shade(left, right)
    if is_seen.any():
        common = np.median(height[is_seen], axis=0)
        is_seen &= height @ common > 0.5 * float(common @ common)
    return np.array(tried)[best] - 0.5, is_seen


def _differ_by_more_than_shade(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Check which pairs of colours, shape [n, channel_count] each, are not one colour in light and shade."""
    left, right = np.maximum(left, MIN_BRIGHTNESS), np.maximum(right, MIN_BRIGHTNESS)
    bright = np.stack([left.mean(axis=1), right.mean(axis=1)])
    tones = np.abs(left / bright[0][:, None] - right / bright[1][:, None]).max(axis=1)
    return np.asarray((tones > MIN_TONE_DIFFERENCE) | (bright.max(axis=0) > MAX_LIGHTING_RATIO * bright.min(axis=0)))


def _fit(terms: np.ndarray, colours: np.ndarray, clear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the least squares of terms, shape [m, k], to the clear colours of each row: coefficients, shape [n, k,
    channel_count], and squared residuals, shape [n]."""
    weighted = clear[:, :, None] * terms
    gram = np.swapaxes(weighted, 1, 2) @ terms + 1e-9 * np.eye(terms.shape[1])
    found = np.linalg.solve(gram, np.swapaxes(weighted, 1, 2) @ colours)
    return found, (clear[:, :, None] * (colours - terms @ found) ** 2).sum(axis=(1, 2))
