"""Outlines are laid upon each other upright by the grain."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.judge.outlines import fit_outline


def turn(angle: float) -> np.ndarray:
    """Return a rotation."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize("upright", [0.0, np.pi / 2.0, np.pi])
def test_a_nearly_square_piece_lies_as_its_grain_does(upright):
    """Broken where a fit that is turned by a quarter, and hardly better, is preferred to the one that is upright."""
    piece, other = (np.array([[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]]) for w, h in ((0.40, 0.405), (0.46, 0.44)))
    fit = fit_outline(piece, other @ turn(0.05).T, upright=upright)
    angle = np.arctan2(fit.motion.rotation[1, 0], fit.motion.rotation[0, 0])
    assert abs((angle - upright + np.pi) % (2.0 * np.pi) - np.pi) < np.pi / 4.0


def test_a_piece_that_was_drawn_turned_is_found():
    """Broken where the grain forces a fit that is far worse than the turned one."""
    piece = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.9], [0.0, 0.9]])
    fit = fit_outline(piece, piece @ turn(np.pi / 2.0).T, upright=0.0)
    assert fit.rms < 1e-4
