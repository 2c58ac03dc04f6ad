"""The editor's modules compute what `core/garment` computes: compared in the browser that runs them."""

from __future__ import annotations

import json

import numpy as np
import pytest
from garmentq.core.garment.curves import split_edge, unit_length, unit_points
from garmentq.core.garment.garmentcode import load_pattern, read_pattern
from garmentq.core.garment.pattern import Edge
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.symmetry import find_symmetry
from garmentq.core.garment.templates import LIBRARY

EDGES = 1000


def run(page, script: str, argument=None):
    """Run a function of the modules: `m` model, `g` geometry, `s` symmetry, the others operations."""
    names = {"m": "pattern_model", "g": "edge_geometry", "s": "symmetry", "v": "movement",
             "p": "point_operations", "q": "panel_operations", "c": "curve_operations"}  # fmt: skip
    loads = "; ".join(f"const {short} = await import('/static/edit/{name}.js')" for short, name in names.items())
    keep = "const keep = {symmetric: true, sewn: true}"
    return page.evaluate(f"async (argument) => {{ {loads}; {keep}; {script} }}", argument)


@pytest.fixture(scope="module")
def blank(chromium, site):
    """Open a page of the service that has no script of its own, once for all tests: they change nothing on it."""
    context = chromium.new_context(base_url=site.url)
    page = context.new_page()
    page.goto("/signin")
    yield page
    context.close()


def make_edges(rng: np.random.Generator) -> list[Edge]:
    """Make random edges of every kind, as bent as drawn ones and more."""
    counts = {"line": 0, "quadratic": 1, "cubic": 2, "arc": 1}
    edges = []
    for kind in rng.choice(list(counts), EDGES):
        handles = rng.normal([0.5, 0.0], 0.6, (counts[kind], 2))
        if kind == "arc":
            handles = np.array([[0.5, rng.normal(0.0, 0.6)]])
        edges.append(Edge(str(kind), handles))
    return edges


def test_geometry_is_that_of_core(blank):
    """Broken by any difference of length, points or parts of a thousand random edges beyond rounding (1e-9 chords)."""
    edges = make_edges(np.random.default_rng(7))
    fraction = 0.3
    found = run(
        blank,
        """return argument.map(([kind, handles]) => {
            const edge = {kind, handles}, {cut, first, second} = g.splitEdge(edge, 0.3);
            const [place] = g.placeOnChord([cut], [1, 2], [2, 4]), near = g.nearestOnEdge(edge, [1, 2], [2, 4], place);
            return {length: g.unitLength(edge), points: [0.25, 0.5, 0.75].map((t) => g.unitPoint(edge, t)), cut,
                    first: first.handles, second: second.handles, miss: near.distance};
        })""",
        [[edge.kind, edge.handles.tolist()] for edge in edges],
    )
    for edge, got in zip(edges, found, strict=True):
        cut, first, second = split_edge(edge, fraction)
        assert got["length"] == pytest.approx(unit_length(edge), abs=1e-9)
        np.testing.assert_allclose(got["points"], unit_points(edge, 4)[1:-1], atol=1e-9)
        np.testing.assert_allclose(got["cut"], cut, atol=1e-9)
        for part, handles in ((first, got["first"]), (second, got["second"])):
            np.testing.assert_allclose(np.reshape(handles, (-1, 2)), part.handles, atol=1e-6)
        assert got["miss"] < 1e-6


@pytest.mark.parametrize("units", [100, 1])
def test_reading_is_that_of_core(blank, units):
    """Broken by another reading of units, of loops out of order or clockwise, of absolute handles, circles, seams."""
    bow = {"type": "circle", "params": [0.8 * units, 0, 1]}
    bend = {"type": "quadratic", "params": [[0.4 * units, 1.2 * units]]}
    wave = {"type": "cubic", "params": [[0.2 * units, 0.1 * units], [0.7 * units, 0]]}
    square = {
        "vertices": [[0, 0], [0, units], [units, units], [units, 0]],
        "edges": [
            {"endpoints": [0, 1], "curvature": bow},
            {"endpoints": [2, 1], "curvature": bend},
            {"endpoints": [2, 3], "label": "side", "note": 1},
            {"endpoints": [0, 3], "curvature": wave},
        ],
        "translation": [0, 0, 0.1 * units],
        "rotation": [10, 20, 30],
    }
    other = {
        "vertices": [[0, 0], [units, 0], [0, units]],
        "edges": [{"endpoints": [k, (k + 1) % 3]} for k in range(3)],
    }
    stitches = [[{"panel": "square", "edge": 2}, {"panel": "other", "edge": 0}]]
    file = {
        "pattern": {"panels": {"square": square, "other": other}, "stitches": stitches},
        "properties": {"units_in_meter": units, "curvature_coords": "absolute"},
    }
    pattern = read_pattern(file)
    found = run(blank, "return m.readPattern(argument)", json.dumps(file))
    for panel, got in zip(pattern.panels, found["panels"], strict=True):
        np.testing.assert_allclose(got["points"], panel.points, atol=1e-12)
        np.testing.assert_allclose(got["rotation"], panel.rotation, atol=1e-12)
        assert got["mirrored"] == panel.mirrored
        for edge, drawn in zip(panel.edges, got["edges"], strict=True):
            assert (drawn["kind"], drawn["label"]) == (edge.kind, edge.label)
            np.testing.assert_allclose(np.reshape(drawn["handles"], (-1, 2)), edge.handles, atol=1e-12)
    assert [(s["a"]["edge"], s["b"]["edge"], s["gathered"]) for s in found["seams"]] == [
        (s.a.edge, s.b.edge, s.gathered) for s in pattern.seams
    ]


