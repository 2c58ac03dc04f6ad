"""What is hidden of a garment, on tubes whose hidden part is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.grade.completion import HIDDEN_WAIST_HEIGHT_SHARE, complete_target
from garmentq.core.recover.grade.registration import HiddenCloth
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.contours.target import Contour, Target, mark_hidden_border

from .test_grading import HEIGHT, TOP, WIDTH, roll

CUT = 0.2
"""Height of the hidden part [m]."""


@pytest.fixture(scope="module")
def worn():
    """Roll the base pattern."""
    return roll(WIDTH, HEIGHT, 600)


@pytest.fixture(scope="module")
def skin() -> ExposedSurface:
    """Put a wearer of 5 cm radius in the middle."""
    mesh = trimesh.creation.cylinder(radius=0.05, height=2.0, sections=24)
    points = np.array(mesh.vertices)[:, [1, 2, 0]] + [0.0, TOP - HEIGHT / 2, 0.0]
    return ExposedSurface(points, np.array(mesh.faces, dtype=np.int64))


def cover(tube, hides: bool = True) -> Target:
    """Make a target of a tube whose upper part another garment covers."""
    top = tube.nodes[:, 1].max()
    chosen = tube.faces[(tube.nodes[tube.faces][:, :, 1] < top - CUT).all(axis=1)]
    used, faces = np.unique(chosen, return_inverse=True)
    nodes, faces = tube.nodes[used], faces.reshape(-1, 3)
    loops = sorted(find_loops(faces), key=lambda loop: nodes[loop, 1].mean())
    contours = (Contour("hem", loops[0], 1.0), Contour("waist", loops[1], 1.0, trusted=not hides, hidden=hides))
    hidden = np.zeros(len(nodes), bool)
    hidden[loops[1]] = hides
    return Target(
        nodes,
        faces,
        vertex_normals(nodes, faces),
        contours,
        (),
        "skirt",
        hidden=mark_hidden_border(faces, hidden, contours),
    )


def test_what_is_hidden_keeps_the_lengths_of_the_base_pattern(worn, skin) -> None:
    """Fails if the garment ended where it is covered, or if its hidden part were drawn out or crushed."""
    completed = complete_target(worn, cover(roll(WIDTH, HEIGHT, 2000)), skin)
    waist = completed.contour("waist")
    assert waist.trusted
    assert not waist.hidden
    assert completed.hidden is None
    np.testing.assert_allclose(completed.vertices[waist.vertices, 1].mean(), TOP, atol=4e-3)
    np.testing.assert_allclose(waist.length, 2 * WIDTH, rtol=0.02)


def test_a_hidden_waist_sits_halfway_to_where_its_band_holds_it(worn, skin) -> None:
    """Fails if legs that are longer than the base pattern's drew the waist down with them, or did not move it."""
    sunk = 0.04
    completed = complete_target(worn, cover(roll(WIDTH, HEIGHT, 2000, TOP - sunk)), skin)
    waist = completed.contour("waist")
    np.testing.assert_allclose(
        completed.vertices[waist.vertices, 1].mean(), TOP - HIDDEN_WAIST_HEIGHT_SHARE * sunk, atol=4e-3
    )
    np.testing.assert_allclose(waist.length, 2 * WIDTH, rtol=0.02)


def test_a_tucked_top_has_the_length_of_its_base_pattern(skin) -> None:
    """Fails if a top that is drawn down over a wearer too large for it were the longer for it where it is tucked in."""
    seen, stretch = HEIGHT - CUT, 1.08
    tube = roll(WIDTH, HEIGHT, 600)
    rename = {"waist": "neck", "hem": "hem"}
    contours = tuple(replace(contour, name=rename[contour.name]) for contour in tube.contours)
    depth = TOP - tube.nodes[:, 1]
    drawn = stretch * depth - (stretch - 1.0) * np.maximum(depth - seen / stretch, 0.0)
    worn = tube.at(np.column_stack([tube.nodes[:, 0], TOP - drawn, tube.nodes[:, 2]]), contours)
    assert worn.nodes[:, 1].min() < TOP - HEIGHT - 0.02
    fine = roll(WIDTH, seen, 2000)
    neck, hem = (next(c for c in fine.contours if c.name == name) for name in ("waist", "hem"))
    ends = (replace(neck, name="neck"), replace(hem, trusted=False, hidden=True))
    hidden = np.isin(np.arange(len(fine.nodes)), hem.vertices)
    normals = vertex_normals(fine.nodes, fine.faces)
    completed = complete_target(worn, Target(fine.nodes, fine.faces, normals, ends, (), "tshirt", hidden=hidden), skin)
    found = completed.contour("hem")
    assert found.trusted
    np.testing.assert_allclose(completed.vertices[found.vertices, 1].mean(), TOP - HEIGHT, atol=6e-3)


