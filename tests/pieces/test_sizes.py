"""Graded sizes against the drafts, and rules against the nest."""

import functools
import io
from dataclasses import replace
from xml.etree import ElementTree

import ezdxf
import numpy as np
import pytest
from garmentq.cli.size_table import read_sizes
from garmentq.core.deliver.formats.dialects import DIALECTS_BY_NAME
from garmentq.core.deliver.formats.dxf import Block, dxf_text, rule_text
from garmentq.core.deliver.formats.errors import SizesBad
from garmentq.core.deliver.formats.flat_dxf import flat_text
from garmentq.core.deliver.formats.grading import grade_sizes
from garmentq.core.deliver.formats.nest import draw_nest, find_rules, nest_pdf
from garmentq.core.deliver.formats.options import ExportOptions
from garmentq.core.deliver.formats.size_layers import NAMES_PER_LINE
from garmentq.core.deliver.formats.size_lines import SizeLine
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.templates import load_template
from garmentq_pieces import TEMPLATES
from pypdf import PdfReader
from shapely import Polygon

BASE = BodyMeasures()


@functools.cache
def sizes_of(name, first=-1, last=1):
    """Grade a template whose body is that of the drafts, one point pulled as a recovery pulls it."""
    pattern = load_template(name)
    return pattern, grade_sizes(pattern, name, BASE, 1.70, ExportOptions("sizes", first=first, last=last))


@functools.cache
def pieces_of_sizes(name):
    """Make the pieces of those sizes once for all tests."""
    return [make_pieces(size.pattern) for size in sizes_of(name)[1]]


@pytest.mark.parametrize("name", TEMPLATES)
def test_seams_of_all_sizes_walk_and_the_base_stays(name):
    """Broken where step 0 changes a point, a seam walks off by 0.5 mm, or a size is told apart by nothing."""
    pattern, sizes = sizes_of(name)
    base = next(size for size in sizes if size.is_base)
    assert base.pattern is pattern and all(size.is_drafted for size in sizes)
    for size in sizes:
        assert seam_mismatch(size.pattern) < 5e-4
        assert [len(p.points) for p in size.pattern.panels] == [len(p.points) for p in pattern.panels]
    assert len({size.name for size in sizes}) == len(sizes) == 3


def test_girth_grows_by_the_step():
    """Broken where a T-shirt's chest does not grow by 4 cm from size to size, to 1 mm."""
    _, sizes = sizes_of("tshirt", -2, 4)
    girths = []
    for size in sizes:
        widths = [float(np.ptp(size.pattern.panel(name).points[:, 0])) for name in ("front", "back")]
        girths.append(sum(widths))
    assert np.diff(girths) == pytest.approx(0.04, abs=1e-3)


@pytest.mark.parametrize("dialect", ["aama", "clo", "gerber"])
@pytest.mark.parametrize("name", ["tshirt", pytest.param("trousers", marks=pytest.mark.nightly)])
def test_rules_move_the_base_onto_the_nest(name, dialect):
    """Broken where a rule table and the nest disagree: every point with a rule, moved, is a vertex of the nest."""
    _, sizes = sizes_of(name)
    rule = DIALECTS_BY_NAME[dialect]
    pieces = pieces_of_sizes(name)
    base = next(n for n, size in enumerate(sizes) if size.is_base)
    moves, rules = find_rules(pieces, base)
    assert set(rules) >= {piece.name for piece in pieces[base].pieces}
    own = [Block(p, p.name, sizes[base].name) for p in pieces[base].pieces]
    graded = ezdxf.read(io.StringIO(dxf_text(pieces[base], own, rule, rules), newline=None))
    blocks = [Block(p, f"{p.name}_{s.name}", s.name) for s, one in zip(sizes, pieces, strict=True) for p in one.pieces]
    nest = ezdxf.read(io.StringIO(dxf_text(pieces[base], blocks, rule), newline=None))
    table = read_rules(rule_text(rule, tuple(s.name for s in sizes), moves, sizes[base].name))
    unit = 0.0254 if rule.is_inch else 1e-3
    for piece in pieces[base].pieces:
        block = graded.blocks.get(piece.name)
        texts = [t for t in block.query("TEXT") if t.dxf.text.startswith("# ")]
        corners = np.array([list(p.dxf.location)[:2] for p in block.query("POINT") if p.dxf.layer == "2"])
        places = np.array([list(t.dxf.insert)[:2] for t in texts])
        assert max(np.abs(places - corner).max(axis=1).min() for corner in corners) < 1e-3  # each turn point has a rule
        for k, size in enumerate(sizes):
            other = nest.blocks.get(f"{piece.name}_{size.name}")
            lines = [line for line in other if line.dxftype() == "POLYLINE"]
            vertices = np.array([list(v.dxf.location)[:2] for line in lines for v in line.vertices])
            for text, place in zip(texts, places, strict=True):
                moved = place + table[int(text.dxf.text[2:])][k]
                assert np.abs(vertices - moved).max(axis=1).min() * unit < 1e-5
    assert all(np.all(table[n][base] == 0.0) for n in table)


