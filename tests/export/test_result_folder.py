"""The result folder and its report."""

from __future__ import annotations

import base64
import io
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.body.body import JOINTS
from garmentq.core.cloth.fabric import FabricEstimate
from garmentq.core.deliver.export.pattern_svg import pattern_svg
from garmentq.core.deliver.export.report import report_html
from garmentq.core.deliver.export.result import to_plain_json, write_recovery
from garmentq.core.deliver.export.views import render_views
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.judge.gates import evaluate_gates
from garmentq.core.recover.recovery import Recovery
from garmentq.core.reuse.wear.worn import load_worn, worn_from_recovery
from garmentq.core.run.verdict import Gate, Verdict
from garmentq.core.scan.scan import Scan
from PIL import Image
from scipy.spatial import cKDTree

HOSTILE = "\"><script>alert(1)</script><img src=x onerror='a()'>"
FILES = [
    "graded.ply", "detail.ply", "detail.obj", "detail.glb", "scan.ply", "body.ply", "body_joints.json", "pattern.json",
    "pattern.svg", "metrics.json", "manifest.json", "worn.npz", "report.html",
]  # fmt: skip


class Tags(HTMLParser):
    """Collect tags and attributes, and check that tags close in order."""

    VOID = ("meta", "img", "br")

    def __init__(self) -> None:
        super().__init__()
        self.seen: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note a tag."""
        self.seen.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note a tag that closes itself."""
        self.seen.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        """Close the last tag, which must be this one."""
        assert self.open.pop() == tag


def parse(html: str) -> Tags:
    """Parse a report; every tag must be closed."""
    tags = Tags()
    tags.feed(html)
    tags.close()
    assert tags.open == []
    return tags


@pytest.fixture(scope="module")
def html(tube_recovery) -> str:
    """Return the report of a tube."""
    return report_html(tube_recovery())


def test_every_file_is_written_and_listed(tube_recovery, tmp_path: Path) -> None:
    """Fails if a file were missing, or listed and not written."""
    recovery = tube_recovery()
    written = write_recovery(recovery, tmp_path / "new" / "folder")
    assert [path.name for path in written] == FILES
    assert all(path.stat().st_size > 0 for path in written)


def test_every_file_holds_what_was_recovered(tube_recovery, tmp_path: Path) -> None:
    """Fails if a mesh, the pattern or a number were another one's, or moved, or lost a part on its way to a file."""
    recovery = tube_recovery()
    write_recovery(recovery, tmp_path)
    scan, body, faces = recovery.scan, recovery.body, recovery.garment.faces
    meshes = {
        "graded": (recovery.meshes.graded, faces), "detail": (recovery.meshes.detail, faces),
        "scan": (scan.vertices, scan.faces), "body": (body.vertices, body.faces),
    }  # fmt: skip
    for name, (vertices, triangles) in meshes.items():
        mesh = trimesh.load(tmp_path / f"{name}.ply", process=False)
        assert np.array_equal(mesh.vertices, vertices) and np.array_equal(mesh.faces, triangles), name
    off = trimesh.load(tmp_path / "detail.ply", process=False).metadata["_ply_raw"]["vertex"]["data"]["distance"]
    assert np.ravel(off) == pytest.approx(TriangleSurface(scan.vertices, scan.faces).distance(recovery.meshes.detail))
    for name in ("detail.obj", "detail.glb"):  # with texture coordinates: vertices on seams are there twice
        mesh = trimesh.load(tmp_path / name, process=False, force="mesh")
        way, nearest = cKDTree(recovery.meshes.detail).query(mesh.vertices)
        assert way.max() < 1e-6 and set(nearest) == set(range(len(recovery.meshes.detail)))
        assert mesh.area == pytest.approx(trimesh.Trimesh(recovery.meshes.detail, faces, process=False).area)
    joints = json.loads((tmp_path / "body_joints.json").read_text())["joints"]
    assert tuple(joints) == JOINTS
    assert joints["left_hip"]["parent"] == "pelvis"
    assert np.array_equal([joint["position"] for joint in joints.values()], body.joints)
    again = load_pattern(tmp_path / "pattern.json")
    assert [panel.name for panel in again.panels] == [panel.name for panel in recovery.pattern.panels]
    assert again.seams == recovery.pattern.seams
    np.testing.assert_allclose(again.points, recovery.pattern.points, atol=1e-9)
    for name, value in (("metrics", recovery.report.metrics), ("manifest", recovery.report.manifest)):
        assert json.loads((tmp_path / f"{name}.json").read_text()) == to_plain_json(value)
    kept = load_worn(tmp_path)
    np.testing.assert_array_equal(kept.garment.nodes, worn_from_recovery(recovery).garment.nodes)
    np.testing.assert_array_equal(kept.body.vertices, body.vertices)
    assert kept.fabric == recovery.fabric
    assert (tmp_path / "report.html").read_text() == report_html(recovery)
    assert (tmp_path / "pattern.svg").read_text() == pattern_svg(recovery.pattern)


