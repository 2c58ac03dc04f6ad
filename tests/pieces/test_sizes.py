"""Graded sizes against the drafts, and rules against the nest."""

import functools
import io
from dataclasses import replace

import ezdxf
import numpy as np
import pytest
from garmentq.cli.sizes import read_sizes
from garmentq.core.deliver.formats.dialects import DIALECTS_BY_NAME
from garmentq.core.deliver.formats.dxf import Block, dxf_text, rule_text
from garmentq.core.deliver.formats.errors import SizesBad
from garmentq.core.deliver.formats.grading import grade_sizes
from garmentq.core.deliver.formats.nest import find_rules, nest_pdf
from garmentq.core.deliver.formats.options import ExportOptions, SizeLine
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.templates import load_template
from garmentq_pieces import TEMPLATES
from pypdf import PdfReader

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
    assert set(rules) == {piece.name for piece in pieces[base].pieces}
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


def test_a_pattern_without_a_draft_is_scaled_and_says_so():
    """Broken where an imported pattern passes for one that was drafted."""
    pattern = load_template("skirt")
    scaled = grade_sizes(pattern, "of my own", BASE, 1.70, ExportOptions("sizes"))
    assert [size.is_drafted for size in scaled] == [size.is_base for size in scaled]
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
