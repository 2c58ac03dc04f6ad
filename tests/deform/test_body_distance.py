"""Distances to a body whose parts run into each other."""

from __future__ import annotations

import numpy as np
import trimesh
from garmentq.core.deform.body_distance import BodyDistance


def test_swallowed_skin_is_no_way_out() -> None:
    """Breaks where a point between two parts that overlap is sent to the skin of one that lies inside the other.

    Two balls of 10 cm, their centres 12 cm apart: on the axis the nearest skin of either lies 4 cm inside the other;
    the way out leads to the crease, 8 cm from the axis.
    """
    one, other = (trimesh.creation.icosphere(5, 0.1) for _ in range(2))
    other.apply_translation([0.12, 0.0, 0.0])
    both = trimesh.util.concatenate([one, other])
    distance = BodyDistance(np.array(both.vertices), np.array(both.faces))
    points = np.array([[0.06, 0.0, 0.0], [0.06, 0.03, 0.0], [-0.05, 0.0, 0.0], [-0.12, 0.0, 0.0]])
    found, out, foot = distance(points)
    np.testing.assert_allclose(found, [-0.08, -0.05, -0.05, 0.02], atol=2e-3)
    np.testing.assert_allclose(np.linalg.norm(foot[:2, 1:], axis=1), 0.08, atol=2e-3)
    assert out[1] @ [0.0, 1.0, 0.0] > 0.98
    moved = points + out * -found[:, None]
    assert distance(moved)[0].min() > -1e-3
