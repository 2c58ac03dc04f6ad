"""Two commits are compared by paired means, and by how far the one before scatters."""

from __future__ import annotations

import numpy as np
import pytest
from bench_compare import compare_lines, format_changes, format_verdicts, list_figures, list_verdicts
from bench_runs import MOVED, move_pack
from garmentq.cli.bench.raw_file import read_raw_file
from trimesh import PointCloud, Trimesh
from trimesh.creation import icosphere


def garment_line(target: str, s2t: float, cpu: float = 50.0) -> dict:
    """Return a line of a pack of which one distance [mm] is known."""
    metrics = {"surface_rms_mm.s2t": s2t}
    told = {"target": target, "error": None, "category": "skirt", "cut": "straight_skirt"}
    return told | {"metrics": metrics, "cpu_seconds": cpu, "peak_mb": 800.0}


def person_line(iou: float, s2t: tuple[float, ...]) -> dict:
    """Return a line of a raw pack."""
    garments = [{"part": f"part{n}", "s2t_mm": value, "verdicts": ["hidden"]} for n, value in enumerate(s2t)]
    told = {"target": "p", "error": None, "outcome": "right", "problem": None, "outfit": ["upper:tshirt"]}
    return told | {"labels": {"cloth_iou": iou}, "garments": garments, "cpu_seconds": 99.0, "peak_mb": 900.0}


def change_of(before: list[list[float]], after: list[float]):
    """Return how the distance changed."""
    runs = [[garment_line(f"t{n}", value) for value in row] for n, row in enumerate(before)]
    found = compare_lines(runs, [garment_line(f"t{n}", value) for n, value in enumerate(after)])
    return next(one for one in found if one.name == "surface_rms_mm.s2t")


def test_a_rise_beyond_rounding_is_worse():
    """Broken where a change that makes all targets worse is taken for rounding, or rounding for a change."""
    quiet = [[1.00, 1.01, 0.99], [2.00, 2.02, 1.98], [3.00, 3.01, 2.99]]
    assert not change_of(quiet, [1.01, 2.02, 3.03]).is_worse, "1 % is less than the rule's 3 %"
    assert change_of(quiet, [1.05, 2.10, 3.15]).is_worse
    loud = [[1.0, 1.5, 0.5], [2.0, 3.0, 1.0], [3.0, 4.0, 2.0]]
    assert not change_of(loud, [1.05, 2.10, 3.15]).is_worse, "less than two standard errors"
    assert change_of(loud, [2.0, 4.0, 6.0]).is_worse
    assert not change_of(quiet, [0.9, 1.8, 2.7]).is_worse


def test_the_error_is_that_of_the_difference_of_means():
    """Broken where the scatter of three runs is taken for that of one, or of one target for that of the mean."""
    rng = np.random.default_rng(5)
    spread = 0.1 * np.ones(4)
    found, errors = [], []
    for _ in range(400):
        runs, last = 5.0 + spread[:, None] * rng.normal(size=(4, 3)), 5.0 + spread * rng.normal(size=4)
        one = change_of(runs.tolist(), last.tolist())
        found.append(one.after - one.before)
        errors.append(one.error)
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(np.std(found), rel=0.1)


def test_single_figures_that_leave_their_range_are_listed():
    """Broken where one target falls apart and the mean hides it, or every target is listed."""
    change = change_of([[1.0, 1.1, 1.2], [2.0, 2.1, 2.2]], [1.29, 2.31])
    assert change.left == ("t1 2.1 -> 2.31",)


def test_verdicts_that_changed_are_told():
    """Broken where a category, a gate or a refusal changes in silence."""
    one = garment_line("t", 1.0)
    refused = one | {"error": {"code": "scan.bad", "message": "?"}}
    assert format_verdicts([one], [one | {"cut": "a_line_skirt"}]) == ["- t: cut 'straight_skirt' -> 'a_line_skirt'"]
    assert "- t: outcome 'recovered' -> 'scan.bad'" in format_verdicts([one], [refused])
    failed = one | {"metrics": {"surface_rms_mm.s2t": 90.0, "crossings": 5000.0}}
    assert list_verdicts(one)["gates"] != list_verdicts(failed)["gates"]
    assert list_verdicts(person_line(0.9, (1.0, 2.0)))["part1 gates"] == "hidden"
    assert format_verdicts([one], [one]) == ["No verdict changed."]


def test_less_is_better_in_every_figure():
    """Broken where a better IoU counts as worse, or the garments of a person are not taken together."""
    found = list_figures(person_line(0.9, (1.0, 2.0)))
    assert found["1 - cloth IoU"] == pytest.approx(0.1) and found["garment.s2t_mm"] == pytest.approx(1.5)
    text = "\n".join(format_changes(compare_lines([[person_line(0.9, (1.0,))]], [person_line(0.95, (1.0,))])))
    assert "| 1 - cloth IoU | 1 | 0.1 | 0.05 | -50.0 % | inf |  |" in text
    costs = compare_lines([[garment_line("t", 1.0, cpu)] for cpu in (50.0, 51.0)], [garment_line("t", 1.0, 500.0)] * 2)
    assert not any(change.is_worse for change in costs), "what a run costs is shown, not judged"


@pytest.mark.parametrize("is_cloud", [False, True])
def test_a_moved_pack_is_the_same_but_for_rounding(tmp_path, is_cloud):
    """Broken where single precision swallows the shift, so that three runs are one, or the truth is moved along."""
    pack = tmp_path / "pack"
    (pack / "truth").mkdir(parents=True)
    (pack / "meta.json").write_text("{}")
    ball = icosphere(2)
    mesh = PointCloud(ball.vertices) if is_cloud else Trimesh(ball.vertices, ball.faces, process=False)
    mesh.export(pack / ("scan.ply" if is_cloud else "garment.ply"))
    found = []
    for seed in (1, 2):
        moved = move_pack(pack, tmp_path / f"moved{seed}" / "pack", seed)
        name = "scan.ply" if is_cloud else "garment.ply"
        before, after = read_raw_file(pack / name), read_raw_file(moved / name)
        off = np.abs(after.points - before.points)
        assert 0.0 < off.max() < 10.0 * MOVED and len(after.faces) == len(before.faces)
        assert (moved / "truth").samefile(pack / "truth") and (moved / "meta.json").samefile(pack / "meta.json")
        found.append(after.points)
    assert (found[0] != found[1]).any()
