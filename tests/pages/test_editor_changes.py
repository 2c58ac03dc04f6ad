"""Parallel edges, slash and spread, darts, names and lines of the editor's modules against what geometry demands."""

from __future__ import annotations

import json
from math import asin, hypot, pi, sin

import numpy as np
import pytest
from garmentq.core.garment.curves import edge_length
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.pieces.edge_names import name_edges
from garmentq.core.garment.pieces.seam_names import is_dart
from garmentq.core.garment.polygon import polygon_area
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.symmetry import find_symmetry
from garmentq.core.garment.templates import load_template

MODULES = {"m": "pattern_model", "d": "darts", "s": "spreading", "l": "parallel", "t": "distances", "n": "names",
           "p": "point_operations", "b": "tables", "y": "layout"}  # fmt: skip
KEPT = 1e-6
"""Largest difference of what an operation keeps [m, m2, rad]."""


@pytest.fixture(scope="module")
def blank(chromium, site):
    """Open a page of the service that has no script of its own, once for all tests: they change nothing on it."""
    context = chromium.new_context(base_url=site.url)
    page = context.new_page()
    page.goto("/signin")
    yield page
    context.close()


def run(page, script: str, argument=None):
    """Run a script with the editor's modules."""
    loads = "; ".join(f"const {short} = await import('/static/edit/{name}.js')" for short, name in MODULES.items())
    keep = "const keep = {symmetric: true, sewn: true}"
    return page.evaluate(f"async (argument) => {{ {loads}; {keep}; {script} }}", argument)


def change(page, pattern, script: str):
    """Return a pattern after an operation of the modules, as core reads it."""
    text = json.dumps(write_pattern(pattern))
    script = f"const pattern = m.readPattern(argument); {script}; return m.patternFile(done)"
    return read_pattern(run(page, script, text))


def make_square(side: float = 0.4):
    """Return a pattern of one square panel, counter-clockwise from its lower left corner, open all around."""
    points = [[0, 0], [side, 0], [side, side], [0, side]]
    edges = [{"endpoints": [k, (k + 1) % 4]} for k in range(4)]
    panels = {"front": {"vertices": points, "edges": edges, "translation": [0.1, 0, 0.1], "rotation": [0, 0, 0]}}
    properties = {"units_in_meter": 1, "curvature_coords": "relative"}
    return read_pattern({"pattern": {"panels": panels, "stitches": []}, "properties": properties})


def area(pattern, name: str = "front") -> float:
    """Return a straight panel's area [m2]."""
    return abs(float(polygon_area(pattern.panel(name).points)))


def sides(pattern, name: str = "front") -> list[float]:
    """Return the lengths of a panel's edges [m]."""
    panel = pattern.panel(name)
    return [edge_length(panel, i) for i in range(len(panel.edges))]


def apex_angle(pattern) -> float:
    """Return the angle of the only dart [rad]."""
    (seam,) = [seam for seam in pattern.seams if is_dart(pattern, seam)]
    panel = pattern.panel(seam.a.panel)
    count = len(panel.points)
    first = seam.a.edge if (seam.a.edge + 1) % count == seam.b.edge else seam.b.edge
    a, apex, c = (panel.points[(first + k) % count] for k in range(3))
    one, other = a - apex, c - apex
    return float(np.arccos(one @ other / (np.linalg.norm(one) * np.linalg.norm(other))))


@pytest.mark.parametrize("distance", [0.03, -0.05])
def test_a_straight_edge_moves_parallel_along_its_neighbours(blank, distance):
    """Broken where the area changes by other than distance times side, or another edge of the square turns."""
    call = f"l.moveParallel(pattern, [{{panel: 'front', edge: 0}}], {distance}, {{symmetric: false, sewn: true}})"
    done = change(blank, make_square(), f"const done = {call}")
    assert area(done) == pytest.approx(0.4 * (0.4 + distance), abs=KEPT)
    assert sides(done) == pytest.approx([0.4, 0.4 + distance, 0.4, 0.4 + distance], abs=KEPT)


