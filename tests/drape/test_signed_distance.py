"""Every answer to where the body is, against a ball whose distance is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.body.signed_distance import SignedDistance
from garmentq.core.recover.drape.shell import NO_SURFACE_DISTANCE, Shell, ShellDistance

RADIUS = 0.1


def make(kind: str) -> SignedDistance:
    """Build a ball of 10 cm about the origin as one of the kinds."""
    ball = trimesh.creation.icosphere(5, RADIUS)
    mesh = np.array(ball.vertices), np.array(ball.faces)
    made = {
        "grid": lambda: DistanceGrid.from_mesh(*mesh, spacing=0.005),
        "exposed": lambda: ExposedSurface(*mesh),
        "shell": lambda: Shell.of(*mesh),
        "beside": lambda: ShellDistance(Shell.of(*mesh), ExposedSurface(*mesh)),
    }
    return made[kind]()


@pytest.mark.parametrize("kind", ["grid", "exposed", "shell", "beside"])
def test_every_body_answers_alike(kind: str) -> None:
    """Breaks where a sign, a unit or a gradient's direction differs, or the nearest surface does not come first."""
    body, generator = make(kind), np.random.default_rng(0)
    way = generator.normal(size=(300, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    height = generator.uniform(-0.01, 0.015, 300)
    distance, gradient = (values[:300] for values in body.measure(way * (RADIUS + height)[:, None]))
    assert np.abs(distance - height).max() < 6e-4
    slope = np.linalg.norm(gradient, axis=1)
    assert (np.einsum("nd,nd->n", gradient, way) / slope).min() > 0.98
    assert np.abs(slope - 1.0).max() < 0.1


def test_an_opposite_surface_is_searched_wherever_there_is_one() -> None:
    """Breaks if a point whose candidates hold an opposite surface, as under a hanging arm, is left out unsearched."""
    body = builtin_body("builtin:female,pose=arms-down")
    shell = Shell.of(body.vertices, body.faces)
    away = np.random.default_rng(0).uniform(0.0, 0.02, (len(shell.vertices), 1))
    points = shell.vertices + away * shell.normals
    found = shell.surfaces(points)
    everywhere = replace(shell, clearance=np.zeros(len(shell.vertices))).surfaces(points)
    assert 0.01 < np.mean(found[1] < NO_SURFACE_DISTANCE) < 0.5
    assert np.mean(shell.clearance > 0.01) > 0.5
    for one, other in zip(found, everywhere, strict=True):
        assert np.array_equal(one, other)
