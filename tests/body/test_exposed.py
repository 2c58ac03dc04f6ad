"""The outside of bodies whose parts run into each other."""

from __future__ import annotations

import numpy as np
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.exposed import ExposedSurface


def two_balls() -> tuple[np.ndarray, np.ndarray]:
    """Return two balls of 10 cm, their centres 12 cm apart: their creases lie 8 cm from the axis."""
    one, other = (trimesh.creation.icosphere(4, 0.1) for _ in range(2))
    other.apply_translation([0.12, 0.0, 0.0])
    both = trimesh.util.concatenate([one, other])
    return np.array(both.vertices), np.array(both.faces)


def test_the_way_out_leads_past_swallowed_skin() -> None:
    """Breaks where a point is sent to the skin of one part that lies inside the other, or creases are cut coarsely."""
    vertices, faces = two_balls()
    points = np.array([[0.06, 0.0, 0.0], [0.06, 0.03, 0.0], [-0.05, 0.0, 0.0], [-0.12, 0.0, 0.0], [0.06, 0.09, 0.0]])
    for turned in (faces, faces[:, ::-1]):
        skin = ExposedSurface(vertices, turned)
        distance, way = skin.measure(points)
        # in the hollow 1 cm above the crease the skin of each ball is sqrt(6^2 + 9^2) - 10 cm away
        np.testing.assert_allclose(distance, [-0.08, -0.05, -0.05, 0.02, np.hypot(0.06, 0.09) - 0.1], atol=1e-3)
        assert way[1] @ [0.0, 1.0, 0.0] > 0.99
        np.testing.assert_allclose(points - skin.closest(points).foot, way * distance[:, None], atol=1e-12)
        assert skin.contains(points).tolist() == [True, True, True, False, False]
        assert np.linalg.norm(skin.vertices[skin.faces].mean(axis=1)[:, 1:], axis=1).max() < 0.1 + 1e-6
    radius = np.linalg.norm(skin.vertices[skin.faces] - [0.12, 0.0, 0.0], axis=2)
    from_first = np.linalg.norm(skin.vertices[skin.faces], axis=2)
    assert np.minimum(radius, from_first).min() > 0.094  # a part of a face at the crease, never one across it


def test_a_face_that_is_not_split_is_whole_or_gone() -> None:
    """Breaks where skin is split that nobody asked to split, or a face is kept whose middle another part swallows."""
    vertices, faces = two_balls()
    skin = ExposedSurface(vertices, faces, splits=0)
    kept = {tuple(face) for face in skin.faces.tolist()}
    middles = np.linalg.norm(vertices[faces].mean(axis=1)[:, None] - [[0.0, 0.0, 0.0], [0.12, 0.0, 0.0]], axis=2)
    open_air = middles.min(axis=1) > 0.0995  # a face's middle lies up to 0.2 mm below its ball
    assert kept <= {tuple(face) for face in faces.tolist()}
    assert {tuple(face) for face in faces[open_air & (middles.max(axis=1) > 0.101)].tolist()} <= kept
    assert len(kept) < 0.85 * len(faces)


def test_a_sheet_is_all_outside() -> None:
    """Breaks where a mesh that encloses nothing loses its faces, or no points are asked for."""
    vertices, faces = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.array([[0, 2, 1]])
    skin = ExposedSurface(vertices, faces)
    assert skin.measure(np.array([[0.2, 0.3, 0.2]]))[0][0] == 0.3
    assert skin.measure(np.zeros((0, 3)))[1].shape == (0, 3)


def test_signs_are_the_winding_numbers_beside_creases_too() -> None:
    """Broken where a point inside one of two parts that run into each other passes for outside: cloth stays in it."""
    body = builtin_body("builtin:female,height=1.70,pose=arms-down")
    skin = ExposedSurface.of(body, splits=0)
    assert skin.hidden_skin is not None
    generator = np.random.default_rng(4)
    around = np.concatenate(
        [skin.vertices, np.repeat(skin.hidden_skin.vertices[skin.hidden_skin.faces].mean(axis=1), 6, 0)]
    )
    points = around[generator.integers(len(around), size=8000)] + generator.normal(0, 0.015, (8000, 3))
    inside = skin.contains(points)
    assert 2000 < inside.sum() < 7000
    np.testing.assert_array_equal(skin.measure(points)[0] < 0, inside)


