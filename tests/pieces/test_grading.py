"""Figures of graded sizes against their rules, sleeves against armholes, and tables of sizes as people have them."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
import pytest
from garmentq.cli.size_table import read_sizes
from garmentq.core.body.measure_table import MeasuresUnclear
from garmentq.core.deliver.formats.charts import PUBLISHED_CHARTS
from garmentq.core.deliver.formats.errors import SizesBad, SizesUnclear
from garmentq.core.deliver.formats.grade_table import make_grade_table, write_grade_table
from garmentq.core.deliver.formats.grading import draft_measures, grade_sizes, table_growth
from garmentq.core.deliver.formats.options import ExportOptions
from garmentq.core.deliver.formats.papers import find_paper
from garmentq.core.deliver.formats.registry import CHARTS
from garmentq.core.deliver.formats.size_lines import SizeLine
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.pattern import EdgeRef, Pattern
from garmentq.core.garment.pieces.trueing import true_pattern
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.sizes.arm_points import find_arm_halves
from garmentq.core.garment.sizes.bodice_points import find_bodice_points
from garmentq.core.garment.sizes.closing import find_eased_seams, measure_ease
from garmentq.core.garment.sizes.errors import CapUnfit
from garmentq.core.garment.sizes.graded import GradedPattern, grade_pattern
from garmentq.core.garment.sizes.growth import Growth
from garmentq.core.garment.sizes.raglan_points import find_raglan_halves, find_raglan_throat, find_shares
from garmentq.core.garment.templates import draft_template, load_template
from pypdf import PdfReader
from shapely.geometry import LineString, Polygon

BASE = BodyMeasures()
SHIRT = "tshirt+sleeve=long,sleeve_head=set-in,front=buttons,collar=shirt,cuff=shirt,yoke=back"
RAGLAN = "long_sleeve_tshirt+sleeve_head=raglan"
UNEVEN = Growth.follow(0.08, 0.05, 0.06, 1.02)
"""A size whose girths do not grow alike, of a taller wearer."""


def grade(name: str, growth: Growth, drafted: bool = True) -> tuple[Pattern, GradedPattern]:
    """Grade a template for the wearer of the drafts, by its draft or as a pattern from elsewhere."""
    pattern = load_template(name)
    drafts = (draft_template(name, BASE), draft_template(name, draft_measures(BASE, growth))) if drafted else None
    return pattern, grade_pattern(pattern, BASE, 1.70, growth, drafts)


def forget_names(pattern: Pattern) -> Pattern:
    """Return a pattern as a file of another program has it: numbered panels without labels and contours."""
    names = {panel.name: f"p{n}" for n, panel in enumerate(pattern.panels)}
    panels = tuple(
        replace(p, name=names[p.name], label="", edges=tuple(replace(e, label="", contour="") for e in p.edges))
        for p in pattern.panels
    )
    seams = tuple(
        replace(s, a=EdgeRef(names[s.a.panel], s.a.edge), b=EdgeRef(names[s.b.panel], s.b.edge)) for s in pattern.seams
    )
    return replace(pattern, panels=panels, seams=seams)


def girth_at_underarm(path: Path) -> float:
    """Return the width of front and back at their underarm points [m], of a file, without any of our readers."""
    panels = json.loads(path.read_text())["pattern"]["panels"]
    width = 0.0
    for name in ("front", "back"):
        xy = 0.01 * np.array(panels[name]["vertices"])
        level = float(np.sort(xy[:, 1])[2]) - 1e-4  # above both points of the hem
        line = LineString([(-2.0, level), (2.0, level)])
        width += Polygon(xy).intersection(line).length
    return width


@pytest.mark.parametrize("drafted", [True, False])
@pytest.mark.parametrize("name", ["tshirt", "dress", "trousers", "skirt", SHIRT, RAGLAN])
@pytest.mark.parametrize("growth", [Growth.follow(-0.08, -0.08, -0.08), Growth.follow(0.16, 0.16, 0.16), UNEVEN])
def test_every_figure_grows_by_its_rule(name, growth, drafted):
    """Broken where a figure is 1 mm off its rule, a seam walks off, or a cap gets another ease than the base's."""
    pattern, graded = grade(name, growth, drafted)
    assert len(graded.figures) >= 4 and graded.is_drafted is drafted
    for figure in graded.figures:
        grown = figure.value(graded.pattern) - figure.value(pattern)
        assert grown == pytest.approx(figure.rule.grow(growth, figure.value(pattern)), abs=1e-4), figure.name
    assert seam_mismatch(graded.pattern) < seam_mismatch(pattern) + 1e-5
    assert measure_ease(graded.pattern) == pytest.approx(measure_ease(pattern), abs=1e-5)


