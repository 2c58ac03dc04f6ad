"""Cloth that is taken out of itself beside a body."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from garmentq.core.body.exposed import ExposedSurface, penetration_depth
from garmentq.core.body.projection import limit_penetration
from garmentq.core.body.untangling import SeparationSettings, separate_layers_in_gap, untangle_outside
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.geometry.untangling import UntangleSettings, untangle


def lay_on_ball() -> tuple[np.ndarray, np.ndarray, ExposedSurface]:
    """Return two sheets 2 mm and 4 mm over a ball of 0.3 m, the upper one pushed through the lower in the middle."""
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.3)
    skin = ExposedSurface(np.asarray(ball.vertices), np.asarray(ball.faces), splits=0)
    grid = np.linspace(-0.1, 0.1, 14)
    x, z = (axis.ravel() for axis in np.meshgrid(grid, grid))
    sheets = []
    for shift, away in ((0.0, 0.002), (0.004, 0.004)):
        way = np.stack([x + shift, np.full_like(x, 0.3), z + shift], axis=1)
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        sink = 0.0 if shift == 0.0 else 0.0029 * np.exp(-(x**2 + z**2) / (2 * 0.02**2))
        sheets.append(way * (0.3 + away - np.broadcast_to(sink, x.shape))[:, None])
    at = np.arange(196).reshape(14, 14)
    a, b, c, d = (each.ravel() for each in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    faces = np.concatenate([np.stack([a, c, b], axis=1), np.stack([a, d, c], axis=1)])
    return np.concatenate(sheets), np.concatenate([faces, faces + 196]), skin


def test_layers_part_and_stay_outside():
    """Broken where layers are taken apart into the body, or pushed out of it through each other."""
    nodes, faces, skin = lay_on_ball()
    assert len(self_intersections(nodes, faces)) > 0
    apart = untangle_outside(nodes, skin, faces)
    assert len(self_intersections(apart, faces)) == 0
    assert penetration_depth(apart, faces, skin) < 5e-4


def test_cloth_stays_where_it_was_but_for_what_crossed():
    """Broken where what was moved to take layers apart is left there: untangled alone, 28 nodes are 0.3 mm off."""
    nodes, faces, skin = lay_on_ball()
    moved = np.linalg.norm(untangle_outside(nodes, skin, faces) - nodes, axis=1)
    alone = np.linalg.norm(untangle(nodes, faces) - nodes, axis=1)
    assert 0 < (moved > 3e-4).sum() < (alone > 3e-4).sum()


def test_sound_cloth_comes_back_as_it_is():
    """Broken where cloth that crosses nowhere is moved, were it by a digit."""
    nodes, faces, skin = lay_on_ball()
    lower = faces[: len(faces) // 2]
    one = nodes[:196]
    assert untangle_outside(one, skin, lower) is one


def lay_between_balls(gap: float) -> tuple[np.ndarray, np.ndarray, ExposedSurface]:
    """Return two sheets between two balls of 0.3 m that nearly touch, crossed around the narrowest place [m]."""
    balls = [
        trimesh.creation.icosphere(subdivisions=5, radius=0.3).apply_translation([side * (0.3 + gap / 2), 0.0, 0.0])
        for side in (-1.0, 1.0)
    ]
    both = trimesh.util.concatenate(balls)
    skin = ExposedSurface(np.asarray(both.vertices), np.asarray(both.faces), splits=0)
    grid = np.linspace(-0.1, 0.1, 15)
    y, z = (axis.ravel() for axis in np.meshgrid(grid, grid))
    at = np.arange(225).reshape(15, 15)
    a, b, c, d = (each.ravel() for each in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    faces = np.concatenate([np.stack([a, c, b], axis=1), np.stack([a, d, c], axis=1)])
    half = gap / 2 + (y**2 + z**2) / 0.6
    sheets = []
    for side, shift in ((-1.0, 0.0), (1.0, 0.004)):
        x = side * (0.5 * half - (0.5 * gap + 1e-4) * np.exp(-(y**2 + z**2) / (2 * 0.03**2)))
        sheets.append(np.stack([x, y + shift, z + shift], axis=1))
    return np.concatenate(sheets), np.concatenate([faces, faces + 225]), skin


def test_layers_share_the_room_between_parts_of_a_body():
    """Broken where layers in a narrow gap stay crossed, or one of them stays as deep as taking them apart left it."""
    nodes, faces, skin = lay_between_balls(2e-4)
    limit = 3e-4
    assert len(self_intersections(nodes, faces)) > 0
    settings = SeparationSettings()
    alone = untangle(nodes, faces, UntangleSettings(step=settings.gap_step))
    assert penetration_depth(alone, faces, skin) > limit
    apart, crossed = separate_layers_in_gap(nodes, faces, skin, limit, settings)
    assert crossed == len(self_intersections(apart, faces)) == 0
    assert 0.0 < penetration_depth(apart, faces, skin) <= limit


def test_only_what_is_too_deep_is_raised():
    """Broken where cloth outside moves, or cloth inside leaves the body altogether."""
    nodes, faces, skin = lay_on_ball()
    sunk = nodes * (0.3 / np.linalg.norm(nodes, axis=1, keepdims=True) - 0.01)
    raised = limit_penetration(np.concatenate([sunk, nodes]), np.concatenate([faces, faces + len(nodes)]), skin, 1e-3)
    np.testing.assert_array_equal(raised[len(nodes) :], nodes)
    assert penetration_depth(raised[: len(nodes)], faces, skin) == pytest.approx(1e-3, abs=1e-4)
