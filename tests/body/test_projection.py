"""The last push out of the body."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from garmentq.core.body.exposed import ExposedSurface, penetration_depth, pinched_depth
from garmentq.core.body.projection import project_outside
from garmentq.core.geometry.intersections import self_intersections
from nearest_skin import signed_distance


def sheet(count: int, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Make a flat square sheet about the origin in z = 0, `count` nodes to a side: nodes [m] and faces."""
    u, v = np.meshgrid(np.linspace(-size / 2, size / 2, count), np.linspace(-size / 2, size / 2, count), indexing="ij")
    i = np.arange(count**2).reshape(count, count)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.stack([u.ravel(), v.ravel(), np.zeros(count**2)], axis=1), faces


@pytest.fixture(scope="module")
def ball():
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=0.05)
    return ExposedSurface(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def test_nothing_is_left_inside(ball):
    """A node or a face centre left in the body breaks this: here three nodes on the skin cut 1 mm into it."""
    flat, faces = sheet(11, 0.2)
    points = flat + [0.0, 0.0, 0.046]
    assert signed_distance(ball, points)[0].min() < -0.003
    moved = project_outside(points, ball, faces, clearance=1e-3)
    assert signed_distance(ball, moved)[0].min() > 1e-3 - 2e-5
    assert signed_distance(ball, moved[faces].mean(1))[0].min() > -1e-4
    far = np.linalg.norm(points, axis=1) > 0.1
    assert np.array_equal(moved[far], points[far])  # what is clear stays exactly where it is


def test_push_is_along_the_distance(ball):
    """Eq. 3.5 for one node: straight out to the clearance."""
    point = np.array([[0.03, 0.02, 0.01]])
    moved = project_outside(point, ball, clearance=2e-3)
    assert signed_distance(ball, moved)[0][0] == pytest.approx(2e-3, abs=1e-5)
    direction = (moved - point)[0]
    cosine = direction @ point[0] / np.linalg.norm(direction) / np.linalg.norm(point)
    assert cosine > 0.995


def test_clear_cloth_is_untouched(ball):
    """A push that moves what needs none breaks this."""
    flat, faces = sheet(5, 0.1)
    points = flat + [0.0, 0.0, 0.08]
    assert np.array_equal(project_outside(points, ball, faces), points)


def test_points_in_a_crease_leave_both_parts() -> None:
    """Breaks where a point between two parts is pushed from one into the other and back until the rounds end."""
    one, other = (trimesh.creation.icosphere(4, 0.1) for _ in range(2))
    other.apply_translation([0.12, 0.0, 0.0])
    both = trimesh.util.concatenate([one, other])
    skin = ExposedSurface(np.array(both.vertices), np.array(both.faces))
    turn = np.linspace(0.0, 2.0 * np.pi, 40)
    points = np.column_stack([0.06 + 0.01 * np.sin(5 * turn), 0.05 * np.cos(turn), 0.05 * np.sin(turn)])
    moved = project_outside(points, skin)
    assert skin.measure(points)[0].max() < -0.01
    assert skin.measure(moved)[0].min() > 0.0


@pytest.fixture(scope="module")
def thighs():
    """Two limbs of 8 cm along y, their axes 15.6 cm apart: they run into each other and leave a crease."""
    limbs = [trimesh.creation.capsule(height=0.3, radius=0.08, count=[48, 48]) for _ in range(2)]
    for limb, x in zip(limbs, (-0.078, 0.078), strict=True):
        limb.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
        limb.apply_translation([x, 0.0, 0.0])
    both = trimesh.util.concatenate(limbs)
    return ExposedSurface(np.array(both.vertices), np.array(both.faces))


def test_layers_leave_a_crease_without_crossing(thighs):
    """Breaks where nodes of two layers are pushed to one rim on their own: of cloth 11 mm deep 225 faces then cross."""
    flat, faces = sheet(15, 0.2)
    dent = np.exp(-((flat[:, 0] / 0.02) ** 2))
    upper = flat * [0.9, 1.0, 1.0] + [0.0, 0.0, 0.085]
    upper[:, 2] -= 0.075 * dent
    layers, both = np.concatenate([upper - [0.0, 0.0, 3e-3], upper]), np.concatenate([faces, faces + len(flat)])
    assert len(self_intersections(layers, both)) == 0
    assert penetration_depth(layers, both, thighs) > 5e-3
    moved = project_outside(layers, thighs, both)
    assert penetration_depth(moved, both, thighs) < 1e-3
    assert len(self_intersections(moved, both)) == 0


def test_far_cloth_stays_where_a_crease_is_left(thighs):
    """Breaks where the current that carries layers out of a crease moves cloth that it does not reach."""
    flat, faces = sheet(15, 0.2)
    layers = flat + [0.0, 0.0, 0.085]
    layers[:, 2] -= 0.075 * np.exp(-((flat[:, 0] / 0.02) ** 2))
    away = flat + [0.0, 0.0, 0.4]
    moved = project_outside(np.concatenate([layers, away]), thighs, np.concatenate([faces, faces + len(flat)]))
    assert np.array_equal(moved[len(flat) :], away)


def test_a_point_at_the_clearance_behind_a_crease_leaves() -> None:
    """Breaks where a point that is a clearance from one part and inside another counts as out, for it need not move."""
    one, other = (trimesh.creation.icosphere(2, 0.1) for _ in range(2))
    other.apply_translation([0.12, 0.0, 0.0])
    both = trimesh.util.concatenate([one, other])
    skin = ExposedSurface(np.array(both.vertices), np.array(both.faces))
    share = np.random.default_rng(3).dirichlet(
        np.ones(3), (len(skin.faces), 20)
    )  # a face in the open is so to its most
    points = (share @ skin.vertices[skin.faces] + 1e-3 * skin.normals[:, None]).reshape(-1, 3)
    inside = points[skin.measure(points)[0] < 0]
    inside = inside[np.abs(skin.measure(inside)[0] + 1e-3) < 1e-9]
    assert len(inside)
    assert skin.measure(project_outside(inside, skin))[0].min() > -1e-9


def test_cloth_that_limbs_pinch_is_not_torn_to_the_rims(thighs):
    """Breaks where cloth between both limbs is sent out of both, one node in front and the next behind.

    A sheet that goes around one limb, on its skin, passes through the other, 4 mm deep where the limbs meet: the rims
    of the crease are 17 mm away, before it and behind.
    """
    flat, faces = sheet(25, 0.19)
    turn = flat[:, 0] / 0.0795
    nodes = np.stack([0.0795 * np.cos(turn) - 0.078, flat[:, 1], 0.0795 * np.sin(turn)], axis=1)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])

    def longest(points):
        before, after = (np.linalg.norm(at[edges[:, 0]] - at[edges[:, 1]], axis=1) for at in (nodes, points))
        return (after / before).max()

    depth = pinched_depth(nodes, faces, thighs)
    assert depth.exit > 1e-2 and 1e-4 < depth.pinched < 3e-3
    torn = project_outside(nodes, thighs, faces)
    kept = project_outside(nodes, thighs.sparing_pinched, faces)
    assert longest(torn) > 2.0 and longest(kept) < 1.6
    assert pinched_depth(kept, faces, thighs).free < 5e-4