@pytest.mark.parametrize("angle", [0.05, 0.2, 0.6])
def test_slash_and_spread_adds_the_triangle_that_opens(blank, angle):
    """Broken where the area grows by other than r^2 sin(angle) / 2, or an edge changes its length."""
    before = make_square()
    script = f"""const [open, hinge] = [0, 2].map((point) => ({{panel: 'front', point}}));
        const done = s.spread(pattern, open, hinge, {{angle: {angle}}}, {{symmetric: false}})"""
    done = change(blank, before, script)
    reach = hypot(0.4, 0.4)
    assert area(done) - area(before) == pytest.approx(reach**2 * sin(angle) / 2, abs=KEPT)
    assert sorted(sides(done)) == pytest.approx(sorted([*sides(before), 2 * reach * sin(angle / 2)]), abs=KEPT)
    by_distance = change(blank, before, script.replace(f"angle: {angle}", f"distance: {2 * reach * sin(angle / 2)}"))
    np.testing.assert_allclose(by_distance.panel("front").points, done.panel("front").points, atol=KEPT)


def test_a_dart_takes_its_triangle_and_is_closed_again(blank):
    """Broken where legs, angle or area are others than a dart's width and length demand, or removing it leaves any."""
    before, width, length = make_square(), 0.03, 0.12
    add = f"d.addDart(pattern, {{panel: 'front', edge: 2, fraction: 0.5}}, {{width: {width}, length: {length}}}, keep)"
    done = change(blank, before, f"const done = {add}")
    assert area(before) - area(done) == pytest.approx(width * length / 2, abs=KEPT)
    assert apex_angle(done) == pytest.approx(2 * asin(width / 2 / hypot(width / 2, length)), abs=KEPT)
    assert sorted(sides(done))[:2] == pytest.approx([hypot(width / 2, length)] * 2, abs=KEPT)
    assert seam_mismatch(done) < KEPT
    closed = change(blank, before, f"const one = {add}; const done = d.removeDart(one, d.listDarts(one)[0], keep)")
    assert area(closed) == pytest.approx(area(before), abs=KEPT) and not closed.seams


@pytest.mark.parametrize("corner", [[0.4, 0.0], [0.4, 0.4], [0.0, 0.0], [0.0, 0.4]])
def test_a_pivoted_dart_keeps_angle_area_and_lengths(blank, corner):
    """Broken where turning a dart changes its angle, the panel's area, or the length of another edge."""
    script = f"""const alone = {{symmetric: false, sewn: true}};
        const size = {{width: 0.03, length: 0.18}};
        const one = d.addDart(pattern, {{panel: 'front', edge: 2, fraction: 0.4}}, size, alone);
        const point = one.panels[0].points.findIndex(([x, y]) => Math.hypot(x - {corner[0]}, y - {corner[1]}) < 1e-9);
        const moved = d.pivotDart(one, d.listDarts(one)[0], {{panel: 'front', point}}, alone); const done = """
    one, done = (change(blank, make_square(), script + which) for which in ("one", "moved"))
    assert area(done) == pytest.approx(area(one), abs=KEPT)
    assert apex_angle(done) == pytest.approx(apex_angle(one), abs=KEPT)
    assert seam_mismatch(done) < KEPT
    old_leg, new_leg = hypot(0.015, 0.18), hypot(corner[0] - 0.24, corner[1] - 0.22)
    own = [side for side in sides(one) if abs(side - old_leg) > KEPT]
    assert sorted(sides(done)) == pytest.approx(sorted([*own, new_leg, new_leg]), abs=KEPT)


def test_a_shirt_stays_sewn_and_symmetric(blank):
    """Broken where an operation on a T-shirt leaves sides of a seam that differ, or left and right that differ."""
    shirt = load_template("tshirt")
    names = name_edges(shirt)["front"]
    hem = names.lines.index("hem")
    side = names.lines.index("side seam")
    neck = names.points.index("CF of the neckline")
    scripts = {
        "parallel": f"l.moveParallel(pattern, [{{panel: 'front', edge: {hem}}}], 0.03, keep)",
        "dart": f"""d.addDart(pattern, {{panel: 'front', edge: {side}, fraction: 0.8}},
            {{width: 0.02, length: 0.1}}, keep)""",
        "hem": f"t.moveBy(pattern, [{{panel: 'front', edge: {hem}}}], 0.03, 'down', keep)",
        "spread": f"""(() => {{
            const place = m.getPanel(pattern, 'front').points[{neck}];
            const added = p.addPoint(pattern, {{panel: 'front', edge: {hem}, fraction: 0.5}}, keep);
            const point = m.getPanel(added.pattern, 'front').points.findIndex((at) => at.join() === place.join());
            return s.spread(added.pattern, added.point, {{panel: 'front', point}}, {{distance: 0.04}}, keep); }})()""",
    }
    for name, script in scripts.items():
        done = change(blank, shirt, f"const done = {script}")
        assert seam_mismatch(done) < KEPT, name
        assert len(find_symmetry(done).mirrors) == len(find_symmetry(shirt).mirrors), name
    darted = change(blank, shirt, f"const done = {scripts['dart']}")
    assert sum(is_dart(darted, seam) for seam in darted.seams) == 2
    lowered = change(blank, shirt, f"const done = {scripts['hem']}").panel("front")
    ends = [hem, (hem + 1) % len(names.lines)]
    np.testing.assert_allclose(lowered.points[ends, 1], shirt.panel("front").points[ends, 1] - 0.03, atol=KEPT)
    wide = change(blank, shirt, f"const done = {scripts['spread']}").panel("front")
    found = sum(edge_length(wide, i) for i, edge in enumerate(wide.edges) if edge.contour == "hem")
    assert found == pytest.approx(edge_length(shirt.panel("front"), hem) + 0.04, abs=KEPT)


