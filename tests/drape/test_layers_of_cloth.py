"""Layers of cloth stay apart, hollows of the body push cloth out, and templates are drafted to the wearer's size."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.curves import panel_area
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.drape.layer_contact import LayerContact
from garmentq.core.recover.drape.layers import find_layer_constraints
from garmentq.core.recover.drape.pbd import PbdState, build_distance_constraints, simulate_pbd
from garmentq.core.recover.drape.shell import SHELL_CONTACT_THICKNESS, Shell
from garmentq.core.recover.drape.sizing import measure_wearer
from sized_template import size_template


def strip() -> Garment:
    """Mesh a strip of 40 by 10 cm, unsewn."""
    points = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 0.1], [0.0, 0.1]])
    return mesh_pattern(Pattern("strip", (Panel("strip", points, (Edge(),) * 4),), ()), edge_length=0.03)


def test_a_node_above_a_face_is_kept_above() -> None:
    """Breaks if the normal points from the face's far side, or the weights do not meet in the nearest point."""
    nodes = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0.02, 0.02, 0.004], [0.3, 0, 0.1], [0.3, 0.1, 0.1]])
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    edges = np.array([[0, 1], [0, 2], [1, 2], [3, 4], [3, 5], [4, 5]])
    found = find_layer_constraints(nodes, faces, edges, np.zeros(0, dtype=np.int64), 2e-3, 1e-2)
    above = found.corners[:, 0] == 3
    assert above.sum() == 1
    assert found.normals[above][0] == pytest.approx([0, 0, 1])
    point = found.weights[above][0, 1:] @ nodes[found.corners[above][0, 1:]]
    assert -point == pytest.approx([0.02, 0.02, 0.0])


def test_halves_that_fly_at_each_other_do_not_cross() -> None:
    """Breaks if layers are not found in time, or if a step that crosses is not undone: without them faces cross."""
    garment = strip()
    nodes = garment.nodes.copy()
    bend = 1.9 * np.pi * (nodes[:, 0] - nodes[:, 0].mean()) / 0.4
    radius = 0.4 / (1.9 * np.pi)
    folded = np.column_stack([radius * np.sin(bend), nodes[:, 1] + 0.01 * np.sin(3 * bend), radius * np.cos(bend)])
    ends = np.abs(bend) > 0.6 * np.pi
    inwards = np.column_stack([-1.5 * np.sign(bend) * ends, np.zeros(len(bend)), 0.5 * np.sign(bend) * ends])
    crossed = {}
    for layers in (None, LayerContact()):
        moved = simulate_pbd(build_distance_constraints(garment), PbdState(folded, inwards), None, 40, layers=layers)
        crossed[layers] = len(self_intersections(moved.nodes, garment.faces))
    assert crossed[None] > 0
    assert crossed[LayerContact()] == 0


def test_a_hollow_pushes_outwards() -> None:
    """Breaks if cloth in a narrow wedge is pushed from one surface to the other instead of out of it."""
    slope = np.array([0.25, 1.0]) / np.hypot(0.25, 1.0)
    grid = np.stack(np.meshgrid(np.linspace(0, 0.1, 11), np.linspace(-0.05, 0.05, 11)), axis=-1).reshape(-1, 2)
    vertices = np.concatenate([np.column_stack([grid[:, 0], s * 0.25 * grid[:, 0], grid[:, 1]]) for s in (-1.0, 1.0)])
    normals = np.concatenate([np.tile([slope[0], -s * slope[1], 0.0], (len(grid), 1)) for s in (-1.0, 1.0)])
    shell = Shell.of_points(vertices, normals, np.zeros(len(vertices)))
    distance, gradient = shell.measure(np.array([[0.01, 0.0005, 0.0]]))
    assert distance[0] < SHELL_CONTACT_THICKNESS
    assert gradient[0, 0] > 0.9


def test_measures_of_the_body_of_the_drafts_are_its_own() -> None:
    """Breaks if a girth is taken at a wrong place: the drafts' defaults are those of this body, by hand."""
    found, drafted = measure_wearer(builtin_body("builtin:female,height=1.70,pose=stride")), BodyMeasures()
    for name in BodyMeasures.__dataclass_fields__:
        assert getattr(found, name) == pytest.approx(getattr(drafted, name), abs=0.02), name


def test_a_bigger_wearer_gets_a_bigger_template() -> None:
    """Breaks if the size is not taken from the wearer."""
    areas = [
        sum(panel_area(panel) for panel in pattern.panels)
        for pattern in (load_template("tshirt"), size_template("tshirt", builtin_body("builtin:male,pose=A")))
    ]
    assert areas[1] > 1.1 * areas[0]
