"""Cloth moved out of the exact body: nothing asked twice in vain, gaps found, no triangle torn."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.geometry.geometry import gradient_operator
from garmentq.core.recover.deform.clearance import ProximityCache, enforce_clearance
from garmentq.core.recover.deform.settings import ClearanceSettings, EasingSettings

MARGIN = 1e-3


@pytest.fixture(scope="module")
def sheet():
    """Return a flat sheet of 30 cm in the plane x = 0 with edges of 1.5 cm: nodes, faces, gradients and areas."""
    count = 21
    u, v = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    flat = np.stack([u.ravel(), v.ravel()], axis=1) * 0.015 - 0.15
    corner = (u[:-1, :-1] * count + v[:-1, :-1]).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + count, corner + count + 1], 1),
            np.stack([corner, corner + count + 1, corner + 1], 1),
        ]
    )
    nodes = np.column_stack([np.zeros(len(flat)), flat])
    gradient, areas = gradient_operator(flat[faces], faces, len(nodes))
    return nodes, faces, gradient, areas


def two_balls(distance: float) -> ExposedSurface:
    """Return two balls of 10 cm beside each other, their centres so far apart [m]."""
    balls = [trimesh.creation.icosphere(4, 0.1) for _ in range(2)]
    for ball, side in zip(balls, (-1, 1), strict=True):
        ball.apply_translation([side * 0.5 * distance, 0.0, 0.0])
    both = trimesh.util.concatenate(balls)
    return ExposedSurface(np.array(both.vertices), np.array(both.faces), splits=0)


def test_what_is_not_asked_again_is_not_missed(sheet):
    """Breaks if a point that has come near since it was asked last is taken for one that is far."""
    nodes, faces, _, _ = sheet
    body, random = two_balls(0.25), np.random.default_rng(5)
    watch = ProximityCache(faces, body, MARGIN)
    x = nodes.copy()
    for _ in range(12):
        x = x + random.normal(0.0, 3e-3, 3) + random.normal(0.0, 1e-3, x.shape)
        _, push, depth = watch.pushes(x)
        points = np.concatenate([x, x[faces].mean(axis=1)])
        distance, _ = body.measure(points)
        assert depth == pytest.approx(max(0.0, -distance.min()), abs=1e-12)
        low = np.sort(np.linalg.norm(push, axis=1))
        # only points that were pushed back the way they came may ask for less than the margin
        wanted = np.sort(MARGIN - distance[distance < MARGIN])
        assert len(low) <= len(wanted)
        assert len(low) == 0 or low[-1] <= wanted[-1] + 1e-12


def test_cloth_in_a_narrow_gap_rests_in_its_middle(sheet):
    """Breaks if nodes are thrown to and fro between two parts whose gap is narrower than two margins."""
    nodes, faces, gradient, areas = sheet
    body = two_balls(0.2012)
    off = nodes + [4e-3, 0.0, 0.0]
    assert -body.measure(off)[0].min() > 3e-3
    cleared = enforce_clearance(off, gradient, areas, ProximityCache(faces, body, MARGIN), ClearanceSettings())
    points = np.concatenate([cleared, cleared[faces].mean(axis=1)])
    assert body.measure(points)[0].min() > -1e-4


def test_cloth_through_touching_balls_comes_out_whole(sheet):
    """Breaks if triangles that are pushed out of an overlap are torn, or the rest of the sheet is carried along."""
    nodes, faces, gradient, areas = sheet
    body = two_balls(0.1994)
    cleared = enforce_clearance(nodes, gradient, areas, ProximityCache(faces, body, MARGIN), ClearanceSettings())
    points = np.concatenate([cleared, cleared[faces].mean(axis=1)])
    assert body.measure(points)[0].min() > -MARGIN
    sizes = np.linalg.svd(np.asarray(gradient @ cleared).reshape(-1, 2, 3), compute_uv=False)
    assert sizes.min() > EasingSettings.least_stretch
    far = np.linalg.norm(nodes, axis=1) > 0.12
    assert np.abs(cleared - nodes)[far].max() < 1e-3


def test_cloth_in_the_open_stays(sheet):
    """Breaks if clearing moves what is clear already."""
    nodes, faces, gradient, areas = sheet
    away = nodes + [0.0, 0.0, 0.5]
    assert np.array_equal(
        enforce_clearance(away, gradient, areas, ProximityCache(faces, two_balls(0.25), MARGIN), ClearanceSettings()),
        away,
    )
