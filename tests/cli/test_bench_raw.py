"""`garmentq bench` on raw packs: what a recovery is told, lines, outcomes and exit statuses."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from garmentq.cli.bench import raw_run, raw_target
from garmentq.cli.bench import run as bench
from garmentq.cli.bench.packs import read_mesh_file
from garmentq.cli.bench.raw_file import read_raw_file
from garmentq.cli.bench.raw_outcome import Outcome
from garmentq.cli.bench.raw_run import OUTCOMES, STATE_NAMES
from garmentq.cli.bench.raw_states import SCAN_STATES
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.reading import Reading
from garmentq.core.people.part import Part
from garmentq.core.people.separation import FoundContour, FoundGarment, LabelledPerson, Outfit
from garmentq.core.run.errors import BadInput
from garmentq.core.scan.pieces import ScanInput
from garmentq.core.scan.raw import RawScan
from garmentq.core.scan.scan import Scan
from garmentq_raw_pack import dress, make_raw_pack

KEYS = {
    "target", "state", "true_labels", "method", "ok", "error", "problem", "outcome", "outfit", "true_outfit",
    "outfit_confidence", "labels", "calibration", "border", "body", "garments", "cpu_seconds", "compile_seconds",
    "stage_seconds", "peak_mb", "peak_mb_labels", "points", "frame_mm", "warnings",
}  # fmt: skip


@dataclass
class Road:
    """Stand in for reading, taking apart and recovering; records what each was given."""

    body: object
    recovery: object
    problem: BadInput | None = None
    error: BadInput | None = None
    hints: object = None
    requests: tuple = ()
    waist: float = 0.5

    def load_raw(self, path: Path) -> RawScan:
        """Read the sheet, which is in centimetres with z up."""
        file = read_raw_file(path)
        points = 0.01 * file.points[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
        count = np.arange(len(points))
        return RawScan(points, file.faces, None, False, None, None, count, count)

    def separate(self, raw: RawScan, hints: object, hooks: object) -> LabelledPerson:
        """Label the sheet by height; a centimetre off at the waist where `waist` is."""
        if self.error is not None:
            raise self.error
        self.hints = hints
        label = dress(raw.points, 0.1, self.waist, 0.9)
        categories = {Part.UPPER: "tshirt", Part.LOWER: "skirt"}
        rims = (FoundContour("hem", 0.8, False), FoundContour("neck", 0.5, True))
        garments = tuple(FoundGarment(part, 0.9, name, rims) for part, name in categories.items())
        outfits = (Outfit(tuple(categories), 0.0), Outfit((Part.ONE_PIECE,), -1.0))
        confidence = np.full(len(label), 0.95, np.float32)
        return LabelledPerson(self.body, label, confidence, garments, outfits, ("it was dark.",), self.problem)

    def find_surface(self, raw: RawScan, body: object) -> Scan:
        """Return the sheet."""
        return Scan(raw.points, raw.faces)

    def cut_garment_of(self, surface: Scan, separation: LabelledPerson, part: Part) -> Reading:
        """Return all of the sheet."""
        return Reading(ScanInput(surface, None), self.body)

    def recover(self, request: object) -> object:
        """Return a recovery that is known."""
        self.requests = (*self.requests, request)
        return self.recovery


@pytest.fixture()
def packs(tmp_path: Path, tube_pattern) -> Path:
    """Write one raw pack with a base pattern for the lower garment."""
    pack = make_raw_pack(tmp_path / "packs" / "sheet")
    save_pattern(tube_pattern(), pack / "truth" / "base_lower.json")
    return pack.parent


@pytest.fixture()
def road(monkeypatch: pytest.MonkeyPatch, packs: Path, tube_recovery, bare_body) -> Road:
    """Run raw packs in this process along a road that is known."""
    found = Road(bare_body(*read_mesh_file(packs / "sheet" / "truth" / "body.ply")), tube_recovery())
    modules = {
        "scan.load_raw": {"load_raw": found.load_raw},
        "people.separate": {"label_person": found.separate},
        "people.hints": {"Hints": lambda label=None: SimpleNamespace(label=label)},
        "people.labels": {"write_labels": lambda label, confidence, path: np.savez(path, label=label)},
        "people.garments": {"extract_garment": found.cut_garment_of, "build_person_surface": found.find_surface},
        "recover.pipeline": {"recover": found.recover},
    }
    for name, values in modules.items():
        monkeypatch.setitem(sys.modules, f"garmentq.core.{name}", SimpleNamespace(**values))
    monkeypatch.setattr(raw_run, "run_raw_pack", lambda pack, order, timeout: raw_target.run_pack(order))
    return found


def run(*arguments: object, status: int = 0) -> list[dict]:
    """Run the command; give its lines."""
    result = CliRunner().invoke(bench.command, [*(str(argument) for argument in arguments), "--json"])
    assert result.exit_code == status, (result.output, result.exception)
    return [json.loads(line) for line in result.stdout.splitlines()]


def test_a_line_says_what_was_found(packs: Path, road: Road, tmp_path: Path) -> None:
    """Broken where a key were missing, the truth leaked into the recovery, or the results were not kept."""
    (line,) = run(packs, "--out", tmp_path / "out")
    assert set(line) == KEYS
    assert line["ok"] and line["outcome"] == "right" and line["error"] is None
    assert line["outfit"] == line["true_outfit"] == ["upper:tshirt", "lower:skirt"]
    assert line["labels"]["cloth_iou"] == 1.0 and line["border"]["median_mm"] == 0.0
    assert line["body"]["covered"]["mean_mm"] == pytest.approx(0.0, abs=1e-3)
    assert line["outfit_confidence"] == pytest.approx(1.0 / (1.0 + np.exp(-1.0)))
    assert line["calibration"]["sure_right"] == 1.0 and line["frame_mm"] < 1e-3
    assert line["stage_seconds"].keys() >= {"load", "separate", "upper.cut", "lower.recover"}
    upper, lower = line["garments"]
    assert lower["found_category"] == lower["category"] == "skirt" and lower["category_right"]
    assert not upper["category_right"] and lower["contours"] == {"hem": 0.8, "neck": None}
    assert lower["s2t_mm"] > 0.0 and lower["t2s_mm"] > 0.0
    assert lower["pattern"]["panel_area_error"] is not None and "pattern" not in upper
    # Nothing of the truth but the base pattern, where there is one.
    assert road.hints.label is None
    first, second = road.requests
    assert first.template is None and first.reading.pattern is None
    assert second.template.name == "base_lower.json" and second.reading.pattern.category == "skirt"
    assert first.settings.garment is None and first.labels is None and first.body is None
    kept = {str(path.relative_to(tmp_path / "out")) for path in (tmp_path / "out").rglob("*")}
    assert kept >= {"sheet/labels.npz", "sheet/body.ply", "sheet/upper/detail.ply", "sheet/lower/pattern.json"}


def test_without_the_packs_patterns_and_with_the_true_labels(packs: Path, road: Road) -> None:
    """Broken where --library still handed the base pattern over, or --true-labels other labels than the truth's."""
    run(packs, "--library", "--true-labels")
    assert [request.template for request in road.requests] == [None, None]
    truth = np.load(packs / "sheet" / "truth" / "labels.npz")["label"]
    assert np.array_equal(road.hints.label, truth)


