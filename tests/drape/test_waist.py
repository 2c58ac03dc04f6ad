"""Waists: tied to the scan's, spread as they are cut or as they lie."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.girths import TapeMeasure
from garmentq.core.body.skinning import rest_body
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.curves import Curve
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.dress import waistband_height
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.waist import flat_lengths, waist_loop
from garmentq.core.recover.drape.waist_placement import pin_waist, place_waist, tie_contour
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.contours.target import Contour, Target
from wearers import find_wearer


@pytest.mark.parametrize("turned", [False, True])
def test_loop_is_tied_to_its_own_place_on_the_curve(turned: bool) -> None:
    """Breaks if the start or the sense of rotation of the two curves is not matched."""
    angle = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
    curve = np.column_stack([0.15 * np.cos(angle), np.zeros(90), 0.1 * np.sin(angle)])
    angle = np.linspace(0.0, 2 * np.pi, 40, endpoint=False) + 1.0
    loop = np.column_stack([0.165 * np.cos(angle), np.full(40, 0.02), 0.11 * np.sin(angle)])
    tied = tie_contour(loop, curve[::-1] if turned else curve)
    assert np.linalg.norm(tied - loop, axis=1).max() < 0.03
    assert np.abs(tied[:, 1]).max() < 1e-12


def test_a_loop_that_hangs_unevenly_is_spread_as_it_is_cut() -> None:
    """Breaks if the shares are those of the stretched loop: cloth that was bunched at one side is then pinned so."""
    angle = np.linspace(0.0, 2 * np.pi, 400, endpoint=False)
    curve = np.column_stack([0.15 * np.cos(angle), np.zeros(400), 0.15 * np.sin(angle)])
    even = np.linspace(0.0, 2 * np.pi, 40, endpoint=False)
    angle = even + 0.3 * np.sin(even)
    loop = np.column_stack([0.15 * np.cos(angle), np.zeros(40), 0.15 * np.sin(angle)])
    sides = Curve(tie_contour(loop, curve, np.full(40, 0.02))).lengths
    assert sides.max() < 1.001 * sides.min()


def test_teeth_of_a_border_that_was_cut_along_triangles_draw_no_cloth() -> None:
    """Fails if the length of such teeth is counted: cloth lies crumpled where they are, and is stretched elsewhere."""
    angle = np.linspace(0.0, 2 * np.pi, 240, endpoint=False)
    teeth = np.where(np.sin(angle) < 0.0, 0.006, 0.0) * (-1.0) ** np.arange(240)
    curve = np.column_stack([0.15 * np.cos(angle), teeth, 0.15 * np.sin(angle)])
    scan = Target(curve, np.zeros((0, 3), int), curve, (Contour("waist", np.arange(240), 1.0),), (), "skirt")
    even = np.linspace(0.0, 2 * np.pi, 60, endpoint=False)
    loop = np.column_stack([0.15 * np.cos(even), np.zeros(60), 0.15 * np.sin(even)])
    sides = Curve(place_waist(loop, scan, np.full(60, 0.016))).lengths
    assert sides.max() < 1.05 * sides.min()


def test_flat_lengths_follow_a_loop_in_its_order() -> None:
    """Breaks if lengths come in the order of the mesh's edges, or are those of the cloth where it hangs."""
    outline = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 0.2], [0.0, 0.2]])
    panel = Panel("sheet", outline, (Edge(),) * 4)
    garment = mesh_pattern(Pattern("sheet", (panel,), ()), edge_length=0.05)
    stretched = garment.at(garment.nodes * (2.0, 1.0, 1.0))
    (loop,) = find_loops(garment.faces)
    assert flat_lengths(stretched, np.roll(loop, 3)) == pytest.approx(np.roll(Curve(garment.nodes[loop]).lengths, 3))


def test_a_skirt_from_flat_pieces_is_spread_as_it_is_cut_and_keeps_a_spacing_that_a_scan_shows() -> None:
    """Breaks if the pose leaves the waist bunched as it was dressed, or pins spread anew what was registered."""
    settings = DrapeSettings(template_vertices=250)
    wearer, skirt = find_wearer(), load_template("skirt")
    dressed = drape_template(skirt, wearer, settings=settings)
    normals = vertex_normals(dressed.nodes, dressed.faces)
    scan = Target(dressed.nodes, dressed.faces, normals, dressed.contours, (), "skirt")
    worn = drape_template(skirt, wearer, scan, settings=settings)
    waist = waist_loop(worn)
    assert waist is not None
    stretches = [Curve(one.nodes[waist]).lengths / flat_lengths(one, waist) for one in (dressed, worn)]
    assert np.ptp(stretches[1]) < 0.1 < 0.2 < np.ptp(stretches[0])
    pins = pin_waist(dressed, scan)
    assert pins is not None
    assert np.abs(pins.points - dressed.nodes[pins.nodes]).max() < 0.002


@pytest.mark.parametrize("spec", ["builtin:female,height=1.58", "builtin:male,height=1.83,weight=95"])
def test_a_waistband_sits_where_the_body_is_as_wide_as_it(spec: str) -> None:
    """Fails if a level at which few vertices lie passes for a narrow place: bands then sit 20 cm too low."""
    body = rest_body(builtin_body(spec))
    tape = TapeMeasure(body)
    narrowest = tape.measure("waist")
    assert waistband_height(0.9 * narrowest.value, body) == pytest.approx(narrowest.level, abs=0.02)
    for height in np.linspace(body.joint("pelvis")[1] + 0.02, narrowest.level - 0.02, 12):
        girth = tape.trunk(height).value
        assert tape.trunk(waistband_height(girth, body)).value == pytest.approx(girth, abs=0.01)
