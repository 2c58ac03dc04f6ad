"""The 26 measures of a body: against sections by another library, by hand, and wherever the body stands."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from garmentq.core.body.body_tape import measure_body, tabulate_body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.measure_names import HOW_MEASURED, MEASURE_KINDS
from garmentq.core.body.standing import girth_of, length_of_line, stands_upright, taut_path
from garmentq.core.body.template import rotations_of
from shapely import MultiPoint, Polygon


@pytest.fixture(scope="module")
def female():
    """Return a built-in body in A pose as a mesh from elsewhere, and its measures."""
    body = replace(builtin_body("builtin:female,height=1.70,pose=A"), source="mesh:x")
    return body, measure_body(body)


def test_tape_on_a_cylinder():
    """Broken where a girth or a taut path is not that of a tape: half around a drum, straight over a hollow."""
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    ring = np.stack([0.3 * np.cos(angle), np.full(721, 1.0), 0.3 * np.sin(angle)], axis=1)
    assert girth_of(ring, 1)[0] == pytest.approx(0.6 * np.pi, rel=1e-5)
    front = taut_path(ring[1:360], ring[0], ring[360], np.array([0.0, 0.0, 1.0]))
    assert length_of_line(front) == pytest.approx(0.3 * np.pi, rel=1e-5)
    hollow = np.array([[0.2, 0.0, 0.1], [0.5, 0.0, -0.2], [0.8, 0.0, 0.1]])
    path = taut_path(hollow, np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    assert length_of_line(path) == pytest.approx(0.6 + 2.0 * np.hypot(0.2, 0.1))


@pytest.mark.parametrize("name", ["bust", "underbust", "waist", "hip", "thigh"])
def test_girths_are_those_of_sections_by_another_library(female, name):
    """Broken where a cut loses faces, an arm counts as trunk, or the tape follows a hollow: trimesh cuts the body at
    the same height, shapely lays the hull round its loops."""
    _, figure = female
    height = float(figure.measures[list(HOW_MEASURED).index(name)].lines[0][0, 1])
    mesh = trimesh.Trimesh(figure.standing.vertices, figure.standing.faces, process=False)
    loops = [np.asarray(loop)[:, [0, 2]] for loop in mesh.section([0, 1, 0], [0, height, 0]).discrete]
    loops = [loop for loop in loops if abs(Polygon(loop).area) > 0.008 and abs(loop[:, 0].mean()) < 0.2]
    if name == "thigh":
        found = max(Polygon(loop).convex_hull.length for loop in loops)
    else:
        found = MultiPoint(np.concatenate(loops)).convex_hull.length
    assert figure.value(name) == pytest.approx(found, abs=1e-6)


def test_upright_distances_add_up(female):
    """Broken where two measures take one landmark at two places."""
    _, figure = female
    assert figure.value("height") == pytest.approx(1.70, abs=1e-3)
    low = figure.value("height") - figure.value("head_length") - figure.value("bust_level")
    assert low > figure.value("waist_to_hip") + figure.value("hip_to_crotch") + 0.5
    for back, whole in (("back_width", "bust"), ("waist_back_width", "waist"), ("hip_back_width", "hip")):
        assert 0.38 * figure.value(whole) < figure.value(back) < 0.62 * figure.value(whole)
    assert np.degrees(figure.value("arm_angle")) == pytest.approx(45.0, abs=4.0)
    assert figure.value("back_waist_length") < figure.value("front_waist_length") + 0.06


def test_lines_are_as_long_as_what_is_given(female):
    """Broken where the figure shows another line than the one that was measured."""
    _, figure = female
    assert tuple(one.name for one in figure.measures) == tuple(HOW_MEASURED) and len(HOW_MEASURED) == 26
    for one in figure.measures:
        low, high = MEASURE_KINDS[one.name].span
        assert low < one.value < high, one.name
        if not one.is_angle:
            drawn = np.mean([length_of_line(line) for line in one.lines])
            assert drawn == pytest.approx(one.value, rel=2e-2 if one.name == "wrist" else 1e-9), one.name


def test_place_and_heading_do_not_matter(female):
    """Broken where a body is measured in the file's axes: turned by 0.7 rad and moved, it has the same measures."""
    body, figure = female
    turn, move = rotations_of(np.array([0.0, 0.7, 0.0])), np.array([0.3, 0.0, -2.0])
    moved = replace(body, vertices=body.vertices @ turn.T + move, joints=body.joints @ turn.T + move)
    other = measure_body(moved)
    assert [one.value for one in other.measures] == pytest.approx([one.value for one in figure.measures], abs=1e-6)


def test_poses_of_a_model_do_not_matter():
    """Broken where arms that hang into the cut, or bent legs, change a built-in body's measures."""
    bodies = [builtin_body(f"builtin:male,height=1.85,pose={pose}") for pose in ("A", "seated")]
    assert [stands_upright(body) for body in bodies] == [True, False]
    first, second = (measure_body(body) for body in bodies)
    assert [one.value for one in first.measures] == pytest.approx([one.value for one in second.measures], abs=1e-9)


def test_holes_and_stumps_do_not_end_a_job(female):
    """Broken where a body that is open, or lacks arms or legs, is an error instead of a measure that is missing."""
    body, _ = female
    middles = body.vertices[body.faces].mean(axis=1)
    for kept in (middles[:, 1] > 0.9, middles[:, 1] < 1.2, np.abs(middles[:, 0]) < 0.2, middles[:, 2] < 0.0):
        found = tabulate_body(replace(body, faces=body.faces[kept]))
        assert len(found) == 26 and all(value is None or np.isfinite(value) for value in found.values())
    assert tabulate_body(replace(body, source="form:x")) == {}


def test_legs_that_touch_have_a_thigh_all_the_same():
    """Broken where thighs without a gap have no crotch, and so no thigh, hip or rise."""
    figure = measure_body(builtin_body("builtin:female,height=1.55,weight=95"))
    assert all(np.isfinite(one.value) for one in figure.measures)
