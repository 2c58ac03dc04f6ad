"""Patterns from elsewhere, whose files say nothing of grain, notches, hems and halves."""

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.deliver.formats.drawing import GRAIN_UNKNOWN_TEXT, list_texts
from garmentq.core.deliver.formats.layered_svg import pieces_svg
from garmentq.core.deliver.formats.pdf_file import show_text
from garmentq.core.garment.contour_edges import name_open_edges
from garmentq.core.garment.editing.edge_division import divide
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.grain import list_unknown_grains
from garmentq.core.garment.panel_parts import find_arm_panels
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.pieces.joining import join_halves
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.pieces.marks import find_gathered_runs
from garmentq.core.garment.templates import load_draped_template, load_template
from garmentq_pieces import imported

NOTCHED_LENGTH = 0.12


CJK = {
    "back": "後身頃", "front": "前身頃", "sleeve_back_left": "左後袖", "sleeve_back_right": "右後袖",
    "sleeve_front_left": "左前袖", "sleeve_front_right": "右前袖",
}  # fmt: skip


@pytest.mark.parametrize("names", [None, CJK])
@pytest.mark.parametrize("name", ["tshirt", "long_sleeve_tshirt"])
def test_the_warp_follows_the_arm_and_the_trunk(name, names):
    """Broken where a sleeve of a file without grain is cut across, or the author's own words are needed."""
    drafted, found = load_template(name), imported(name, names)
    assert not list_unknown_grains(found)
    for panel in drafted.panels:
        grain = found.panel((names or {}).get(panel.name, panel.name)).grainline
        apart = (grain - panel.grainline + np.pi / 2) % np.pi - np.pi / 2
        assert abs(apart) < np.radians(10.0)


def test_a_grain_that_nothing_shows_is_unknown_on_the_sheet():
    """Broken where a panel that lies nowhere on a body gets a grainline as if it were known."""
    square = np.array([[0.0, 0.0], [0.3, 0.0], [0.3, 0.3], [0.0, 0.3]])
    document = write_pattern(Pattern("p", (Panel("one", square, (Edge(),) * 4),), ()))
    del document["properties"]["garmentq"]
    pattern = read_pattern(document)
    assert list_unknown_grains(pattern) == {"one"} == list_unknown_grains(read_pattern(write_pattern(pattern)))
    pieces = make_pieces(pattern)
    assert not pieces.pieces[0].is_grain_known and GRAIN_UNKNOWN_TEXT in list_texts(pieces, 0)
    assert GRAIN_UNKNOWN_TEXT in pieces_svg(pieces) and 'class="grain"' not in pieces_svg(pieces)


@pytest.mark.parametrize("names", [None, CJK])
def test_long_seams_are_notched_and_back_has_two(names):
    """Broken where a long seam of a file has nothing to match, front and back are notched alike, or too near."""
    made = make_pieces(imported("tshirt", names))
    for seam in made.seams:
        if min(seam.lengths) > NOTCHED_LENGTH:
            for side in seam.sides:
                marks = [n for part in side for n in made.pieces[part.piece].notches if n.edge == part.edge]
                assert any(0.0 < notch.at < 1.0 for notch in marks)
    front, back, sleeve = made.pieces
    assert {n.count for n in back.notches if n.purpose == "match"} == {1, 2}  # side seams, armholes
    assert {n.count for n in front.notches if n.purpose == "match"} == {1}
    assert {n.count for n in sleeve.notches if n.purpose == "match"} == {1, 2}
    for piece in made.pieces:
        sews = np.array([n.sew for n in piece.notches if n.purpose == "match"])
        gaps = np.linalg.norm(sews[:, None] - sews, axis=2)[np.triu_indices(len(sews), 1)]
        assert ((gaps > 0.0145) | (np.abs(gaps - 0.006) < 1e-4)).all()


def test_gathers_are_marked_over_their_whole_run():
    """Broken where a file that cuts a gathered seam in twelve gets three notches and a junction for each."""
    count, wide, full = 12, 0.05, 0.08
    line = np.arange(count + 1)[:, None] * [1.0, 0.0]
    band = np.concatenate([wide * line, [[count * wide, 0.05], [0.0, 0.05]]])
    skirt = np.concatenate([[[0.0, -0.4], [count * full, -0.4]], full * line[::-1]])
    panels = (
        Panel("wb", band, (Edge(),) * len(band), translation=np.array([0.0, 1.0, 0.2])),
        Panel("skirt", skirt, (Edge(),) * len(skirt), translation=np.array([0.0, 0.9, 0.2])),
    )
    seams = tuple(Seam(EdgeRef("wb", k), EdgeRef("skirt", 1 + count - k), gathered=True) for k in range(count))
    pattern = Pattern("gathered", panels, seams)
    assert [len(run) for run in find_gathered_runs(pattern)] == [count]
    for piece in make_pieces(pattern).pieces:
        assert [notch.purpose for notch in piece.notches] == ["gather"] * 3
        x = sorted(notch.sew[0] for notch in piece.notches)
        assert np.diff(x) == pytest.approx(np.ptp(piece.net.points[:, 0]) / 4)