def read_rules(text):
    """Return the movements of each rule as they are written, shape [size_count, 2]."""
    lines = text.splitlines()
    count = len(next(line for line in lines if line.startswith("SIZE LIST")).split(":")[1].split())
    found, number = {}, 0
    for line in lines:
        if line.startswith("RULE: DELTA"):
            number = int(line.split()[-1])
            found[number] = []
        elif number and line != "END":
            found[number] += [float(word) for word in line.replace(",", " ").split()]
    assert lines[-1] == "END" and all(len(values) == 2 * count for values in found.values())
    return {number: np.array(values).reshape(-1, 2) for number, values in found.items()}


def test_nest_is_one_page_of_all_sizes():
    """Broken where a size or the base's mark is missing from the nest."""
    _, sizes = sizes_of("tshirt")
    content = nest_pdf(sizes, pieces_of_sizes("tshirt"), 914.0)
    (page,) = PdfReader(io.BytesIO(content)).pages
    assert all(size.name in page.extract_text() for size in sizes) and "base" in page.extract_text()


def test_each_size_has_a_layer_with_its_name_on_each_line():
    """Broken where a size cannot be hidden, its lines are on another's layer, or a line does not say whose it is."""
    _, sizes = sizes_of("tshirt")
    pieces = pieces_of_sizes("tshirt")
    reader = PdfReader(io.BytesIO(nest_pdf(sizes, pieces, 914.0)))
    groups = reader.trailer["/Root"]["/OCProperties"]["/OCGs"]
    assert [group.get_object()["/Name"] for group in groups] == [f"size {size.name}" for size in sizes]
    content = reader.pages[0].get_contents().get_data().decode("latin-1")
    named = reader.pages[0]["/Resources"]["/Properties"]
    for k, (size, one) in enumerate(zip(sizes, pieces, strict=True)):
        assert named[f"/S{k}"].get_object()["/Name"] == f"size {size.name}"
        layer = content.split(f"/OC /S{k} BDC")[1].split("EMC")[0]
        assert layer.count(f"({size.name}) Tj") == NAMES_PER_LINE * len(one.cut_pieces)
        assert not any(f"({other.name}) Tj" in layer for other in sizes if other is not size)
        paths = [line.split("d ", 1)[1] for line in layer.splitlines() if line.endswith(" s") and "0.15 w" not in line]
        drawn = [np.array([float(w) for w in path.split() if w not in "mls"]).reshape(-1, 2) for path in paths]
        areas = [1e-6 * Polygon(points).area for points in drawn]
        assert areas == pytest.approx([Polygon(piece.cut.points).area for piece in one.cut_pieces], rel=1e-4)


def test_a_nest_of_svg_has_the_same_layers():
    """Broken where a drawing program finds the sizes of a nest in one layer, or at another scale."""
    _, sizes = sizes_of("tshirt")
    pieces = pieces_of_sizes("tshirt")
    root = ElementTree.fromstring(draw_nest(sizes, pieces, 914.0))
    space = "{http://www.w3.org/2000/svg}"
    layers = {group.get("id"): group for group in root.findall(f"{space}g")}
    assert list(layers) == [*(f"size-{size.name}" for size in sizes), "marks"]
    for size, one in zip(sizes, pieces, strict=True):
        layer = layers[f"size-{size.name}"]
        cut = [path.get("d") for path in layer.findall(f"{space}path") if path.get("class") == "cut"]
        points = [
            np.array([float(w) for w in d.replace("M", "").replace("L", "").replace("Z", "").split()]) for d in cut
        ]
        areas = [1e-6 * Polygon(one_line.reshape(-1, 2)).area for one_line in points]
        assert areas == pytest.approx([Polygon(piece.cut.points).area for piece in one.cut_pieces], rel=1e-4)
        assert {text.text for text in layer.findall(f"{space}text")} == {size.name}


