"""The last push out of the body."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from garmentq.core.body import signed_distance
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