def test_open_edges_are_named_as_the_garment_is_worn():
    """Broken where hem, neck and cuffs of a file that names none get a seam's allowance."""
    draped = load_draped_template("tshirt")
    bare = tuple(
        replace(panel, edges=tuple(replace(edge, contour="") for edge in panel.edges))
        for panel in draped.pattern.panels
    )
    named = name_open_edges(replace(draped, pattern=replace(draped.pattern, panels=bare)))
    for panel, drafted in zip(named.panels, draped.pattern.panels, strict=True):
        assert [edge.contour for edge in panel.edges] == [edge.contour for edge in drafted.edges]


GORED = "skirt+skirt=gored,gores=8"


@pytest.mark.parametrize("name", [GORED, f"{GORED},waistband=band", "long_sleeve_tshirt+sleeve_head=set-in,cuff=shirt"])
def test_gores_beside_the_trunk_are_no_sleeves(name):
    """Broken where the side gores of a skirt whose file names none are sleeves, or sleeves of such a file are none."""
    drafted = load_template(name)
    numbers = {panel.name: f"p{n}" for n, panel in enumerate(drafted.panels)}
    depths = {numbers[name]: depth for name, depth in find_arm_panels(drafted).items()}
    assert find_arm_panels(imported(name, numbers)) == depths


def test_halves_that_part_are_not_joined():
    """Broken where a flared sleeve is cut with a wedge of its own cloth between the halves, as if it were a dart."""
    front = np.array([[0.0, 0.0], [0.0, -0.1], [-0.1, -0.5], [0.25, -0.5], [0.2, -0.1]])
    back = (front * [-1.0, 1.0])[::-1]
    panels = (
        Panel("sleeve_f", front, (Edge(),) * 5, translation=np.array([0.5, 1.3, 0.2])),
        Panel("sleeve_b", back, (Edge(),) * 5, np.diag([-1.0, 1.0, -1.0]), np.array([0.5, 1.3, -0.2])),
    )
    top, below = (Seam(EdgeRef("sleeve_f", i), EdgeRef("sleeve_b", 3 - i)) for i in (0, 1))
    assert [len(group.places) for group in join_halves(Pattern("sleeve", panels, (top,)))] == [2]
    assert [len(group.places) for group in join_halves(Pattern("sleeve", panels, (top, below)))] == [1, 1]


def test_pieces_in_any_script_are_called_by_their_place():
    """Broken where a sleeve named in Chinese is PIECE_2, its halves lie apart, or its own name is lost."""
    made = make_pieces(imported("tshirt", CJK))
    assert [(piece.name, piece.quantity) for piece in made.pieces] == [("FRONT", 1), ("BACK", 1), ("SLEEVE", 2)]
    assert all(name in pieces_svg(made) for name in CJK.values())


def test_sheets_write_umlauts():
    """Broken where a PDF shows `?` for letters that its fonts have, or control codes reach it."""
    assert r"(\304rmel gr\366\337e \(1\) ?)" in show_text(0.0, 0.0, 3.0, "Ärmel größe (1) 袖")
    assert r"(?)" in show_text(0.0, 0.0, 3.0, "\n")


def test_left_and_right_are_one_piece_however_their_edges_are_cut():
    """Broken where a file that divides one side's seams draws left and right, or its seams then differ by 1 mm."""
    pattern = load_template("four_panel_skirt")
    side = next(i for i, edge in enumerate(pattern.panel("front_left").edges) if edge.label.startswith("side.0"))
    cut = divide(pattern, {EdgeRef("front_left", side): 0.4})
    assert [len(cut.panel(f"front_{side}").edges) for side in ("left", "right")] == [8, 7]
    made = make_pieces(cut)
    assert [(piece.name, piece.quantity, piece.pair) for piece in made.pieces] == [
        ("FRONT", 2, True),
        ("BACK", 2, True),
    ]
    assert {place.panel for piece in made.pieces for place in piece.places} == {panel.name for panel in cut.panels}
    assert all(abs(seam.lengths[0] - seam.lengths[1]) < 1e-3 for seam in made.seams)
    wide = cut.panel("front_left").points * [1.01, 1.0]
    assert len(make_pieces(cut.with_points({"front_left": wide})).pieces) > 2