def test_what_the_scan_does_not_show_is_marked(tube_recovery, tmp_path: Path) -> None:
    """Broken where inferred cloth is not marked in the meshes, or not coloured or counted in the report."""
    whole = tube_recovery()
    (first, *_), seen = whole.pattern.panels, np.ones(len(whole.garment.faces), dtype=bool)
    seen[np.isin(whole.garment.faces, whole.garment.faces[0]).any(axis=1)] = False
    report = replace(whole.report, manifest=whole.report.manifest | {"inferred": {first.name: 0.37}})
    recovery = replace(whole, seen=seen, report=report)
    assert recovery.inferred_nodes.sum() == 3
    write_recovery(recovery, tmp_path)
    marked = trimesh.load(tmp_path / "detail.ply", process=False).metadata["_ply_raw"]["vertex"]["data"]["inferred"]
    assert np.array_equal(np.ravel(marked) == 1.0, recovery.inferred_nodes)
    shown, without = (
        [view.pictures["Distance, detail to scan"] for view in render_views(one)[0]] for one in (recovery, whole)
    )
    assert shown != without
    assert re.search("<td [^>]*class=num>37</td>", report_html(recovery))


def test_the_report_says_how_sure_each_line_is(tube_recovery) -> None:
    """Broken where a seam that no scan shows is printed with a length alone, or the margin is another line's."""
    whole = tube_recovery()
    entry = {"name": "armhole seam", "side": "left", "visible": False, "length_mm": 452.0, "length_margin_mm": 11.0}
    lines = [entry | {"place_margin_mm": 20.0}, entry | {"name": "<b>hem", "place_margin_mm": None}]
    report = replace(whole.report, manifest=whole.report.manifest | {"lines": lines})
    html = report_html(replace(whole, report=report))
    cells = re.sub(' data-head="[^"]*"', "", html)
    assert "<td>armhole seam left</td><td class=num>45.2 cm +-1.1</td><td>place not visible, +-20 mm</td>" in cells
    assert "&lt;b&gt;hem left" in html and "not scanned: the base pattern" in html
    assert "Seam or edge" not in report_html(replace(whole, report=replace(whole.report, manifest={})))


def test_a_simulation_mesh_is_written_where_there_is_one(tube_recovery, tmp_path: Path) -> None:
    """Fails if the simulation mesh were forgotten, or the detail mesh written in its place."""
    recovery = tube_recovery()
    graded = recovery.meshes.graded
    fitted = tube_recovery(meshes=replace(recovery.meshes, simulation=graded + 0.5, redraped=graded - 0.5))
    names = [path.name for path in write_recovery(fitted, tmp_path)]
    assert names == [*FILES[:4], "simulation.ply", "redrape.ply", *FILES[4:]]
    meshes = [trimesh.load(tmp_path / f"{name}.ply", process=False) for name in ("simulation", "redrape", "detail")]
    assert all(np.array_equal(mesh.faces, meshes[2].faces) for mesh in meshes)
    assert np.array_equal(meshes[1].vertices, graded - 0.5)
    assert np.array_equal(trimesh.load(tmp_path / "simulation.ply", process=False).vertices, graded + 0.5)


