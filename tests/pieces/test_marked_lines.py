"""Marked lines of pieces: the middle, and the levels of the wearer's body found on the worn cloth."""

import io

import ezdxf
import numpy as np
import pytest
from garmentq.core.cloth.fabrics import get_fabric, load_fabrics
from garmentq.core.deliver.formats.dialects import DIALECTS_BY_NAME
from garmentq.core.deliver.formats.dxf import Block, dxf_text
from garmentq.core.deliver.formats.layered_svg import pieces_svg
from garmentq.core.deliver.formats.levels import find_hang_height, find_levels
from garmentq.core.deliver.formats.options import ExportOptions
from garmentq.core.deliver.formats.production import Production, describe_garment, is_stretchy
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.pieces.flatten import flatten_outline
from garmentq.core.garment.pieces.make import PieceSettings, make_pieces
from garmentq.core.garment.templates import draft_template, load_template
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq_pieces import pieces_of
from shapely import LineString, Polygon
from worn_template import load_worn_template


@pytest.mark.parametrize(
    ("name", "known"),
    [
        ("tshirt", {"bust", "waist", "hip"}),
        ("tank+shaping=princess", {"bust", "waist"}),
        ("dress+waist=seam", {"bust", "waist", "hip"}),
        ("pencil_skirt", {"hip"}),
        ("tshirt+bodice=strapless,sleeve=none", set()),
    ],
)
def test_levels_lie_where_the_draft_has_them(name, known):
    """Broken where a waist line is drawn at another height than the draft's, or on a sleeve, or where nothing shows
    it."""
    measures = BodyMeasures(
        nape_height=1.38, waist_height=1.02, hip_height=0.79, armpit_height=1.24, crotch_height=0.75
    )
    found = find_levels(draft_template(name, measures), measures)
    assert known <= {level.name for level in found} and bool(known) == bool(found)
    heights = {"waist": measures.waist_height, "hip": measures.hip_height}
    for level in found:
        panel = draft_template(name, measures).panel(level.panel)
        assert not level.panel.startswith("sleeve")
        if level.name in heights:
            placed = float(level.point @ panel.rotation[1, :2] + panel.translation[1])
            assert placed == pytest.approx(heights[level.name], abs=0.015)


def test_trousers_that_hang_low_have_their_hip_line_nearer():
    """Broken where the waist of low trousers is taken for the wearer's, and the hip line lies below the hips."""
    measures, pattern = BodyMeasures(), load_template("trousers")
    usual, low = (
        {level.panel: level.point[1] for level in find_levels(pattern, measures, height) if level.name == "hip"}
        for height in (None, measures.waist_height - 0.05)
    )
    assert usual.keys() == low.keys() and len(low) == 4
    assert all(low[name] - usual[name] == pytest.approx(0.05) for name in low)
    worn = load_worn_template("trousers", get_fabric("single_jersey"))
    if worn is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    hang = find_hang_height(worn.waist, worn.body)
    found = find_levels(worn.pattern, measure_wearer(worn.body), hang)
    for level in (level for level in found if level.name == "hip"):
        panel = worn.pattern.panel(level.panel)
        placed = float(level.point @ panel.rotation[1, :2] + panel.translation[1])
        assert placed == pytest.approx(measure_wearer(worn.body).hip_height, abs=0.03)


@pytest.mark.parametrize("fold", [False, True])
def test_the_middle_is_marked(fold):
    """Broken where a cutter cannot tell the centre front, or a half piece's is not its fold."""
    made = pieces_of("tshirt", fold=fold)
    for piece, name in zip(made.pieces, ("CF", "CB", None), strict=True):
        assert [line.name for line in piece.lines] == ([name] if name else [])
        outline = Polygon(flatten_outline(piece.net)[0])
        for line in piece.lines:
            assert np.ptp(line.points[:, 0]) < 1e-9
            middle = outline.bounds[0] if fold else (outline.bounds[0] + outline.bounds[2]) / 2.0
            assert line.points[0, 0] == pytest.approx(middle, abs=1e-4)
            assert LineString(line.points).within(outline.buffer(1e-6))
    split = pieces_of("jumpsuit")
    assert [{line.name for line in piece.lines} for piece in split.pieces] == [{"CF"}, {"CB"}]


def test_lines_reach_every_file():
    """Broken where a line or its name is left out of SVG or DXF."""
    made = pieces_of("tshirt")
    assert ">CF<" in pieces_svg(made) and ">CB<" in pieces_svg(made)
    blocks = [Block(piece, piece.name, "BASE") for piece in made.pieces]
    drawing = ezdxf.read(io.StringIO(dxf_text(made, blocks, DIALECTS_BY_NAME["aama"]), newline=None))
    block = drawing.blocks.get("FRONT")
    (line,) = [one for one in block if one.dxftype() == "POLYLINE" and one.dxf.layer == "8"]
    drawn = 1e-3 * np.array([vertex.dxf.location for vertex in line.vertices])[:, :2]
    assert np.abs(drawn - made.pieces[0].lines[0].points).max() < 1e-6
    assert any(text.dxf.text == "CF" for text in block.query("TEXT"))


def test_titles_are_words(tmp_path):
    """Broken where a title shows a pattern's name as the program has it, or leaves out scan, day or stretch."""
    assert describe_garment("tshirt+neckline=v,sleeve_head=set-in") == "tshirt, v neckline, set-in sleeve head"
    worn = load_worn_template("tshirt", get_fabric("single_jersey"))
    if worn is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    (tmp_path / "manifest.json").write_text('{"scan": {"name": "Anna Müller.ply"}}', encoding="utf-8")
    made = Production(worn, ExportOptions("pdf"), tmp_path, made="2026-11-28").pieces
    assert dict(made.details) == {"scan": "Anna Müller", "made": "2026-11-28"}
    assert made.is_stretchy and made.drafted[0].name == "NECK_RIB"
    assert {"CF", "bust", "waist"} <= {line.name for line in made.pieces[0].lines}


def test_knits_stretch_and_cloth_does_not():
    """Broken where a T-shirt's jersey gets a woven's facing, or denim a rib."""
    found = {fabric.name: is_stretchy(fabric) for fabric in load_fabrics()}
    assert all(
        found[name] for name in ("single_jersey", "interlock_knit", "ponte_roma", "rib_knit", "sweatshirt_fleece")
    )
    assert not any(found[name] for name in ("cotton_poplin", "denim", "linen", "silk_chiffon", "wool_plain", "canvas"))


def test_sleeves_and_bands_have_no_body_lines():
    """Broken where a waistband is marked with its own middle, or a sleeve as a front."""
    made = make_pieces(load_template("pencil_skirt"), PieceSettings())
    assert not next(piece for piece in made.pieces if piece.name == "BAND").lines
