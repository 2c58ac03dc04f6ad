"""The loss terms: derivatives against finite differences, and values that are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.geometry.geometry import gradient_operator, shape_gradients
from garmentq.core.recover.deform.objective import Objective, subsample_by_grid
from garmentq.core.recover.deform.rest_metric import RestMetric
from garmentq.core.recover.deform.settings import DeformSettings, DeformSettingsBad
from garmentq.core.recover.deform.target_repair import prepare_target


def build(scene, settings, nodes, scale=0.0, unsigned=False):
    garment, target, body = scene
    goal = prepare_target(target, garment.at(nodes), True)
    goal = replace(goal, unsigned=unsigned)
    gradient, areas = gradient_operator(garment.rest, garment.faces, len(nodes))
    metric = RestMetric(garment.faces, garment.panel_of_face, areas, scale)
    metric.follow((gradient @ nodes).reshape(-1, 2, 3).transpose(0, 2, 1))
    inverse = shape_gradients(garment.rest)[:, 1:]
    return Objective(nodes, garment.faces, inverse, areas, goal, body, settings), metric


WEIGHTS = ("normal", "contour", "bending", "strain", "body")
"""Terms whose weight may be 0; the distance is always in the loss."""


@pytest.mark.parametrize("unsigned", [False, True])
@pytest.mark.parametrize("distance", ["surface", "vertices"])
@pytest.mark.parametrize("reduction", ["mean", "sum"])
def test_every_term_agrees_with_finite_differences(scene, distance, reduction, unsigned):
    """Breaks if any term's derivative is cut: body, bending, strain, normals, contours or distance."""
    garment = scene[0]
    generator = np.random.default_rng(1)
    # narrow enough that the body term is at work
    nodes = (
        (garment.nodes - [0, 0.95, 0]) * [0.81, 1, 0.81]
        + [0, 0.95, 0]
        + generator.normal(size=garment.nodes.shape) * 1e-3
    )
    settings = DeformSettings(distance=distance, reduction=reduction, body_margin=5e-3)
    objective, metric = build(scene, settings, nodes, scale=0.1, unsigned=unsigned)
    # the body's planes and the matches stay those of the start, as they do within an iteration
    matches = objective.match(nodes)
    terms, whole = objective.evaluate(nodes, matches, metric, True)
    assert set(terms) == {"distance", *WEIGHTS} and min(terms.values()) > 0.0
    way = generator.normal(size=nodes.shape)
    slopes = {"distance": [dict.fromkeys(WEIGHTS, 0.0)], **{name: [{}, {name: 0.0}] for name in WEIGHTS}}
    for name, changes in slopes.items():
        found = []
        for change in changes:
            other, _ = build(scene, replace(settings, **change), nodes, scale=0.1, unsigned=unsigned)
            found.append(other.evaluate(nodes, matches, metric, True)[1])
        gradient = found[0] - (found[1] if len(found) > 1 else 0.0)
        ends = [
            objective.evaluate(nodes + step * way, matches, metric, True)[0][name]
            for step in (2e-6, 1e-6, -1e-6, -2e-6)
        ]
        expected = (8.0 * (ends[1] - ends[2]) - (ends[0] - ends[3])) / 12e-6
        assert float((gradient * way).sum()) == pytest.approx(expected, rel=1e-6), name
    assert np.array_equal(
        whole, build(scene, settings, nodes, 0.1, unsigned)[0].evaluate(nodes, matches, metric, True)[1]
    )


def test_a_face_without_area_has_no_say(scene):
    """Breaks if a collapsed triangle or a vertex without a normal makes the loss or its gradient not finite."""
    garment = scene[0]
    nodes = garment.nodes.copy()
    nodes[garment.faces[5]] = nodes[garment.faces[5, 0]]
    objective, metric = build(scene, DeformSettings(), garment.nodes)
    for place in (nodes, np.zeros_like(nodes)):
        terms, gradient = objective.evaluate(place, objective.match(place), metric, True)
        assert np.isfinite(list(terms.values())).all() and np.isfinite(gradient).all()


def test_strain_of_the_flat_rest_is_that_of_a_known_stretch(scene):
    """Breaks if the StVK energy's factors are wrong: a tube 10 % wider has E_xx = 0.105 everywhere."""
    garment = scene[0]
    settings = DeformSettings(strain=1.0)
    objective, metric = build(scene, settings, garment.nodes)
    wide = (garment.nodes - [0, 0.8, 0]) * [1.1, 1, 1.1]
    term = objective.evaluate(wide, objective.match(wide), metric, True)[0]["strain"]
    green = (1.1**2 - 1) / 2
    area = 2 * np.pi * 0.15 * 0.3
    expected = area * green**2 * (settings.lame_lambda / 2 + settings.lame_mu)
    # chords of 2.5 cm are 0.12 % shorter than their arcs, which is 1.4 % of this strain and 2.8 % of its energy
    assert term == pytest.approx(expected, rel=0.03)


def test_rest_metric_follows_a_wrong_grading_but_not_a_crumpled_face(scene):
    """Breaks if strain pulls a panel back that was graded 15 % too narrow, or if it lets single faces collapse."""
    garment = scene[0]
    _, areas = gradient_operator(garment.rest, garment.faces, len(garment.nodes))
    metric = RestMetric(garment.faces, garment.panel_of_face, areas, 0.1)
    jacobians = np.tile(np.array([[1.15, 0.0], [0.0, 0.95], [0.0, 0.0]]), (len(areas), 1, 1))
    metric.follow(jacobians)
    assert np.allclose(metric.stretch, np.diag([1.15, 0.95]), atol=1e-9)
    assert np.allclose(metric.stretch @ metric.undo, np.eye(2), atol=1e-9)
    jacobians[7] *= 0.1
    metric.follow(jacobians)
    assert abs(metric.stretch[7] - np.diag([1.15, 0.95])).max() < 0.1


def test_bad_settings_are_refused():
    """Breaks if a wrong weight reaches the optimiser and gives a wrong mesh in silence."""
    for bad in ({"strain": -1.0}, {"normal": float("nan")}, {"learning_rate": 0.0}, {"iterations": -1}):
        with pytest.raises(DeformSettingsBad):
            DeformSettings(**bad)
    with pytest.raises(DeformSettingsBad):
        DeformSettings(distance="chamfer")


def test_a_crowded_target_is_thinned_evenly_and_keeps_its_weight():
    """Breaks if thinning drops part of the surface, keeps a crowd, or loses shares."""
    random = np.random.default_rng(2)
    vertices = np.column_stack([random.random((20000, 2)), np.zeros(20000)])
    vertices[0] = 0.0
    picked, shares = subsample_by_grid(vertices, np.full(20000, 1 / 20000), 0.05)
    assert len(picked) == 400
    assert shares.sum() == pytest.approx(1.0)
    cells = np.unique(np.floor(vertices[picked] / 0.05).astype(int), axis=0)
    assert len(cells) >= 398
    np.testing.assert_allclose(shares, 1 / 400, rtol=0.5)
