"""The result folder and its report."""

from __future__ import annotations

import base64
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.body import JOINTS
from garmentq.core.export import plain, report_html, write_recovery
from garmentq.core.pattern import load_pattern
from garmentq.core.recovery import Gate
from garmentq.core.scan import Scan
from PIL import Image

HOSTILE = "\"><script>alert(1)</script><img src=x onerror='a()'>"
FILES = [
    "graded.ply", "detail.ply", "detail.obj", "detail.glb", "body.ply", "body_joints.json", "pattern.json",
    "pattern.svg", "metrics.json", "manifest.json", "report.html",
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
    """Give the report of a tube."""
    return report_html(tube_recovery())


def test_every_file_is_written_and_listed(tube_recovery, tmp_path: Path) -> None:
    """Fails if a file were missing, or listed and not written."""
    recovery = tube_recovery()
    written = write_recovery(recovery, tmp_path / "new" / "folder")
    assert [path.name for path in written] == FILES
    assert all(path.stat().st_size > 0 for path in written)
    folder = written[0].parent
    assert np.array_equal(trimesh.load(folder / "graded.ply", process=False).vertices, recovery.graded)
    assert np.array_equal(trimesh.load(folder / "body.ply", process=False).faces, recovery.body.faces)
    joints = json.loads((folder / "body_joints.json").read_text())["joints"]
    assert tuple(joints) == JOINTS
    assert joints["left_hip"]["parent"] == "pelvis"
    assert load_pattern(folder / "pattern.json").panel("front").points.max() == pytest.approx(np.pi * 0.15, abs=1e-6)
    assert json.loads((folder / "metrics.json").read_text())["surface_rms_mm.s2t"] > 0.0


def test_a_simulation_mesh_is_written_where_there_is_one(tube_recovery, tmp_path: Path) -> None:
    """Fails if the simulation mesh were forgotten, or the detail mesh written in its place."""
    recovery = tube_recovery()
    fitted = tube_recovery(simulation=recovery.graded + 0.5, redraped=recovery.graded - 0.5)
    names = [path.name for path in write_recovery(fitted, tmp_path)]
    assert names == [*FILES[:4], "simulation.ply", "redrape.ply", *FILES[4:]]
    meshes = [trimesh.load(tmp_path / f"{name}.ply", process=False) for name in ("simulation", "redrape", "detail")]
    assert all(np.array_equal(mesh.faces, meshes[2].faces) for mesh in meshes)
    assert np.array_equal(meshes[1].vertices, recovery.graded - 0.5)
    assert np.array_equal(trimesh.load(tmp_path / "simulation.ply", process=False).vertices, recovery.graded + 0.5)


def test_json_has_no_nan_and_no_numpy() -> None:
    """Fails if a reader that follows the standard could not read a file of ours."""
    value = plain({"a": np.float64("nan"), "b": [np.int64(3), np.inf], "c": np.eye(2), "d": Path("x"), "e": True})
    assert json.loads(json.dumps(value, allow_nan=False)) == {
        "a": None, "b": [3, None], "c": [[1.0, 0.0], [0.0, 1.0]], "d": "x", "e": True,
    }  # fmt: skip


def test_the_report_needs_no_network(html: str) -> None:
    """Fails if a picture, style or script came from elsewhere, or there were any script at all."""
    tags = parse(html)
    assert not {tag for tag, _ in tags.seen} & {"script", "link", "iframe", "object"}
    sources = [attributes["src"] or "" for tag, attributes in tags.seen if tag == "img"]
    assert len(sources) == 6
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert "@import" not in html and "url(" not in html


def test_the_pictures_show_a_garment(html: str) -> None:
    """Fails if a picture were empty, or scan, result and error map were the same one."""
    pictures = [
        np.asarray(Image.open(io.BytesIO(base64.b64decode(data)))) for data in re.findall(r"base64,([^\"]+)", html)
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
        gates=(Gate(HOSTILE, "warn", 1.0, 2.0, HOSTILE),),
        metrics={"surface_rms_mm.s2t": 1.0, HOSTILE: 2.0},
        stage_seconds={HOSTILE: 1.0},
        manifest={HOSTILE: HOSTILE},
    )
    tags = parse(report_html(recovery))
    assert "script" not in {tag for tag, _ in tags.seen}
    assert sum(tag == "img" for tag, _ in tags.seen) == 6
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


def test_verdict_and_remarks_are_shown(html: str) -> None:
    """Fails if the page kept a warning or a gate to itself."""
    assert "The scan&#x27;s hem was frayed." in html
    assert html.count('class="badge') == 6
    assert re.search(r'class="verdict (pass|warn|fail)"', html)
