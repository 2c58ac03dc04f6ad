"""Vents open a hem, and slits a sleeve, where they are drafted; the pieces mark them."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.garment.curves import edge_length, flat_contours
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.parts.cut import PartsConflict
from garmentq.core.garment.parts.sleeves import BOUND_SLIT_WIDTH, SLEEVE_SLIT_LENGTH
from garmentq.core.garment.parts.vents import SKIRT_VENT_LENGTH, TOP_VENT_LENGTHS
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.pieces.piece import EdgeUse, NotchPurpose
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.scan.contours.loop import find_loops

VENTED = [
    ("skirt", "sides", SKIRT_VENT_LENGTH),
    ("skirt", "back", SKIRT_VENT_LENGTH),
    ("four_panel_skirt", "back", SKIRT_VENT_LENGTH),
    ("dress", "back", SKIRT_VENT_LENGTH),
    ("sleeved_dress", "sides", SKIRT_VENT_LENGTH),
    ("tshirt", "sides", TOP_VENT_LENGTHS["sides"]),
    ("tank", "back", TOP_VENT_LENGTHS["back"]),
]


@pytest.mark.parametrize(("stem", "vent", "length"), VENTED)
def test_a_hem_goes_up_and_down_each_vent(stem, vent, length):
    """Breaks where a vent is a border of its own, takes cloth away, or is not as long as it is said to be."""
    closed, vented = load_template(stem), load_template(f"{stem}+vent={vent}")
    count = 2 if vent == "sides" else 1
    longer = flat_contours(vented)["hem"] - flat_contours(closed)["hem"]
    assert longer == pytest.approx(2 * count * length, abs=1e-4)  # shipped files are rounded
    assert len(find_loops(mesh_pattern(vented, 500).faces)) == len(find_loops(mesh_pattern(closed, 500).faces))
    assert vented.symmetric


@pytest.mark.parametrize(("stem", "vent", "length"), VENTED)
def test_the_pieces_mark_both_ends_of_the_seam_above_a_vent(stem, vent, length):
    """Breaks where a vent is cut as a hem, or its upper end, where sewing stops, is not marked on both sides."""
    found = make_pieces(load_template(f"{stem}+vent={vent}"))
    vents = [(piece, i) for piece in found.pieces for i, edge in enumerate(piece.edges) if edge.use is EdgeUse.VENT]
    assert all(edge_length(piece.net, i) == pytest.approx(length, rel=1e-6) for piece, i in vents)
    ends = sum(notch.purpose is NotchPurpose.SLIT for piece in found.pieces for notch in piece.notches)
    assert len(vents) == ends > 0
    assert any("vent" in line for line in found.missing)


@pytest.mark.parametrize("head", ["flat", "set-in", "raglan"])
def test_a_shirt_cuff_is_buttoned_below_a_slit(head):
    """Breaks where the slit is sewn up or reaches the cuff's end, or the cuff is a ring without ends."""
    name = f"long_sleeve_tshirt+cuff=shirt,sleeve_head={head}"
    pattern, banded = load_template(name), load_template(name.replace("shirt,", "band,"))
    side = np.hypot(SLEEVE_SLIT_LENGTH, BOUND_SLIT_WIDTH / 2)
    lengths = flat_contours(pattern)
    for arm in ("left", "right"):
        assert lengths[f"placket.{arm}"] == pytest.approx(2 * side)
        assert lengths[f"cuff.{arm}"] == pytest.approx(flat_contours(banded)[f"cuff.{arm}"])
    openings = [len(find_loops(mesh_pattern(one, 1000).faces)) for one in (pattern, banded)]
    assert openings[0] == openings[1] + 2
    pieces = {piece.name: piece for piece in make_pieces(pattern).pieces}
    assert sum(edge.use is EdgeUse.BUTTONS for edge in pieces["CUFF"].edges) == 2
    assert sum(edge.use is EdgeUse.PLACKET for edge in pieces["SLEEVE"].edges) == 2
    assert len(pieces["SLEEVE"].drills) == 1
    assert sum(notch.purpose is NotchPurpose.SLIT for notch in pieces["SLEEVE"].notches) == 2


@pytest.mark.parametrize("name", ["long_sleeve_tshirt+cuff=shirt,vent=back", "pencil_skirt+vent=sides"])
def test_slits_are_read_as_they_are_written(name):
    """Breaks where the label of a vent's open edge makes it a seam in a file, or a placket loses its name."""
    pattern = load_template(name)
    again = read_pattern(write_pattern(pattern), pattern.name)
    assert flat_contours(again) == pytest.approx(flat_contours(pattern))
    assert len(again.seams) == len(pattern.seams)
    uses = [[edge.use for edge in piece.edges] for one in (pattern, again) for piece in make_pieces(one).pieces]
    assert uses[: len(uses) // 2] == uses[len(uses) // 2 :]


@pytest.mark.parametrize(
    ("name", "step"),
    [
        ("skirt+skirt=full-circle,vent=sides", "choose skirt=straight"),
        ("tshirt+hem_band=rib,vent=back", "hem_band=none, or vent=none"),
        ("tshirt+cuff=shirt", "sleeve=long, or cuff=band"),
        ("trousers+vent=sides", "choose legs"),
    ],
)
def test_a_slit_without_a_place_is_refused_with_the_next_step(name, step):
    """Breaks where a cut loses the slit that was asked for without a word."""
    with pytest.raises(PartsConflict, match=step):
        load_template(name)