def test_a_flat_nest_has_layers_of_each_size():
    """Broken where a laser cuts all sizes at once, or the sizes do not lie upon each other."""
    _, sizes = sizes_of("tshirt")
    pieces = pieces_of_sizes("tshirt")
    text = flat_text([(size.name, one) for size, one in zip(sizes, pieces, strict=True)])
    space = ezdxf.read(io.StringIO(text, newline=None)).modelspace()
    cut = {
        size.name: [line for line in space.query("POLYLINE") if line.dxf.layer == f"CUT_{size.name}"] for size in sizes
    }
    for lines, one in zip(cut.values(), pieces, strict=True):
        areas = [1e-6 * Polygon([list(v.dxf.location)[:2] for v in line.vertices]).area for line in lines]
        assert areas == pytest.approx([Polygon(piece.cut.points).area for piece in one.cut_pieces], rel=1e-4)
    fronts = [Polygon([list(v.dxf.location)[:2] for v in lines[0].vertices]) for lines in cut.values()]
    assert all(one.intersection(other).area > 0.9 * one.area for one in fronts for other in fronts)


def test_a_table_says_girths_and_heights():
    """Broken where a line of a table is taken for a step, or a height moves nothing."""
    lines = tuple(SizeLine(**line) for line in read_sizes("name,bust,waist,hip,height\nS,84,64,92,165\nL,100,,,\n"))
    sizes = grade_sizes(load_template("dress"), "dress", BASE, 1.70, ExportOptions("sizes", sizes=lines))
    assert [size.name for size in sizes] == ["S", "BASE", "L"]
    small, base, large = (size.measures for size in sizes)
    assert (small.bust, small.waist, small.hip) == (0.84, 0.64, 0.92) and large.waist == base.waist
    assert small.nape_height == pytest.approx(base.nape_height * 1.65 / 1.70)


def test_a_recovered_curve_is_graded_by_the_draft():
    """Broken where an edge that is straight in the draft, and was recovered as a curve, makes sizes approximate."""
    pattern = load_template("trousers")
    panel = pattern.panels[0]
    edges = tuple(
        Edge("cubic", np.array([[0.3, 0.02], [0.7, 0.02]]), edge.label, edge.contour) if edge.kind == "line" else edge
        for edge in panel.edges
    )
    assert any(edge.kind == "line" for edge in panel.edges)
    curved = replace(pattern, panels=(replace(panel, edges=edges), *pattern.panels[1:]))
    sizes = grade_sizes(curved, "trousers", BASE, 1.70, ExportOptions("sizes", first=-1, last=1))
    assert all(size.is_drafted for size in sizes)


def test_a_pattern_without_a_draft_is_spread_and_says_so():
    """Broken where an imported pattern passes for one that was drafted."""
    pattern = load_template("skirt")
    spread = grade_sizes(pattern, "of my own", BASE, 1.70, ExportOptions("sizes"))
    assert [size.is_drafted for size in spread] == [size.is_base for size in spread]
    renamed = Pattern("p", tuple(Panel(f"x{p.name}", p.points, p.edges) for p in pattern.panels), ())
    assert not grade_sizes(renamed, "skirt", BASE, 1.70, ExportOptions("sizes"))[0].is_drafted


@pytest.mark.parametrize("names", [("S", "s"), ("",), ("/",), ("BASE",)])
def test_sizes_of_one_name_are_refused(names):
    """Broken where one size's file replaces another's."""
    with pytest.raises(SizesBad):
        lines = tuple(SizeLine(name, bust=80.0 + n) for n, name in enumerate(names))
        grade_sizes(load_template("skirt"), "skirt", BASE, 1.70, ExportOptions("sizes", sizes=lines))


@pytest.mark.parametrize("name", ["9f86" + 60 * "0", 41 * "x"])
def test_a_size_is_not_named_as_a_stored_file(name):
    """Broken where a name in an order is as long as a file's hash, and a file that it names is kept for ever."""
    with pytest.raises(SizesBad, match="letters"):
        ExportOptions("sizes", sizes=(SizeLine(name),))