def test_a_sleeve_grows_as_the_trade_grades_it():
    """Broken where a size has a narrower arm, a lower cap or a shorter underarm seam than the one before."""
    halves = [find_arm_halves(grade("tshirt", Growth.follow(d, d, d))[1].pattern) for d in (-0.04, 0.0, 0.04)]
    width, cap, under = (
        np.diff([np.mean([value(half) for half in one]) for one in halves])
        for value in (lambda h: 2 * h.width, lambda h: h.cap_height, lambda h: h.length - h.cap_height)
    )
    assert width == pytest.approx(0.012, abs=1e-5)
    assert np.all((cap > 2e-3) & (cap < 5e-3)) and np.all((under >= 0.0) & (under < 3e-3))


@pytest.mark.parametrize("drafted", [True, False])
def test_a_raglan_sleeve_grows_from_the_side_neck_point(drafted):
    """Broken where a raglan sleeve follows the draft alone: its neckline, its length with the shoulder, and its bicep
    have no rule, or the bodice and the sleeve do not share the neckline's growth as they share its width."""
    pattern, graded = grade(RAGLAN, Growth.follow(0.08, 0.08, 0.08), drafted)
    grown = {figure.name: figure.value(graded.pattern) - figure.value(pattern) for figure in graded.figures}
    assert grown["bicep"] == pytest.approx(0.024, abs=1e-5)
    assert grown["sleeve length"] == pytest.approx(0.010 + 0.005, abs=1e-5)
    assert grown["neck width, front"] == pytest.approx(0.008, abs=1e-5)
    assert grown["neck depth, front"] == pytest.approx(0.004, abs=1e-5)
    halves = find_raglan_halves(pattern)
    assert len(halves) == len(find_arm_halves(pattern)) == 4
    for half in halves:
        throat = find_raglan_throat(pattern, next(f for f in find_bodice_points(pattern) if f.face is half.face))
        wide, deep = find_shares(pattern, half, throat)
        assert 0.4 < wide < 1.0 and 0.0 <= deep < 1.0
    assert not find_raglan_halves(load_template("tshirt")) and not find_raglan_halves(load_template(SHIRT))


def test_men_grow_less_at_the_hips_than_women():
    """Broken where a men's chart grows hips, armholes and lengths by the ratios of women's."""
    lines = PUBLISHED_CHARTS["ru-men"].lines
    growth = table_growth(replace(BASE, bust=1.0, waist=0.78, hip=0.964), 1.76, lines[4], lines)
    assert (growth.bust, growth.waist, growth.hip) == pytest.approx((0.04, 0.04, 0.024))
    assert (growth.armhole_depth, growth.back_length, growth.rise) == pytest.approx((0.003, 0.002, 0.001))
    assert growth.neck == pytest.approx(0.008) and growth.stature == pytest.approx(1.0)


@pytest.mark.parametrize("drafted", [True, False])
def test_caps_and_armholes_keep_their_tangents(drafted):
    """Broken where a cap gets a peak or a dent over the shoulder as sizes grow, or an armhole is not level below."""
    pattern, graded = grade(SHIRT, Growth.follow(0.16, 0.16, 0.16), drafted)
    for seam, is_cap in zip(pattern.seams, find_eased_seams(pattern), strict=True):
        for ref in (seam.a, seam.b) if is_cap else ():
            ends = [end_tangents(one, ref) for one in (pattern, graded.pattern)]
            turned = np.degrees(np.arccos(np.clip((ends[0] * ends[1]).sum(axis=1), -1.0, 1.0)))
            assert turned.max() < 5.0, ref


@pytest.mark.parametrize("name", ["tshirt", "dress", "trousers", "skirt"])
def test_cut_pieces_have_the_figures_of_the_table(name):
    """Broken where trueing, size by size, takes a figure of the pieces that are cut 1 mm off its rule."""
    pattern = true_pattern(load_template(name)).pattern
    for size in grade_sizes(pattern, name, BASE, 1.70, ExportOptions("sizes", step=12.0, first=-1, last=1)):
        cut = true_pattern(size.pattern).pattern
        for figure in size.figures:
            due = figure.value(pattern) + figure.rule.grow(size.growth, figure.value(pattern))
            assert figure.value(cut) == pytest.approx(due, abs=1e-3), (size.name, figure.name)