def test_depth_between_parts_that_run_into_each_other_is_told_apart():
    """Broken where cloth that has no place outside of both parts counts as left inside, or the other way round."""
    from garmentq.core.body.exposed import pinched_depth

    body = builtin_body("builtin:female,height=1.70,pose=arms-down")
    skin = ExposedSurface.of(body, splits=0)
    assert skin.hidden_skin is not None
    middle = skin.hidden_skin.vertices[skin.hidden_skin.faces].mean(axis=1)
    deepest = middle[[skin.closest(middle).distance.argmax()]]
    faces = np.zeros((0, 3), dtype=int)
    found = pinched_depth(deepest - 1e-4, faces, skin)
    assert found.free == 0.0 and found.exit > 2e-3 and found.pinched < 2e-4
    inside = body.joint("neck")[None] * [1.0, 0.9, 1.0]
    found = pinched_depth(inside, faces, skin)
    assert found.free > 0.03 and found.exit == found.pinched == 0.0


def test_what_parts_pinch_is_spared_and_nothing_else() -> None:
    """Broken where cloth that may stay between two parts is sent out, or cloth that has a way out may stay inside.

    On the axis, 4 cm inside both balls, the crease is 8 cm away: pinched. What is inside one ball is not where its own
    skin in the open is nearer than the other's skin.
    """
    skin = ExposedSurface(*two_balls())
    points = np.array([[0.06, 0.0, 0.0], [0.05, 0.01, 0.0], [0.01, 0.09, 0.0], [-0.08, 0.0, 0.0], [0.06, 0.0, 0.3]])
    distance, sparing = skin.measure(points)[0], skin.sparing_pinched
    spared = sparing.measure(points)[0]
    pinched = np.array([True, True, False, False, False])
    np.testing.assert_array_equal(spared[~pinched], distance[~pinched])
    assert (distance[pinched] < -0.06).all()
    # to the other ball's skin 4 cm, to the crease 8: it stays pinched for 2 cm
    np.testing.assert_allclose(spared[0], 0.5 * (0.08 - 0.04), atol=1e-3)
    assert (spared[pinched] > 0.0).all()
    for one in (sparing, sparing.whole):
        inside, way = one.depths(points)
        np.testing.assert_array_equal(inside, points[[2, 3]])
        assert (way > 0.0).all()
    assert len(skin.depths(points)[0]) == len(skin.whole.depths(points)[0]) == 4


def test_a_spared_point_stays_spared_as_far_as_its_distance_says() -> None:
    """Broken where the distance of a pinched point is more than it can move: a watch would ask too late."""
    sparing = ExposedSurface(*two_balls()).sparing_pinched
    generator = np.random.default_rng(6)
    points = np.array([0.06, 0.0, 0.0]) + generator.uniform(-1.0, 1.0, (300, 3)) * [0.03, 0.07, 0.07]
    distance = sparing.measure(points)[0]
    way = generator.normal(size=points.shape)
    way *= (0.99 * np.abs(distance) / np.linalg.norm(way, axis=1))[:, None]
    kept = distance > 0.0
    assert 50 < kept.sum() < 300
    assert (sparing.measure(points + way)[0][kept] > 0.0).all()


def test_a_surface_asked_near_cloth_is_the_whole_one_there() -> None:
    """Skin far from cloth may go without a question, no distance near it may change: broken by a small box."""
    body = builtin_body("builtin:female,height=1.65,pose=seated")
    whole = ExposedSurface.of(body, splits=0)
    knees = np.stack([body.joint(f"{side}_knee") for side in ("left", "right")])
    points = (knees[:, None] + np.random.default_rng(5).normal(0.0, 0.05, (2, 300, 3))).reshape(-1, 3)
    near = ExposedSurface(body.vertices, body.faces, 0, points)
    assert len(near.faces) > len(whole.faces)
    np.testing.assert_allclose(near.measure(points)[0], whole.measure(points)[0], atol=1e-14)