def test_json_has_no_nan_and_no_numpy() -> None:
    """Fails if a reader that follows the standard could not read a file of ours."""
    value = to_plain_json(
        {"a": np.float64("nan"), "b": [np.int64(3), np.inf], "c": np.eye(2), "d": Path("x"), "e": True}
    )
    assert json.loads(json.dumps(value, allow_nan=False)) == {
        "a": None, "b": [3, None], "c": [[1.0, 0.0], [0.0, 1.0]], "d": "x", "e": True,
    }  # fmt: skip


def test_the_report_needs_no_network(html: str) -> None:
    """Fails if a picture, style or script came from elsewhere, or there were any script at all."""
    tags = parse(html)
    assert not {tag for tag, _ in tags.seen} & {"script", "link", "iframe", "object"}
    sources = [attributes["src"] or "" for tag, attributes in tags.seen if tag == "img"]
    assert len(sources) == 7
    assert all(source.startswith(("data:image/png;base64,", "data:image/svg+xml;base64,")) for source in sources)
    assert "@import" not in html and "url(" not in html


def test_the_pictures_show_a_garment(html: str) -> None:
    """Fails if a picture were empty, or scan, result and error map were the same one."""
    pictures = [
        np.asarray(Image.open(io.BytesIO(base64.b64decode(data)))) for data in re.findall(r"png;base64,([^\"]+)", html)
    ]
    for picture in pictures:
        assert 0.2 < np.mean(picture[..., 3] > 0) < 1.0
    front = [picture[..., :3][picture[..., 3] == 255].astype(float).mean(axis=0) for picture in pictures[:3]]
    assert front[1][2] > front[1][0] + 15  # the result is blue
    assert all(np.abs(a - b).max() > 5 for a, b in ((front[0], front[1]), (front[1], front[2]), (front[0], front[2])))


def test_a_hostile_name_is_only_text(tube_recovery) -> None:
    """Fails if any name from a file reached the page unescaped."""
    recovery = tube_recovery(panel_names=(HOSTILE, "back"))
    recovery = tube_recovery(
        panel_names=(HOSTILE, "back"),
        scan=Scan(recovery.scan.vertices, recovery.scan.faces, name=HOSTILE),
        template=HOSTILE,
        warnings=(HOSTILE,),
        gates=(Gate(HOSTILE, Verdict.DOUBTFUL, 1.0, 2.0, HOSTILE),),
        metrics={"surface_rms_mm.s2t": 1.0, HOSTILE: 2.0},
        stage_seconds={HOSTILE: 1.0},
        manifest={HOSTILE: HOSTILE},
    )
    tags = parse(report_html(recovery))
    assert "script" not in {tag for tag, _ in tags.seen}
    assert sum(tag == "img" for tag, _ in tags.seen) == 7
    assert not any(name.startswith("on") for _, attributes in tags.seen for name in attributes)


def test_the_pattern_is_drawn_one_to_ten(html: str) -> None:
    """Fails if the drawing lost its scale: a viewBox of 10 mm is 1 mm wide, and a panel is as long as it is."""
    width, box = re.search(
        r'class="pattern" width="([\d.]+)mm" height="[\d.]+mm" viewBox="0 0 (\d+) \d+"', html
    ).groups()
    assert float(box) / float(width) == pytest.approx(10.0)
    outline = re.search(r'class="cloth" d="M ([^Z]+) Z"', html).group(1)
    points = np.array([[float(x) for x in point.split()] for point in outline.split(" L ")])
    assert np.ptp(points, axis=0) == pytest.approx([1e3 * np.pi * 0.15, 300.0], abs=0.2)


@pytest.fixture(scope="module")
def fitted(tube_recovery) -> Recovery:
    """Return a recovery as the fit through the simulator leaves it: bending found, an unsettled drape."""
    recovery = tube_recovery()
    estimates = (
        FabricEstimate("k", 2.345e-5, 0.3, 1.9, True, "fitted"),
        FabricEstimate("H00", 777.0, 0.6, 0.7, False, "the drape leaves it open"),
        FabricEstimate("density", 0.1234, 0.5, 0.5, False, "only ratios to it <b>"),
    )
    metrics = recovery.report.metrics | {
        "sim.surface_rms_mm.s2t": 5.0, "sim.surface_rms_mm.t2s": 6.0, "redrape.residual": 1e4, "fabric.k": 2.345e-5,
        "surface_rms_mm.s2t": 0.4, "surface_rms_mm.t2s": 0.5,
    }  # fmt: skip
    graded = recovery.meshes.graded
    return tube_recovery(
        meshes=replace(recovery.meshes, simulation=graded, redraped=graded), estimates=estimates, metrics=metrics,
        gates=evaluate_gates(metrics), nearest_fabrics=("silk_chiffon", "denim"), point_std=np.full((8, 2), 0.004),
    )  # fmt: skip


