"""The document for CLO and Marvelous Designer, read by a reader of its own; the script, run against a stand-in."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from clo_program import DialogOpened, PatternWindow, run_program
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.clo import SeamUnsewable, edge_cubics, write_clo
from garmentq.core.garment.curves import edge_length, edge_points
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.seams import equalise_seams
from garmentq.core.garment.templates import list_templates, load_template

FABRIC = get_fabric("denim")
SCHEMA = json.loads((Path(__file__).parent / "clo_pattern.schema.json").read_text())
NAMES = [info.name for info in list_templates()]


def trace(line: dict, count: int = 400) -> np.ndarray:
    """Return points of a line of the document [mm]: of a cubic by its Bernstein polynomials."""
    held = np.array([[point["Position"]["x"], point["Position"]["y"]] for point in line["PointList"]])
    t = np.linspace(0.0, 1.0, count)[:, None]
    if len(held) == 2:
        return (1.0 - t) * held[0] + t * held[1]
    s = 1.0 - t
    return s**3 * held[0] + 3 * s * s * t * held[1] + 3 * s * t * t * held[2] + t**3 * held[3]


class Outline:
    """A piece of the document: its whole outline and where its lines end, by length."""

    def __init__(self, piece: dict) -> None:
        """Trace all lines one after the other."""
        lines = [trace(line) for line in piece["ShapeInfo"]["LineList"]]
        self.points = np.concatenate([line[:-1] for line in lines] + [lines[-1][-1:]])
        self.at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.points, axis=0), axis=1))])
        self.ends = self.at[np.cumsum([0] + [len(line) - 1 for line in lines])]
        self.keys = [line["ID"] for line in piece["ShapeInfo"]["LineList"]]

    def span(self, side: dict) -> np.ndarray:
        """Return 101 points along a seam's side in its direction, uniform in length [mm]."""
        start, end = (side["LengthParam"][name] * self.at[-1] for name in ("fStart", "fEnd"))
        assert (start < end) == side["Direction"]
        along = np.linspace(start, end, 101)
        return np.stack([np.interp(along, self.at, self.points[:, k]) for k in range(2)], axis=1)


def check_document(document: dict, pattern: Pattern) -> None:
    """Check a document against the schema and the pattern that it was made of."""
    jsonschema.validate(document, SCHEMA)
    keys = [piece["ID"] for piece in document["PatternList"]]
    keys += [line["ID"] for piece in document["PatternList"] for line in piece["ShapeInfo"]["LineList"]]
    for piece in document["PatternList"]:
        lines = [line["PointList"] for line in piece["ShapeInfo"]["LineList"]]
        for line, following in pairwise([*lines, lines[0]]):
            assert line[-1] == following[0]  # the very point, its id too
        keys += [point["ID"] for line in lines for point in line[:-1]]
    assert len(set(keys)) == len(keys)
    outlines = {piece["ID"]: Outline(piece) for piece in document["PatternList"]}
    places = {panel.name: key for panel, key in zip(pattern.panels, outlines, strict=True)}
    sewn = equalise_seams(pattern)
    assert len(document["SeamLinePairGroupList"]) == len(pattern.seams)
    for seam, group in zip(sewn.seams, document["SeamLinePairGroupList"], strict=True):
        sides = [group["PairList"][0][name] for name in ("First", "Second")]
        lengths = []
        for side, ref, is_forward in zip(sides, (seam.a, seam.b), (True, not seam.reversed), strict=True):
            outline = outlines[side["ShapeID"]]
            assert side["ShapeID"] == places[ref.panel]
            for end in side["LengthParam"].values():
                assert np.abs(outline.ends - end * outline.at[-1]).min() < 0.01  # seams end where lines end
            length = abs(side["LengthParam"]["fEnd"] - side["LengthParam"]["fStart"]) * outline.at[-1]
            assert length >= 3.0
            lengths.append(length)
            mine = 1e3 * edge_points(sewn.panel(ref.panel), ref.edge, 100)[:: 1 if is_forward else -1]
            found = outline.span(side)
            apart = (found - found[0]) - (mine - mine[0])  # pieces were moved apart, not turned
            assert np.abs(apart).max() < 0.02
        if not seam.gathered:
            assert lengths[0] == pytest.approx(lengths[1], abs=0.05)


@pytest.mark.parametrize("name", NAMES)
def test_documents_of_all_templates_sew_what_the_pattern_sews(name: str, tmp_path: Path) -> None:
    """Fails if a curve, a seam's span, its direction or an id were wrong, or sides differ by 0.05 mm."""
    pattern = load_template(name)
    document, _ = write_clo(pattern, FABRIC, tmp_path, name)
    check_document(json.loads(document.read_text()), pattern)


WAYS = [(name, "no_seams") for name in NAMES] + [("tank", way) for way in ("all", "refused", "absent")]


@pytest.mark.parametrize(("name", "imports"), WAYS)
def test_the_script_builds_every_template(name: str, imports: str, tmp_path: Path, monkeypatch) -> None:
    """Fails if the script leaves a seam out where an import does, names a line that is not there, or crosses a seam."""
    pattern = load_template(name)
    _, script = write_clo(pattern, FABRIC, tmp_path, name)
    window = PatternWindow(imports)
    said = run_program(script, window, monkeypatch)
    way = "document" if imports == "all" else "points"
    assert said == f"garmentq: {len(pattern.panels)} pieces and {len(pattern.seams)} seams by {way}, complete"
    assert [name for name, _ in window.pieces] == [panel.name for panel in pattern.panels]
    if way == "document":
        return
    sewn = equalise_seams(pattern)
    index = {panel.name: n for n, panel in enumerate(sewn.panels)}
    for seam, (a, line_a, b, line_b, forward_a, forward_b) in zip(sewn.seams, window.seams, strict=True):
        assert (a, line_a, b, line_b) == (index[seam.a.panel], seam.a.edge, index[seam.b.panel], seam.b.edge)
        assert (forward_a, forward_b) == (True, not seam.reversed)
        lengths = window.line_length(a, line_a), window.line_length(b, line_b)
        true = 1e3 * edge_length(sewn.panel(seam.a.panel), seam.a.edge)
        assert lengths[0] == pytest.approx(true, abs=max(0.05, 2e-4 * true))
        if not seam.gathered:
            assert lengths[0] == pytest.approx(lengths[1], abs=0.1)


