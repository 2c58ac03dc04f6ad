"""`garmentq bench`: lines, tables, exit statuses."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner
from garmentq.cli.bench import process, target
from garmentq.cli.bench import run as bench
from garmentq.cli.bench.table import mean, print_tables
from garmentq.core.cloth.fabric import FabricEstimate
from garmentq.core.deliver.export.meshes import write_ply
from garmentq.core.garment.curves import edge_points
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.run.errors import BadInput

KEYS = {
    "target", "category", "template", "cut", "method", "ok", "error", "metrics", "cpu_seconds", "stage_seconds",
    "peak_mb", "compile_seconds", "vertices", "fabric", "panels",
}  # fmt: skip


@pytest.fixture()
def packs(tmp_path: Path, tube_recovery) -> Path:
    """Write three packs: one that works, one whose recovery is refused, and a dressed person's scan."""
    recovery = tube_recovery()
    for name in ("good", "refused", "fused_scan"):
        folder = tmp_path / "packs" / name
        folder.mkdir(parents=True)
        (folder / "meta.json").write_text(json.dumps({"name": name, "category": "dress"}))
        write_ply(recovery.scan.vertices, recovery.scan.faces, folder / "garment.ply")
        write_ply(recovery.body.vertices, recovery.body.faces, folder / "body.ply")
        save_pattern(recovery.pattern, folder / "template.json")
        lines = {p.name: [edge_points(p, i, 4).tolist() for i in range(4)] for p in recovery.pattern.panels}
        panels = {
            name: {"outline": [q for e in edges for q in e[:-1]], "edges": edges} for name, edges in lines.items()
        }
        (folder / "pattern.json").write_text(json.dumps({"unit": "m", "panels": panels}))
    fused = tmp_path / "packs" / "fused_scan"
    (fused / "scan.ply").write_text("ply")
    (fused / "labels.npz").write_text("npz")
    (fused / "body.ply").rename(fused / "truth_body.ply")
    return tmp_path / "packs"


@pytest.fixture()
def requests(monkeypatch: pytest.MonkeyPatch, tube_recovery) -> list:
    """Run targets in this process, with a recovery that is known; give the requests it saw."""
    seen = []

    def recover(request):
        seen.append(request)
        if "refused" in str(request.scan):
            raise BadInput("the scan is a teapot.")
        return tube_recovery(estimates=(FabricEstimate("k", 2e-5, 0.3, 1.9, True, "found"),))

    monkeypatch.setitem(sys.modules, "garmentq.core.recover.pipeline", SimpleNamespace(recover=recover))
    monkeypatch.setattr(bench, "run_target", lambda pack, order, timeout: target.recover_target(order))
    return seen


def run(*arguments: object):
    """Run the command."""
    return CliRunner().invoke(bench.command, [str(argument) for argument in arguments])


def test_one_line_a_target_and_status_5(packs: Path, requests: list) -> None:
    """Fails if a key were missing, a failing target stopped the others, or failure went unnoticed."""
    result = run(packs, "--json")
    assert result.exit_code == 5, result.output
    lines = {line["target"]: line for line in map(json.loads, result.stdout.splitlines())}
    assert list(lines) == ["fused_scan", "good", "refused"]
    assert all(set(line) >= KEYS for line in lines.values())
    fused = lines["fused_scan"]
    assert fused["ok"] and fused["metrics"]["truth_body_rms_mm"] == pytest.approx(0.0, abs=0.01)
    assert fused["metrics"]["truth_body_penetration_mm"] == fused["metrics"]["body_penetration_mm"]
    assert requests[0].scan.name == "scan.ply" and requests[0].labels.name == "labels.npz"
    assert requests[0].body is None and requests[0].settings.keep == "1"
    good, refused = lines["good"], lines["refused"]
    assert (good["ok"], good["error"], good["category"], good["method"]) == (True, None, "skirt", "hybrid")
    assert good["metrics"]["surface_rms_mm.s2t"] > 0.0
    assert good["metrics"]["panel_outline_mm"] == pytest.approx(0.0, abs=1e-6)
    assert good["stage_seconds"] == {"scan": 0.2, "deform": 3.4}
    assert good["vertices"] > 100
    assert (refused["ok"], refused["error"]) == (False, {"code": "input.bad", "message": "the scan is a teapot."})


