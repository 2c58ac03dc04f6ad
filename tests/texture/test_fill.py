"""Gaps are filled smoothly and nothing known is changed."""

from __future__ import annotations

import numpy as np
from garmentq.core.deliver.texture.fill import fill_gaps


def test_known_texels_stay_and_a_constant_is_filled_by_itself() -> None:
    """Fails if weights do not sum to one at any level, or a known texel is smoothed."""
    known = np.random.default_rng(0).random((37, 53)) < 0.05
    image = np.where(known[..., None], [10.0, 20.0, 30.0], -1000.0)
    assert np.allclose(fill_gaps(image, known), [10.0, 20.0, 30.0])
    values = np.random.default_rng(1).random((37, 53, 3))
    assert np.array_equal(fill_gaps(values, known)[known], values[known])


def test_a_gap_takes_what_lies_around_it() -> None:
    """Fails if a hole in a slope is filled from far away: within the values at its rim."""
    row = np.arange(64.0)[None, :, None].repeat(64, axis=0)
    known = np.ones((64, 64), dtype=bool)
    known[28:36, 28:36] = False
    filled = fill_gaps(np.where(known[..., None], row, 0.0), known)
    assert filled[28:36, 28:36].min() > 26.0 and filled[28:36, 28:36].max() < 37.0


def test_nothing_known_is_left_alone() -> None:
    """Fails if a panel that no scan shows divides by zero."""
    image = np.full((5, 4, 3), 7.0)
    assert np.array_equal(fill_gaps(image, np.zeros((5, 4), dtype=bool)), image)