def test_the_script_says_that_something_is_missing(tmp_path: Path, monkeypatch) -> None:
    """Fails if a program that refuses a seam is told to be complete."""
    _, script = write_clo(load_template("skirt"), FABRIC, tmp_path, "skirt")
    window = PatternWindow("refused")
    window.AddSeamlinePairGroup = lambda *sides: False
    assert "NOT COMPLETE" in run_program(script, window, monkeypatch)


def test_the_stand_in_keeps_the_documented_rules() -> None:
    """Fails if the stand-in took any line: the tests above would say nothing then."""
    window = PatternWindow()
    square = [(0.0, 0.0, 0), (10.0, 0.0, 0), (11.0, 5.0, 2), (10.0, 10.0, 0), (0.0, 10.0, 0)]
    assert window.CreatePatternWithPoints(square) == 0
    assert len(window.pieces[0][1]) == 4 and len(window.pieces[0][1][1]) == 3
    assert not window.AddSeamlinePairGroup(0, 4, 0, 1, True, False)
    assert not window.AddSeamlinePairGroup(1, 0, 0, 1, True, False)
    assert window.GetSeamlinePairGroupCount() == 0
    with pytest.raises(DialogOpened):
        window.AddSeamlinePairGroup(0, 1, 0, 1, True, False)


def square(name: str, edge: Edge, side: float = 0.2) -> Panel:
    """Return a square whose right edge is a given one."""
    points = side * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    return Panel(name, points, (Edge(), edge, Edge(), Edge()))


@pytest.mark.parametrize(
    "edge",
    [Edge("arc", np.array([[0.5, 0.4]])), Edge("quadratic", np.array([[0.3, 0.2]])),
     Edge("cubic", np.array([[0.2, 0.3], [0.9, -0.2]]))],
    ids=["arc", "quadratic", "cubic"],
)  # fmt: skip
def test_curves_become_cubics(edge: Edge) -> None:
    """Fails if a curve of any kind strays from its cubics by a tenth of a millimetre."""
    panel = square("a", edge)
    t = np.linspace(0.0, 1.0, 3000)[:, None]
    found = np.concatenate(
        [(1 - t) ** 3 * c[0] + 3 * (1 - t) ** 2 * t * c[1] + 3 * (1 - t) * t * t * c[2] + t**3 * c[3]
         for c in edge_cubics(panel, 1)]
    )  # fmt: skip
    true = edge_points(panel, 1, 3000)
    assert max(np.linalg.norm(true - point, axis=1).min() for point in found[::10]) < 1e-4
    assert max(np.linalg.norm(found - point, axis=1).min() for point in true[::10]) < 1e-4
    length = np.linalg.norm(np.diff(found, axis=0), axis=1).sum()
    assert length == pytest.approx(edge_length(panel, 1), rel=1e-5)


def test_seams_that_the_program_cannot_sew_are_refused(tmp_path: Path) -> None:
    """Fails if a sliver, an edge sewn to itself or sides of two lengths reach a file that drops every seam."""

    def sew(a: Panel, b: Panel, seam: Seam) -> Pattern:
        return Pattern("hostile", (a, b), (seam,))

    plain, small = square("a", Edge()), square("b", Edge(), 0.002)
    right = Seam(EdgeRef("a", 1), EdgeRef("b", 3))
    cases = {
        "to itself": sew(plain, square("b", Edge()), replace(right, b=right.a)),
        "0.100 mm long": sew(plain, square("b", Edge(), 1e-4), replace(right, gathered=True)),
        "2.00 mm long": sew(square("a", Edge(), 0.002), small, right),
    }
    for text, pattern in cases.items():
        with pytest.raises(SeamUnsewable, match=text) as caught:
            write_clo(pattern, FABRIC, tmp_path, "x")
        assert caught.value.code == "export.seam_unsewable"
        assert not list(tmp_path.iterdir())


def test_hostile_names_stay_text(tmp_path: Path, monkeypatch) -> None:
    """Fails if a panel's name could run code in the script or break the document."""
    name = '"""\n\'); __import__("os").abort() #\\'
    panels = (square(name, Edge()), square(name + "2", Edge()))
    pattern = Pattern("hostile", panels, (Seam(EdgeRef(name, 1), EdgeRef(name + "2", 3)),))
    document, script = write_clo(pattern, replace(FABRIC, name=name), tmp_path, "x")
    check_document(json.loads(document.read_text()), pattern)
    assert "complete" in run_program(script, PatternWindow("refused"), monkeypatch)


def test_same_pattern_same_bytes(tmp_path: Path) -> None:
    """Fails if ids were random."""
    first = [path.read_bytes() for path in write_clo(load_template("tank"), FABRIC, tmp_path, "x")]
    assert [path.read_bytes() for path in write_clo(load_template("tank"), FABRIC, tmp_path, "x")] == first
