"""A wrap front is two fronts that reach past the centre, sewn so that it stays closed."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.curves import edge_length, flat_contours, panel_area
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.parts.cut import PartsConflict
from garmentq.core.garment.parts.wraps import TIE_WIDTH
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import draft_template, load_template
from garmentq.core.scan.contours.loop import find_loops

WRAPS = [
    "long_sleeve_tshirt+front=wrap,neckline=v",
    "tank+bodice=shift,front=wrap,neckline=v,vent=sides",
    "dress+front=wrap,neckline=v",
    "sleeved_dress+front=wrap,neckline=v,skirt=half-circle,waist=seam",
    "tshirt+front=wrap,neckline=v,hem_band=rib,yoke=back",
]

CURVY = BodyMeasures(bust=1.08, waist=0.86, hip=1.12)


def sewn_to(pattern, panel):
    """Return the length that each other panel shares with a panel along its seams [m]."""
    found = {}
    for seam in pattern.seams:
        for own, other in ((seam.a, seam.b), (seam.b, seam.a)):
            if own.panel == panel:
                length = edge_length(pattern.panel(panel), own.edge)
                found[other.panel] = found.get(other.panel, 0.0) + length
    return found


@pytest.mark.parametrize("measures", [BodyMeasures(), CURVY])
@pytest.mark.parametrize("name", WRAPS)
def test_both_fronts_reach_past_the_centre_and_are_sewn_at_both_sides(name, measures):
    """Breaks where a front ends before the far side, is sewn to one side only, or lies beside the other one."""
    pattern = draft_template(name, measures)
    assert seam_mismatch(pattern) < 1e-6
    outer, inner = (pattern.panel(part) for part in ("front_right", "front_left"))
    for front, sign in ((outer, 1.0), (inner, -1.0)):
        far = (sign * front.points[:, 0]).max()
        assert far > 0.15
    assert outer.label == "wrap" and inner.label == "body"
    tie = [edge_length(inner, i) for i, edge in enumerate(inner.edges) if edge.label == "tie.right"]
    assert tie == pytest.approx([TIE_WIDTH], rel=0.1)
    assert {"back"} <= set(sewn_to(pattern, "front_left")) and {"back"} <= set(sewn_to(pattern, "front_right"))
    assert not {"front_left"} & set(sewn_to(pattern, "front_right"))


@pytest.mark.parametrize("name", WRAPS)
def test_the_neckline_of_a_wrap_is_both_front_edges_and_the_back_neck(name):
    """Breaks where a front edge is curved or unnamed, or what is covered counts as neckline."""
    pattern = load_template(name)
    front = [
        np.subtract(*panel.points[[i, (i + 1) % len(panel.points)]])
        for panel in (pattern.panel("front_right"), pattern.panel("front_left"))
        for i, edge in enumerate(panel.edges)
        if edge.contour == "neck"
    ]
    assert len(front) == 2
    assert front[0][0] * front[0][1] * front[1][0] * front[1][1] < 0.0, "one falls to the left, one to the right"
    plain = load_template(name.replace("front=wrap,", ""))
    behind = sum(
        edge_length(panel, i)
        for panel in plain.panels
        if "back" in panel.name
        for i, edge in enumerate(panel.edges)
        if edge.contour == "neck"
    )
    lengths = flat_contours(pattern)
    assert lengths["neck"] == pytest.approx(sum(map(np.linalg.norm, front)) + behind)
    loops = [len(find_loops(mesh_pattern(one, 500).faces)) for one in (pattern, plain)]
    assert loops[0] == loops[1], "what is covered joins the neckline's border"


@pytest.mark.parametrize("name", WRAPS)
def test_a_wrap_is_cut_and_read_as_it_is_written(name):
    """Breaks where a front has no piece, its allowance fails, or a file loses which front is the outer one."""
    pattern = load_template(name)
    again = read_pattern(write_pattern(pattern), pattern.name)
    assert again.panel("front_right").label == "wrap"
    assert flat_contours(again) == pytest.approx(flat_contours(pattern))
    found = make_pieces(again)
    pieces = {piece.name: piece for piece in found.pieces}
    assert {"FRONT_LEFT", "FRONT_RIGHT", "BACK"} <= set(pieces)
    assert panel_area(pieces["FRONT_LEFT"].net) == pytest.approx(panel_area(pattern.panel("front_left")), rel=1e-3)
    assert any("inner front" in line for line in found.missing)


@pytest.mark.parametrize(
    ("name", "step"),
    [
        ("tshirt+front=wrap", "choose neckline=v"),
        ("tshirt+front=wrap,neckline=v,sleeve_head=raglan", "another sleeve_head"),
        ("tshirt+front=wrap,neckline=v,hood=two", "choose"),
        ("jumpsuit+front=wrap,neckline=v", "choose front=none"),
        ("dress+front=wrap,neckline=v,shaping=darts,waist=seam", "shaping=none"),
        ("tank+bodice=halter,front=wrap,neckline=v", "choose bodice"),
    ],
)
def test_a_wrap_without_its_parts_is_refused_with_the_next_step(name, step):
    """Breaks where a wrap is drafted through a collar, a dart or a raglan line."""
    with pytest.raises(PartsConflict, match=step):
        load_template(name)
