"""Meshes that pass through themselves, and get out of themselves."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.geometry.intersections import intersecting_pairs, self_intersections
from garmentq.core.geometry.untangling import untangle

SPACING = 0.015
"""Edge of the sheets [m], as a garment's mesh has it."""


def lay_sheets(height, count: int = 16) -> tuple[np.ndarray, np.ndarray]:
    """Return two square sheets, one in the plane z = 0, the other at height(x, y) [m]."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(count) * SPACING, np.arange(count) * SPACING))
    lower = np.stack([x, y, np.zeros_like(x)], axis=1)
    upper = np.stack([x + 0.3 * SPACING, y + 0.4 * SPACING, height(x, y)], axis=1)
    at = np.arange(count**2).reshape(count, count)
    a, b, c, d = (each.ravel() for each in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.concatenate([lower, upper]), np.concatenate([faces, faces + count**2])


def bulge(depth: float):
    """Return a sheet's height: 3 mm, and in the middle as deep below the other sheet."""
    middle = 7.5 * SPACING
    return lambda x, y: 0.003 - (depth + 0.003) * np.exp(-((x - middle) ** 2 + (y - middle) ** 2) / (2 * 0.03**2))


@pytest.mark.parametrize("depth", [0.002, 0.006])
def test_a_bulge_goes_back_through_the_other_sheet(depth):
    """Broken where contours grow instead of contracting, or a lens is only shortened from its tips."""
    vertices, faces = lay_sheets(bulge(depth))
    assert len(self_intersections(vertices, faces)) > 10
    apart = untangle(vertices, faces)
    assert len(intersecting_pairs(apart, faces)) == 0
    moved = np.linalg.norm(apart - vertices, axis=1)
    assert moved.max() < 4 * depth
    assert moved[[0, 15, 240, 255, 256]].max() < 1e-4  # far from the bulge nothing moves


@pytest.mark.parametrize("seed", [3, 14, 25, 39])
def test_a_crumpled_corner_is_smoothed(seed):
    """Broken where cloth that is crumpled by more than an edge, whose contour cannot contract, is left crossed."""
    vertices, faces = lay_sheets(lambda x, y: 0.1 + 0.0 * x, 9)
    crumpled = vertices.copy()
    corner = [30, 31, 39, 40, 41, 49]
    crumpled[corner] += np.random.default_rng(seed).normal(0.0, 2.0 * SPACING, (6, 3))
    assert len(self_intersections(crumpled, faces)) > 5
    smooth = untangle(crumpled, faces)
    assert len(self_intersections(smooth, faces)) == 0
    assert np.linalg.norm(smooth - vertices, axis=1)[81:].max() < 1e-3  # nothing happens to the other sheet


def test_what_crosses_nowhere_comes_back_as_it_is():
    """Broken where sound meshes are smoothed, copied or moved by a digit."""
    vertices, faces = lay_sheets(lambda x, y: 0.003 + 0.0 * x)
    assert untangle(vertices, faces) is vertices


def test_what_cannot_get_apart_is_not_made_worse():
    """Broken where the last round is returned instead of the best: half of a sheet stands behind the other."""
    vertices, faces = lay_sheets(lambda x, y: (x - 7.5 * SPACING) * 2.0)
    before = len(self_intersections(vertices, faces))
    assert len(self_intersections(untangle(vertices, faces), faces)) <= before