def end_tangents(pattern: Pattern, ref: EdgeRef) -> np.ndarray:
    """Return the unit tangents at both ends of a cubic edge, shape [2, 2]."""
    panel = pattern.panel(ref.panel)
    start, end = panel.points[ref.edge], panel.points[(ref.edge + 1) % len(panel.points)]
    along, left = end - start, np.array([-(end - start)[1], (end - start)[0]])
    first, last = (start + h[0] * along + h[1] * left for h in panel.edges[ref.edge].handles[[0, -1]])
    found = np.array([first - start, end - last])
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def test_a_low_cap_grows_in_height_and_width_alike():
    """Broken where a cap of 3 cm on a sleeve of 33, whose length hardly changes with its height, is doubled to fit."""
    pattern = load_template("tshirt")
    low = pattern.with_points(
        {name: _flatten_cap(pattern, name) for name in (p.name for p in pattern.panels if p.label == "sleeve")}
    )
    sizes = grade_sizes(low, "of my own", BASE, 1.70, ExportOptions("sizes", first=-1, last=4))
    rows = {row.figure: np.array(row.growth) for row in make_grade_table(sizes)}
    half = find_arm_halves(low)[0]
    assert half.cap_height < 0.3 * half.width and rows["cap ease"] == pytest.approx(0.0, abs=1e-4)
    assert rows["cap height"] / half.cap_height == pytest.approx(rows["bicep"] / (2 * half.width), abs=0.02)
    assert np.all(np.diff(rows["bicep"]) > 0.012)


def _flatten_cap(pattern: Pattern, name: str) -> np.ndarray:
    """Return the points of half a sleeve whose underarm point is moved to the shoulder and outwards."""
    half = next(half for half in find_arm_halves(pattern) if half.under[0] == name)
    points = pattern.panel(name).points.copy()
    back = -0.055 * half.along + 0.02 * half.across
    points[half.under[1]] += back @ pattern.panel(name).rotation[:, :2]
    return points


def test_points_are_found_without_names():
    """Broken where a pattern of another program has other named points than the same pattern with names."""
    named = load_template("tshirt")
    bare = forget_names(named)
    numbers = {f"p{n}": panel.name for n, panel in enumerate(named.panels)}
    for own, other in zip(find_bodice_points(named), find_bodice_points(bare), strict=True):
        for field in ("tips", "underarms", "necks"):
            renamed = {sign: (numbers[name], i) for sign, (name, i) in getattr(other, field).items()}
            assert renamed == getattr(own, field)
    assert [half.width for half in find_arm_halves(bare)] == [half.width for half in find_arm_halves(named)]


def test_sizes_of_a_file_without_names(tmp_path):
    """Broken where a shirt of another program, written and read again, is scaled: its chest then grows by more than
    the step, as the ease does, and its sleeves lose theirs."""
    save_pattern(forget_names(load_template(SHIRT)), tmp_path / "shirt.json")
    shirt = load_pattern(tmp_path / "shirt.json")
    sizes = grade_sizes(shirt, "of my own", BASE, 1.70, ExportOptions("sizes", first=-1, last=1))
    for row in make_grade_table(sizes):
        if row.figure in ("chest", "bicep", "cap ease"):
            step = {"chest": 0.04, "bicep": 0.012, "cap ease": 0.0}[row.figure]
            assert row.growth == pytest.approx([-step, 0.0, step], abs=1e-4)


def test_a_sizes_file_has_the_girth_that_the_table_says(tmp_path):
    """Broken where the grade table tells another chest than the written pattern, read by another library, has."""
    sizes = grade_sizes(load_template("tshirt"), "tshirt", BASE, 1.70, ExportOptions("sizes", first=-1, last=2))
    girths = [girth_at_underarm(save_pattern(s.pattern, tmp_path / f"{s.name}.json")) for s in sizes]
    pdf, table = write_grade_table(sizes, "tee", "mm", find_paper("a4"), tmp_path)
    rows = {row["figure"]: row for row in csv.DictReader(io.StringIO(table.read_text()))}
    told = [float(rows["chest"][f"{size.name} [mm]"]) for size in sizes]
    base = next(n for n, size in enumerate(sizes) if size.is_base)
    assert 1e3 * (np.array(girths) - girths[base]) == pytest.approx(told, abs=0.5)
    text = PdfReader(pdf).pages[0].extract_text()
    assert all(word in text for word in ("bicep", "cap height", "armhole depth, front", "upper arm", "+12.0", "B96"))