def test_fabric_is_told_without_false_digits(fitted: Recovery) -> None:
    """Fails if a value that no drape tells were printed as found, or a found one without its range."""
    section = re.search(r"<h2>Fabric</h2>.*?</section>", report_html(fitted), re.DOTALL).group()
    assert "2.3e-05 N m" in section and "1.7e-05 to 3.2e-05" in section
    assert section.count("not identifiable") == 2
    assert "777" not in section and "1.2e-01" not in section
    assert "silk_chiffon, denim" in section
    assert "only ratios to it &lt;b&gt;" in section


def test_the_headline_tells_the_products_apart(fitted: Recovery) -> None:
    """Fails if a drape in unrest painted the detail mesh red, or its own verdict were hidden."""
    html = report_html(fitted)
    verdicts = re.findall(r'<span class="verdict (\w+)">([^<]+)', html)
    assert [word.split(":")[0] for _, word in verdicts] == ["Detail mesh", "Pattern", "Drape"]
    assert [verdict for verdict, _ in verdicts] == ["pass", "pass", "fail"]


def test_the_simulation_mesh_is_shown(fitted: Recovery) -> None:
    """Fails if the report of a fit kept the simulation mesh or the new drape to itself."""
    html = report_html(fitted)
    assert sum(tag == "img" for tag, _ in parse(html).seen) == 11
    meshes = re.search(r'<table class="meshes">.*?</table>', html, re.DOTALL).group()
    assert "5 / 6" in meshes and "Graded drape" in meshes


def test_what_the_fit_knows_is_a_file(fitted: Recovery, tmp_path: Path) -> None:
    """Fails if fit.json lost a parameter, its verdict or a panel's control points, or were written without a fit."""
    write_recovery(fitted, tmp_path)
    found = json.loads((tmp_path / "fit.json").read_text())
    assert found["fabric"]["k"] == {
        "value": 2.345e-5, "std": 0.3, "prior_std": 1.9, "identifiable": True, "note": "fitted",
    }  # fmt: skip
    assert [found["fabric"][name]["identifiable"] for name in ("H00", "density")] == [False, False]
    assert found["nearest_fabrics"] == ["silk_chiffon", "denim"]
    assert np.shape(found["control_point_std_m"]["front"]) == (4, 2)
    assert found["std_is_of"] == "the natural logarithm"


def test_dimensions_are_drawn(html: str) -> None:
    """Fails if the drawing lacked a panel's size or an edge's length [cm]: the tube's panels are 47.1 by 30.0 cm."""
    assert html.count("47.1 × 30.0 cm") == 2
    lengths = re.findall(r'class="length"[^>]*>([\d.]+)<', html)
    assert sorted(lengths) == ["30.0"] * 4 + ["47.1"] * 4


def test_verdict_and_remarks_are_shown(html: str) -> None:
    """Fails if the page kept a warning or a gate to itself."""
    assert "The scan&#x27;s hem was frayed." in html
    assert html.count('class="badge') == 6
    assert re.search(r'class="verdict (pass|doubtful|fail)"', html)


def test_the_report_names_the_cuts_that_were_compared(tube_recovery) -> None:
    """Breaks where a reader cannot see what else the garment might be cut as, or a named cut shows an empty row."""
    recovery = tube_recovery()
    right = {"template": "tshirt+neckline=v", "misfit": 0.1, "girths": 0.08, "neckline": 0.06}
    compared = [right, {"template": "tshirt", "misfit": 0.2}]
    shown = report_html(replace(recovery, report=replace(recovery.report, manifest={"candidates": compared})))
    assert "tshirt+neckline=v 0.100 (girths 0.080, neckline 0.060); tshirt 0.200" in shown
    assert "Cuts by misfit" not in report_html(recovery)
