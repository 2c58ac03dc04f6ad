"""A mesh that goes back to where it was, as far as it does not pass through itself."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.geometry.move_towards import move_towards

from .test_untangling import bulge, lay_sheets


@pytest.mark.parametrize("depth", [0.004, 0.012])
def test_layers_stop_where_they_meet(depth):
    """Broken where layers pass through each other, stop far apart, or what is free does not arrive."""
    goal, faces = lay_sheets(bulge(depth))
    assert len(self_intersections(goal, faces)) > 10
    apart = goal.copy()
    upper = np.arange(len(goal)) >= len(goal) // 2
    apart[upper, 2] = 0.02  # flat, high over the other sheet
    moved = move_towards(apart, goal, faces)
    assert len(self_intersections(moved, faces)) == 0
    assert len(self_intersections(moved.astype(np.float32).astype(np.float64), faces)) == 0
    left = np.linalg.norm(moved - goal, axis=1)
    assert (left[:-256][~upper[:-256]] < 1e-9).all()
    assert (left < 1e-5).mean() > 0.9
    held = left > 1e-5
    assert held.any()
    assert moved[held, 2].min() < 0.0015  # a step or two over the lower sheet, whose edges are ten times as long


def test_a_goal_that_crosses_nowhere_is_reached():
    """Broken where cloth that may go all the way is held, or the rounds end early."""
    vertices, faces = lay_sheets(lambda x, y: 0.003 + 0.0 * x)
    goal = vertices + np.array([0.01, -0.02, 0.015])
    assert np.abs(move_towards(vertices, goal, faces) - goal).max() < 1e-5


def test_bumpy_layers_do_not_change_sides():
    """Broken where one round is longer than what it looks at: sheets would change sides without ever crossing."""
    vertices, faces = lay_sheets(lambda x, y: 0.0014 + 0.001 * np.sin(60 * x) * np.cos(70 * y))
    goal = vertices.copy()
    goal[len(goal) // 2 :, 2] -= 0.006
    moved = move_towards(vertices, goal, faces)
    inner = moved[len(goal) // 2 :].reshape(16, 16, 3)[1:-2, 1:-2, 2]
    assert inner.min() > 0.0
    assert (inner < vertices[len(goal) // 2 :].reshape(16, 16, 3)[1:-2, 1:-2, 2]).any()