def test_the_visible_part_stays_as_it_was_scanned(worn, skin) -> None:
    """Fails if the completion moved, dropped or renumbered what the scan shows."""
    target = cover(roll(WIDTH, HEIGHT, 2000))
    completed = complete_target(worn, target, skin)
    np.testing.assert_array_equal(completed.vertices[: len(target.vertices)], target.vertices)
    np.testing.assert_array_equal(completed.faces[: len(target.faces)], target.faces)
    assert completed.contour("hem") == target.contour("hem")
    added = completed.faces[len(target.faces) :]
    assert added.min() >= len(target.vertices)


def test_a_wider_garment_stays_wider_where_it_is_hidden(worn, skin) -> None:
    """Fails if the hidden part fell back to the base pattern's girth at the rim: its waist follows by a third."""
    wide = 1.1 * WIDTH
    completed = complete_target(worn, cover(roll(wide, HEIGHT, 2000)), skin)
    assert 2 * (WIDTH + (wide - WIDTH) / 3) < completed.contour("waist").length < 2 * wide * 1.01


def test_a_garment_that_nothing_covers_is_given_back(worn, skin) -> None:
    """Fails if a target without a hidden border were touched: its fit must stay what it was to the last digit."""
    target = cover(roll(WIDTH, HEIGHT, 600), hides=False)
    assert complete_target(worn, target, skin) is target


def test_cloth_that_rests_on_the_body_is_held_and_upright_cloth_is_not(worn) -> None:
    """Fails if upright cloth could not move along the body, or level cloth (a shoulder, a crotch) could."""
    everywhere = np.ones(len(worn.nodes), bool)
    move = np.ones(len(worn.nodes))
    cloth = HiddenCloth(even=0.05, rest=0.1)
    assert abs(move @ cloth.stiffness(worn, everywhere) @ move) < 1e-6
    lying = replace(worn, nodes=worn.nodes * [1.0, 0.0, 1.0] + [1.0, 0.0, 0.0] * worn.nodes[:, 1:2])
    flat = np.abs(vertex_normals(lying.nodes, lying.faces)[:, 1]) > cloth.level
    cost = move @ cloth.stiffness(lying, everywhere) @ move
    assert flat.all()
    np.testing.assert_allclose(cost, 2 * WIDTH * HEIGHT / (0.1 * 0.05) ** 2, rtol=1e-6)


def test_all_of_a_hidden_rim_is_hidden_and_nothing_of_another() -> None:
    """Fails if a bay that was cut off a hidden contour counted as the garment's end, or its hem as hidden."""
    target = cover(roll(WIDTH, HEIGHT, 600))
    hem, waist = target.contour("hem"), target.contour("waist")
    some = np.zeros(len(target.vertices), bool)
    some[waist.vertices[:3]] = True
    found = mark_hidden_border(target.faces, some, target.contours)
    assert found is not None
    assert found[waist.vertices].all()
    assert not found[hem.vertices].any()
    assert found.sum() == len(waist.vertices)
    assert mark_hidden_border(target.faces, None, target.contours) is None


def test_a_contour_that_is_seen_in_part_is_completed_as_a_whole(worn, skin) -> None:
    """Fails if a neckline half of which hair covers were left without an end, and so drawn out by what pulls at it."""
    target = cover(worn)
    tube = worn.nodes[worn.faces].mean(axis=1)
    chosen = worn.faces[(tube[:, 1] < worn.nodes[:, 1].max() - CUT) | (tube[:, 2] > 0.0)]
    used, faces = np.unique(chosen, return_inverse=True)
    nodes, faces = worn.nodes[used], faces.reshape(-1, 3)
    loops = sorted(find_loops(faces), key=lambda loop: nodes[loop, 1].mean())
    contours = (Contour("hem", loops[0], 1.0), Contour("waist", loops[1], 1.0, trusted=False, hidden=True))
    hidden = np.isin(np.arange(len(nodes)), loops[1])
    part = replace(target, vertices=nodes, faces=faces, normals=vertex_normals(nodes, faces), contours=contours)
    completed = complete_target(worn, replace(part, hidden=hidden), skin)
    waist = completed.contour("waist")
    assert waist.trusted
    np.testing.assert_allclose(completed.vertices[waist.vertices, 1], TOP, atol=8e-3)
    assert np.isin(waist.vertices, completed.faces).all()