def test_states_stop_at_the_labels(packs: Path, road: Road) -> None:
    """Broken where a state were left out, recovered in full unasked, or scored against another state's labels."""
    lines = run(packs, "--states")
    assert [line["state"] for line in lines] == list(STATE_NAMES[1:]) and not road.requests
    assert all(line["outcome"] == "right" for line in lines)
    assert {line["points"] for line in lines} >= {6000, 50_000}
    (line,) = run(packs, "--state", "no_colours", "--whole")
    assert len(road.requests) == 2 and line["state"] == "no_colours"
    run(packs, "--labels-only")
    assert len(road.requests) == 2


def test_doubts_refusals_and_errors_are_told_apart(packs: Path, road: Road) -> None:
    """Broken where a doubt were recovered, a refusal hid its code, or an answer that is wrong passed for right."""
    road.problem = BadInput("nobody knows.")
    (line,) = run(packs, status=5)
    assert (line["outcome"], line["problem"], line["error"]) == ("doubtful", "input.bad", None)
    assert not road.requests and line["labels"]["cloth_iou"] == 1.0
    road.error = BadInput("it is a chair.")
    (line,) = run(packs, status=5)
    assert line["outcome"] == "refused" and line["error"]["code"] == "input.bad"
    road.error, road.problem, road.waist = None, None, 0.85
    (line,) = run(packs, "--labels-only", status=5)
    assert line["outcome"] == "wrong"
    assert line["border"]["p95_mm"] > 300.0


def test_the_tables(packs: Path, road: Road) -> None:
    """Broken where a garment, the mean or an outcome were left out of what people read."""
    result = CliRunner().invoke(bench.command, [str(packs)])
    assert result.exit_code == 0, result.output
    for word in ("sheet", "as_is", "right", "mean", "upper", "lower", "skirt", "border", "wrong"):
        assert word in result.stdout, word


def test_names_that_are_stated_twice_agree() -> None:
    """Broken where the options, which load nothing, named other states or outcomes than there are."""
    assert STATE_NAMES == tuple(state.name for state in SCAN_STATES)
    assert set(OUTCOMES) == {outcome.value for outcome in Outcome} | {"failed"}


def test_a_crash_is_a_line(packs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Broken where a process that died took the bench with it, or passed for a refusal."""
    from garmentq.cli.bench import process

    monkeypatch.setattr(process.sys, "executable", "/bin/false")
    (line,) = run(packs, status=5)
    assert line["error"]["code"] == "bench.crashed" and line["outcome"] == "failed" and set(line) == KEYS