def test_lengths_are_read_with_sign_and_unit(blank):
    """Broken where a unit has another size, or a text that is no length is taken."""
    texts = ["30", "-30 mm", "2,5cm", "1 inch", "5°", "5 deg"]
    found = run(blank, "return argument.map((text) => t.readOpening(text))", texts[:4])
    assert [one["distance"] for one in found] == pytest.approx([0.03, -0.03, 0.025, 0.0254])
    assert run(blank, "return argument.map((text) => t.readOpening(text).angle)", texts[4:]) == pytest.approx(
        [pi / 36] * 2
    )
    refused = "return argument.filter((text) => { try { t.readLength(text); return true; } catch { return false; } })"
    assert run(blank, refused, ["", "abc", "3 km", "--3", "1e3"]) == []


def test_names_are_those_of_core_and_stay_with_their_edges(blank):
    """Broken where a line of a T-shirt is named as core does not, a new point takes a name, or a hem's halves part."""
    shirt = load_template("tshirt")
    names = {name: {"lines": n.lines, "sides": n.sides, "points": n.points} for name, n in name_edges(shirt).items()}
    script = """const pattern = n.withNames(m.readPattern(argument.text), argument.names), edge = argument.hem;
        const {pattern: cut, point} = p.addPoint(pattern, {panel: 'front', edge, fraction: 0.5}, keep);
        return {lines: n.listLines(pattern).map(({words}) => words), cut: n.listLines(cut).map(({words}) => words),
                added: n.pointWords(cut, point), hem: b.measureChain(cut, {panel: 'front', edge}),
                neck: b.measureChain(pattern, {panel: 'front', edge: argument.neck}),
                hole: b.measureChain(pattern, {panel: 'front', edge: argument.hole})}"""
    found = names["front"]["lines"]
    numbers = {"hem": found.index("hem"), "neck": found.index("neckline"), "hole": found.index("armhole")}
    got = run(blank, script, {"text": json.dumps(write_pattern(shirt)), "names": names, **numbers})
    assert {
        "front hem",
        "front neckline",
        "front left side seam",
        "back left armhole",
        "sleeve front left sleeve cap",
    } <= set(got["lines"])
    assert got["cut"] == got["lines"] and "underarm" not in got["added"] and "hem" in got["added"]
    lengths = {
        word: sum(
            edge_length(panel, i)
            for panel in shirt.panels
            for i, edge in enumerate(panel.edges)
            if edge.contour == word
        )
        for word in ("hem", "neck")
    }
    assert got["hem"]["length"] == pytest.approx(lengths["hem"], abs=KEPT) and got["hem"]["other"] is None
    assert got["neck"]["length"] == pytest.approx(lengths["neck"], abs=KEPT)
    assert sorted(got["hole"]["panels"]) == ["back", "front"] and got["hole"]["other"] == pytest.approx(
        got["hole"]["length"], abs=KEPT
    )


@pytest.mark.parametrize("aspect", [0.6, 1.0, 1.8])
def test_panels_on_the_board_never_overlap(blank, aspect):
    """Broken where two pieces of a template lie on each other on a board of any shape."""
    for name in ("tshirt", "trousers"):
        script = f"""const pattern = m.readPattern(argument), places = y.layOut(pattern, {aspect});
            return y.overlaps(pattern, (name) => places[name])"""
        assert not run(blank, script, json.dumps(write_pattern(load_template(name))))