@pytest.mark.parametrize("name", sorted(path.stem for path in LIBRARY.glob("*.json")))
def test_templates_are_read_alike(blank, name):
    """Broken by mirrors other than core's, or by a file that reading and writing changes."""
    text = (LIBRARY / f"{name}.json").read_text(encoding="utf-8")
    found = run(
        blank,
        """const pattern = m.readPattern(argument);
        const all = Object.fromEntries(pattern.panels.map((panel) => [panel.name, panel]));
        return {same: m.writePattern(pattern) === argument, file: m.patternFile(pattern),
                fresh: m.patternFile(m.withPanels(pattern, all)),
                mirrors: s.findMirrors(pattern).map(({source, target, order}) => [source, target, order])};""",
        text,
    )
    assert found["same"] and found["file"] == json.loads(text)
    mirrors = find_symmetry(load_pattern(LIBRARY / f"{name}.json")).mirrors
    assert found["mirrors"] == [[mirror.source, mirror.target, mirror.order.tolist()] for mirror in mirrors]
    pattern, again = load_pattern(LIBRARY / f"{name}.json"), read_pattern(found["fresh"])
    for one, two in zip(pattern.panels, again.panels, strict=True):
        np.testing.assert_allclose(one.points, two.points, atol=1e-12)
        np.testing.assert_allclose(one.rotation, two.rotation, atol=1e-12)
        np.testing.assert_allclose(one.translation, two.translation, atol=1e-12)
        assert one.notches == two.notches
        assert [edge.contour for edge in one.edges] == [edge.contour for edge in two.edges]


def test_every_operation_gives_a_pattern_that_core_takes(blank):
    """Broken by a file that core refuses, by seams unequal by more than 1e-6 m, or by symmetry that is lost."""
    text = (LIBRARY / "tshirt.json").read_text(encoding="utf-8")
    found = run(
        blank,
        """const shirt = m.readPattern(argument), at = (panel, point) => ({panel, point});
        const added = p.addPoint(shirt, {panel: 'front', edge: 1, fraction: 0.3}, keep);
        const removed = p.removePoint(added.pattern, added.point, keep);
        const cut = q.cutBetween(shirt, at('front', 1), at('front', 7), keep);
        const smooth = c.toCurve(shirt, at('front', 2), keep);
        const isSleeve = ({panel}) => panel.startsWith('sleeve');
        const over = shirt.seams.findIndex(({a, b}) => isSleeve(a) && isSleeve(b));
        const results = {
            move: v.moveItems(shirt, [{item: at('front', 2), by: [0.004, 0.01]}], keep),
            bend: v.moveItems(shirt, [{item: {panel: 'front', edge: 1, handle: 0}, by: [0.005, 0]}], keep),
            straight: c.straighten(shirt, at('front', 1), at('front', 2), keep),
            smooth, corner: c.toCorner(smooth, at('front', 2), keep),
            added: added.pattern, removed, neck: p.removePoint(shirt, at('front', 4), keep),
            cut, joined: q.joinAlong(cut, cut.seams.length - 1, keep),
            middle: q.cutAlong(shirt, 'front', [[0, -1], [0, 0.3]], 1e-3, keep),
            sleeve: q.cutAlong(shirt, 'sleeve_front_left', [[0.3, -0.5], [0.3, 0.3]], 1e-3, keep),
            sleeves: q.joinAlong(shirt, over, keep),
        };
        const each = (values, what) =>
            Object.fromEntries(Object.entries(values).map(([key, value]) => [key, what(value)]));
        const lengths = (pattern) => pattern.panels.map(({name, edges}) =>
            edges.reduce((sum, _, edge) => sum + m.edgeLength(pattern, {panel: name, edge}), 0));
        const curve = (pattern) => m.getPanel(pattern, 'front').edges[1].handles;
        return {files: each(results, m.patternFile), around: each({shirt, ...results}, lengths),
                areas: [m.panelArea(m.getPanel(shirt, 'front')), m.panelArea(results.joined.panels[1])],
                back: JSON.stringify(removed.seams) === JSON.stringify(shirt.seams),
                curves: [curve(removed), curve(shirt)]};""",
        text,
    )
    patterns = {name: read_pattern(file, name) for name, file in found["files"].items()}
    for name, pattern in patterns.items():
        assert seam_mismatch(pattern) < 1e-6, name
        pairs = {(pattern.panels[m.source].name, pattern.panels[m.target].name) for m in find_symmetry(pattern).mirrors}
        assert ("back", "back") in pairs and len(pairs) >= len(pattern.panels) / 2, name
    for name in ("added", "removed", "neck"):
        assert found["around"][name] == pytest.approx(found["around"]["shirt"], abs=1e-6), name
    assert (
        found["back"] and np.abs(np.subtract(*found["curves"])).max() < 1e-12
    )  # the parts are the curve that they were cut from
    assert found["areas"][0] == pytest.approx(found["areas"][1], abs=1e-12)
    assert [len(patterns[name].panels) for name in ("cut", "joined", "middle", "sleeve", "sleeves")] == [7, 6, 7, 8, 4]