def test_a_grade_table_of_many_sizes_has_pages_in_its_unit(tmp_path):
    """Broken where sizes beyond the paper's width are lost, or inches are printed as centimetres."""
    sizes = grade_sizes(load_template("skirt"), "skirt", BASE, 1.70, ExportOptions("sizes", first=-4, last=5))
    pdf, table = write_grade_table(sizes, "skirt", "inch", find_paper("roll"), tmp_path)
    text = "".join(page.extract_text() for page in PdfReader(pdf).pages)
    assert len(PdfReader(pdf).pages) == 2 and all(size.name in text for size in sizes)
    assert "+1.575" in table.read_text() and "+1.57" in text


def test_a_table_of_the_arm_refits_the_cap():
    """Broken where a table's upper arm does not widen the sleeve, or one that no armhole takes is drawn as it may."""
    lines = tuple(
        SizeLine(n, b, b - 20, b + 8, upper_arm=a) for n, b, a in (("S", 88, 27), ("M", 92, 29), ("L", 96, 31))
    )
    sizes = grade_sizes(load_template("tshirt"), "tshirt", BASE, 1.70, ExportOptions("sizes", sizes=lines))
    rows = {row.figure: row.growth for row in make_grade_table(sizes)}
    assert rows["bicep"] == pytest.approx([-0.02, 0.0, 0.02], abs=1e-4)
    wide = (*lines[:2], replace(lines[2], upper_arm=60.0))
    with pytest.raises(CapUnfit):
        grade_sizes(load_template("tshirt"), "tshirt", BASE, 1.70, ExportOptions("sizes", sizes=wide))


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("name,bust,waist,hip\nM,92,72,100\n", "cm"),
        ("Size;Bust (mm);Waist (mm);Hips (mm)\nM;920;720;1000\n", "cm"),
        ("\ufeffname,chest [inch],waist_in,hip (inches)\nM,36.220472,28.346457,39.370079\n", "cm"),
        ("name\tbust\twaist\thip\nM\t36.220472\t28.346457\t39.370079\n", "inch"),
        ("name;bust;waist;hip\nM;92,0;72,0;100,0\n", "cm"),
        ('[{"name": "M", "bust": 920, "waist": 720, "hip": 1000}]', "mm"),
        ("name,bust,waist,hip\nM,0.92,0.72,1.0\n", ""),
        ("size,bust,waist,hip\nM,920 mm,72,1 m\n", ""),
        ("Größe;Brustumfang;Taillenumfang;Hüftumfang\nM;92,0;72,0;100,0\n", ""),
        ("Taille;Tour de poitrine;Tour de taille;Hanches\nM;92,0;72,0;100,0\n", ""),
        ("Taille;Tour de poitrine;Tour de taille;Hanches\n38;92;72;100\n", ""),
        ("talla|pecho|cintura|cadera\nM|92|72|100\n", ""),
        ("taglia,torace,vita,fianchi\nM,92,72,100\n", ""),
        ("name: M\nbust: 92\nwaist: 72\nhip: 100\n", ""),
    ],
)
def test_units_stand_in_the_head(text, unit):
    """Broken where a table in inches or millimetres is read as centimetres, or one with semicolons or headings of
    another language is refused: whatever the reader of a person's measures takes, a table of sizes may have."""
    (line,) = read_sizes(text, unit)
    assert line == {"name": "38" if "38;" in text else "M", "bust": 92.0, "waist": 72.0, "hip": 100.0}


@pytest.mark.parametrize(
    "text",
    [
        "name,bra\nM,92\n",
        "bust,chest\n92,92\n",
        "name,bust,chest\nM,92,93\n",
        "name,bust [ell]\nM,2\n",
        "name,bust,inseam\nM,92,78\n",
        "name,bust,gender\nM,92,female\n",
        "",
        "[1]",
    ],
)
def test_a_head_that_nobody_knows_is_refused(text):
    """Broken where an unknown column is passed over, or two columns of one measure are."""
    with pytest.raises(click.UsageError):
        read_sizes(text)


