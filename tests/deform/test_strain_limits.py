"""The last touches: triangles out of their bounds of stretch, and patches that cross themselves."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.geometry.geometry import gradient_operator
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.deform.settings import EasingSettings
from garmentq.core.recover.deform.strain_limits import limit_strain, smooth_crossings

SETTINGS = EasingSettings()


@pytest.fixture(scope="module")
def sheet():
    """Return a flat sheet of 30 cm with edges of 1.5 cm: nodes, faces, gradient operator and areas."""
    count = 21
    u, v = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    nodes = np.stack([u.ravel() * 0.015, v.ravel() * 0.015, np.zeros(count**2)], axis=1)
    corner = (u[:-1, :-1] * count + v[:-1, :-1]).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + count, corner + count + 1], 1),
            np.stack([corner, corner + count + 1, corner + 1], 1),
        ]
    )
    gradient, areas = gradient_operator(nodes[faces][:, :, :2], faces, len(nodes))
    return nodes, faces, gradient, areas


def _sizes(gradient, nodes):
    return np.linalg.svd(np.asarray(gradient @ nodes).reshape(-1, 2, 3), compute_uv=False)


def test_sound_triangles_do_not_move(sheet):
    """Breaks if easing touches a mesh within the bounds: the fit would drift with every call."""
    nodes, faces, gradient, areas = sheet
    curved = nodes * [1.2, 0.9, 1.0] + 0.01 * np.sin(20.0 * nodes[:, [0]]) * [0.0, 0.0, 1.0]
    assert np.array_equal(limit_strain(curved, gradient, areas, faces, SETTINGS), curved)


def test_collapsed_and_torn_triangles_come_back_within_bounds(sheet):
    """Breaks if the clipped gradients are wrong, or if the correction spreads over the sheet."""
    nodes, faces, gradient, areas = sheet
    wrong = nodes.copy()
    wrong[220] += [0.0125, 0.002, 0.0]
    before = _sizes(gradient, wrong)
    assert before.min() < 0.3 and before.max() > SETTINGS.most_stretch
    eased = limit_strain(wrong, gradient, areas, faces, SETTINGS)
    after = _sizes(gradient, eased)
    assert after.min() > 0.95 * SETTINGS.least_stretch and after.max() < 1.05 * SETTINGS.most_stretch
    far = np.linalg.norm(nodes - nodes[220], axis=1) > 0.06
    assert np.abs(eased - wrong)[far].max() < 5e-4
    assert len(self_intersections(eased, faces)) == 0


def _folded(nodes):
    """Crumple the middle of the sheet by more than an edge, so that its triangles pass through each other."""
    near = np.linalg.norm(nodes - nodes[220], axis=1) < 0.035
    return nodes + near[:, None] * np.random.default_rng(3).normal(0.0, 0.02, nodes.shape)


def test_a_fold_through_itself_is_ironed_and_the_rest_stays(sheet):
    """Breaks if ironing leaves crossings, or reaches beyond the patch."""
    nodes, faces, gradient, areas = sheet
    folded = _folded(nodes)
    assert len(self_intersections(folded, faces)) > 10
    ironed = smooth_crossings(folded, gradient, areas, faces, 0, SETTINGS)
    assert len(self_intersections(ironed, faces)) == 0
    far = np.linalg.norm(nodes - nodes[220], axis=1) > 0.12
    assert np.abs(ironed - folded)[far].max() < 1e-3


def test_what_is_allowed_is_left_as_it_is(sheet):
    """Breaks if crossings of the graded drape are ironed away, or nothing is given back where the goal is missed."""
    nodes, faces, gradient, areas = sheet
    folded = _folded(nodes)
    count = len(self_intersections(folded, faces))
    assert np.array_equal(smooth_crossings(folded, gradient, areas, faces, count, SETTINGS), folded)
    assert np.array_equal(smooth_crossings(folded, gradient, areas, faces, -1, SETTINGS), folded)