def test_the_recovery_sees_only_garment_body_and_template(packs: Path, requests: list) -> None:
    """Fails if the category or the true pattern were handed over, or --library still gave the template."""
    assert run(packs, "--only", "good").exit_code == 0
    (request,) = requests
    assert (request.scan.name, request.body.name, request.template.name) == ("garment.ply", "body.ply", "template.json")
    assert request.settings.garment is None and request.settings.template is None
    result = run(packs, "--only", "good", "--library", "--preset", "thesis", "--json")
    assert requests[1].template is None
    assert requests[1].settings.preset == "thesis"
    line = json.loads(result.stdout)
    # The tube's two panels are the truth's in number and shape, so they are compared even so.
    assert line["metrics"]["panel_area_error"] == pytest.approx(0.0, abs=1e-6)
    assert line["metrics"]["seam_mismatch_mm"] == pytest.approx(0.0, abs=1e-6)


def test_another_cut_has_no_panel_figures(packs: Path, requests: list) -> None:
    """Fails if a shipped template cut otherwise than the truth were given an error of area that means nothing."""
    path = packs / "good" / "pattern.json"
    data = json.loads(path.read_text())
    del data["panels"]["back"]
    path.write_text(json.dumps(data))
    line = json.loads(run(packs, "--only", "good", "--library", "--json").stdout)
    assert line["metrics"]["panel_outline_mm"] is None and line["metrics"]["panel_area_error"] is None
    assert line["panels"] == {} and line["unmatched_panels"] == ["back"]


def test_fabric_and_panels_of_a_line(packs: Path, requests: list) -> None:
    """Fails if a reader of the lines did not find fabric and panels under the documented keys."""
    path = packs / "good" / "meta.json"
    path.write_text(json.dumps({"name": "good", "category": "dress", "fabric": {"k": 1e-5, "newton_tri_ke": 3000}}))
    line = json.loads(run(packs, "--only", "good", "--json").stdout)
    assert line["fabric"] == {"k": {"value": 2e-5, "std": 0.3, "identifiable": True}}
    assert set(line["panels"]) == {"front", "back"}
    for panel in line["panels"].values():
        assert set(panel) == {"area_error", "outline_mm", "turning"}
        assert max(panel.values()) < 1e-6
    assert [name for name in line["metrics"] if name.startswith("material_log_error")] == ["material_log_error.k"]


def test_results_are_kept(packs: Path, requests: list, tmp_path: Path) -> None:
    """Fails if a file that a reader of the bench needs were missing."""
    assert run(packs, "--only", "good", "--out", tmp_path / "out").exit_code == 0
    names = {path.name for path in (tmp_path / "out" / "good").iterdir()}
    assert names >= {"graded.ply", "detail.ply", "body.ply", "body_joints.json", "pattern.json", "report.html"}


def test_the_table_has_every_metric_and_the_thesis(packs: Path, requests: list) -> None:
    """Fails if a metric, the stages, the memory or the published numbers were left out of the table."""
    text = run(packs).stdout
    for word in (
        "contour_rms_mm.hem",
        "graded.surface_rms_mm.t2s",
        "seconds.deform",
        "peak_mb",
        "PhyDeformer",
        "0.096",
    ):
        assert word in text, word
    assert "input.bad" in text


def test_unknown_packs_are_refused(packs: Path) -> None:
    """Fails if a wrong name ran nothing and said nothing."""
    result = run(packs, "--only", "nothing")
    assert getattr(result.exception, "code", None) == "bench.unknown_pack"


def test_means_are_unweighted_and_pass_over_gaps(capsys: pytest.CaptureFixture[str]) -> None:
    """Fails if a missing number counted as zero, or a failed target took part in the mean."""
    assert mean([1.0, None, 3.0, float("nan")]) == 2.0
    assert mean([None]) is None
    print_tables([target.empty_line("a", "deform") | {"error": {"code": "x.y", "message": "no"}}], {})
    assert "0 of 1" in capsys.readouterr().out


def test_a_crash_is_a_line(packs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fails if a process that died took the bench with it."""
    monkeypatch.setattr(process.sys, "executable", "/bin/false")
    result = run(packs, "--only", "good", "--json")
    line = json.loads(result.stdout)
    assert result.exit_code == 5
    assert line["error"] == {"code": "bench.crashed", "message": "the process ended with status 1"}


@pytest.mark.slow
def test_a_bad_target_in_a_real_process(packs: Path) -> None:
    """Fails if the process could not be started, or a broken garment were a crash instead of a refusal."""
    (packs / "good" / "garment.ply").write_text("ply\nformat ascii 1.0\nelement vertex 4000000000\n")
    result = run(packs, "--only", "good", "--json")
    line = json.loads(result.stdout)
    assert result.exit_code == 5
    assert line["ok"] is False
    assert line["error"]["code"].startswith("scan."), line["error"]
    assert line["cpu_seconds"] > 0.0 and line["peak_mb"] > 20.0