def test_a_table_of_sizes_asks_as_one_of_measures_does():
    """Broken where a table that may be in inches is read in centimetres, its answer is not taken, or the arm's and
    back's columns are lost on the way through the measures' words; a child's first size is no inch."""
    text = "name,bust,waist,hip,height\nS,34,27,37,66\n"
    with pytest.raises(MeasuresUnclear, match=r"inch: bust 86\.36 cm"):
        read_sizes(text)
    assert read_sizes(text, "inch")[0]["bust"] == 86.36 and read_sizes(text, is_sure=True)[0]["bust"] == 34.0
    (line,) = read_sizes(
        "name,bust,shoulder,scye depth,nape to waist,body rise,top arm,sleeve length\nM,88,12.2,21,41,28,28,58\n"
    )
    more = {"shoulder": 12.2, "armhole_depth": 21.0, "back_length": 41.0, "rise": 28.0, "upper_arm": 28.0}
    assert line == {"name": "M", "bust": 88.0, "arm_length": 58.0} | more and SizeLine(**line)
    rows = read_sizes("name,height,bust\n86,86,52\n116,116,60\n")
    assert [row["height"] for row in rows] == [86.0, 116.0]


@pytest.mark.parametrize(
    ("lines", "word"),
    [
        ([("S", 34, 27, 37, 66), ("M", 36, 29, 39, 66)], "inch"),
        ([("S", 880, 700, 950, 1700)], "mm"),
        ([("S", 88, 70, 96, None), ("M", 92, 68, 100, None)], "shrinks"),
        ([("S", 88, 70, 96, None), ("M", 129, 111, 137, None)], "jumps"),
        ([("S", 88, 150, 96, None)], "waist"),
    ],
)
def test_an_implausible_table_is_asked_about(lines, word):
    """Broken where inches pass as centimetres, or a misprint is graded; the answer has to be accepted."""
    table = tuple(SizeLine(*line) for line in lines)
    with pytest.raises(SizesUnclear, match=word) as asked:
        ExportOptions("sizes", sizes=table)
    assert "--sure" in asked.value.message and asked.value.code == "export.sizes_unclear"
    if word != "mm":
        assert ExportOptions("sizes", sizes=table, is_sure=True).size_lines == table


def test_a_size_far_from_the_wearer_is_asked_about():
    """Broken where a pattern is graded to a third of its wearer's bust without a question."""
    table = (SizeLine("S", 50, 48, 52),)
    with pytest.raises(SizesUnclear, match=r"50 cm.*92 cm"):
        grade_sizes(load_template("dress"), "dress", BASE, 1.70, ExportOptions("sizes", sizes=table))


@pytest.mark.parametrize("name", CHARTS)
def test_a_chart_is_a_table_with_a_source(name):
    """Broken where a chart has no source, would be asked about, or has a size that is not graded."""
    chart = PUBLISHED_CHARTS[name]
    assert chart.source and tuple(PUBLISHED_CHARTS) == CHARTS
    assert ExportOptions("sizes", sizes=chart.lines).size_lines == chart.lines
    chosen = (chart.lines[2].name, chart.lines[5].name)
    options = ExportOptions("sizes", chart=name, chosen=chosen)
    sizes = grade_sizes(load_template("tshirt"), "tshirt", BASE, 1.70, options)
    assert {size.name for size in sizes} == {*chosen, "BASE"}
    for size in sizes:
        line = next((line for line in chart.lines if line.name == size.name), None)
        assert line is None or size.measures.bust == pytest.approx(line.bust / 100.0)


@pytest.mark.parametrize(
    "wrong",
    [
        {"chart": "moon"},
        {"unit": "ell"},
        {"chart": "uk-women", "chosen": ("13",)},
        {"chart": "uk-women", "sizes": (SizeLine("S", 88),)},
        {"sizes": (SizeLine("S", 88, neck=36), SizeLine("M", 92))},
        {"sizes": (SizeLine("S", 88, neck=-1.0), SizeLine("M", 92, neck=36))},
    ],
)
def test_other_tables_are_refused(wrong):
    """Broken where an unknown chart, unit or size, or half a column, ends in a traceback or in a default."""
    with pytest.raises(SizesBad):
        ExportOptions("sizes", **wrong)


def test_other_measures_of_a_table_count_by_their_differences():
    """Broken where a table's neck is taken for the wearer's own, whose value no table knows."""
    lines = PUBLISHED_CHARTS["uk-women"].lines
    growth = table_growth(BASE, 1.70, lines[4], lines)
    assert growth.neck == pytest.approx(0.25 * (lines[4].bust / 100.0 - BASE.bust))
    assert growth.shoulder == pytest.approx((lines[4].bust / 100.0 - BASE.bust) / 16.0)
