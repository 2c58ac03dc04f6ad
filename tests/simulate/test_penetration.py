"""The last push out of the body."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from garmentq.core.body import BodySurface, signed_distance
from garmentq.core.simulate import push_out


@pytest.fixture(scope="module")
def ball():
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=0.05)
    return SimpleNamespace(vertices=np.asarray(mesh.vertices), faces=np.asarray(mesh.faces))


def test_nothing_is_left_inside(ball, sheet):
    """A node or a face centre left in the body breaks this: here three nodes on the skin cut 1 mm into it."""
    flat, faces = sheet(11, 11, 0.2, 0.2)
    points = np.column_stack([flat[:, 0] - 0.1, flat[:, 1] - 0.1, np.full(len(flat), 0.046)])
    assert signed_distance(ball, points)[0].min() < -0.003
    moved = push_out(points, ball, faces, clearance=1e-3)
    assert signed_distance(ball, moved)[0].min() > 1e-3 - 2e-5
    assert signed_distance(ball, moved[faces].mean(1))[0].min() > -1e-4
    far = np.linalg.norm(points, axis=1) > 0.1
    assert np.array_equal(moved[far], points[far])  # what is clear stays exactly where it is


def test_push_is_along_the_distance(ball):
    """Eq. 3.5 for one node: straight out to the clearance."""
    point = np.array([[0.03, 0.02, 0.01]])
    moved = push_out(point, ball, clearance=2e-3)
    assert signed_distance(ball, moved)[0][0] == pytest.approx(2e-3, abs=1e-5)
    direction = (moved - point)[0]
    cosine = direction @ point[0] / np.linalg.norm(direction) / np.linalg.norm(point)
    assert cosine > 0.995


def test_clear_cloth_is_untouched(ball, sheet):
    """A push that moves what needs none breaks this."""
    flat, faces = sheet(5, 5, 0.1, 0.1)
    points = np.column_stack([flat, np.full(25, 0.08)])
    assert np.array_equal(push_out(points, ball, faces), points)


def test_points_in_a_crease_leave_both_parts() -> None:
    """Breaks where a point between two parts is pushed from one into the other and back until the rounds end."""
    one, other = (trimesh.creation.icosphere(4, 0.1) for _ in range(2))
    other.apply_translation([0.12, 0.0, 0.0])
    both = trimesh.util.concatenate([one, other])
    skin = BodySurface(np.array(both.vertices), np.array(both.faces))
    turn = np.linspace(0.0, 2.0 * np.pi, 40)
    points = np.column_stack([0.06 + 0.01 * np.sin(5 * turn), 0.05 * np.cos(turn), 0.05 * np.sin(turn)])
    moved = push_out(points, skin)
    assert skin.measure(points)[0].max() < -0.01
    assert skin.measure(moved)[0].min() > 0.0
