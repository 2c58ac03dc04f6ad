"""Segment one raw pack and recover its garments, in a process of its own, and measure the results against the truth.

python -m garmentq.cli.bench.raw_target ORDER.json LINE.json
"""

from __future__ import annotations

import resource
import sys
import tempfile
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.run.units import MM_PER_M
from .lines import Line, answer_order, keep_failure
from .target import peak_mb

if TYPE_CHECKING:
    from ...core.people.separation import FoundGarment, LabelledPerson, PersonSurface
    from ...core.recover.recovery import Recovery
    from ...core.run.hooks import Hooks
    from ...core.scan.raw import RawScan
    from .raw_frame import TruthFrame
    from .raw_packs import RawPack, TrueGarment


@dataclass(frozen=True)
class RawOrder:
    """Describe how a raw pack is run.

    Attributes:
        pack: Its folder.
        method: Recovery method.
        preset: Weights of the deformation.
        shipped: True if the pack's base patterns are not used.
        out: Folder for the results, or None.
        state: Name of the state into which the scan is brought.
        labels_only: Stop after the labels.
        true_labels: Use the true labels instead of labelling.
    """

    pack: str
    method: str
    preset: str
    shipped: bool
    out: str | None
    state: str = "as_is"
    labels_only: bool = False
    true_labels: bool = False


def empty_line(target: str, order: RawOrder) -> Line:
    """Return the line of a raw pack without results yet."""
    return {
        "target": target,
        "state": order.state,
        "true_labels": order.true_labels,
        "method": order.method,
        "ok": False,
        "error": None,
        "problem": None,
        "outcome": "refused",
        "outfit": [],
        "true_outfit": [],
        "outfit_confidence": None,
        "labels": {},
        "calibration": {},
        "border": {},
        "body": {},
        "garments": [],
        "cpu_seconds": None,
        "compile_seconds": None,
        "stage_seconds": {},
        "peak_mb": None,
        "peak_mb_labels": None,
        "points": None,
        "frame_mm": None,
        "warnings": [],
    }


def run_pack(order: RawOrder) -> Line:
    """Run a raw pack and measure it.

    Returns:
        The line that `garmentq bench --json` prints; an error is stored in it, never raised.
    """
    from ...core.deliver.export.result import to_plain_json
    from .compiling import time_compiling

    line = empty_line(Path(order.pack).name, order)
    with keep_failure(line), time_compiling() as compiling:
        started = spent_seconds()
        _Run(order, line).run()
        line["compile_seconds"] = compiling.seconds
        line["cpu_seconds"] = spent_seconds() - started - compiling.seconds
    line["peak_mb"] = peak_mb()
    if line["error"] is not None and line["error"]["code"].startswith("bench."):
        line["outcome"] = "failed"  # a bug is not a refusal
    found: Line = to_plain_json(line)
    return found


class _Run:
    """Run one raw pack; results so far are in the line.

    Attributes:
        order: The order.
        line: The results so far.
        pack: The pack.
        clock: CPU seconds by stage.
    """

    def __init__(self, order: RawOrder, line: Line) -> None:
        from .raw_packs import read_raw_packs

        self.order, self.line = order, line
        self.pack: RawPack = read_raw_packs(Path(order.pack))[0]
        self.clock = StageClock(line["stage_seconds"])
        line["true_outfit"] = [_name(each.part, each.category) for each in self.pack.garments]

    def run(self) -> None:
        """Bring the scan into its state, segment it, and recover every garment that was found."""
        from .raw_file import read_raw_file, write_raw_file
        from .raw_packs import read_true_labels
        from .raw_states import SCAN_STATES, degrade_scan

        file, labels = read_raw_file(self.pack.scan), read_true_labels(self.pack)
        with tempfile.TemporaryDirectory(prefix="garmentq-raw-") as folder:
            path = self.pack.scan
            if self.order.state != SCAN_STATES[0].name:
                state = next(each for each in SCAN_STATES if each.name == self.order.state)
                metre = float(np.linalg.norm(self.pack.to_truth[:3, 0]))
                file, labels = degrade_scan(file, labels, state, metre)
                path = write_raw_file(file, Path(folder) / "scan.ply")
            self.line["points"] = len(labels)
            points = file.points @ self.pack.to_truth[:3, :3].T + self.pack.to_truth[:3, 3]
            raw, separation = self._separate(path, labels)
            frame = self._measure_separation(raw, separation, points, file.faces, labels)
            if self.order.labels_only or separation.problem is not None:
                self.line["ok"] = separation.problem is None
                return
            surface = self._find_surface(raw, separation)
            for garment in (one for one in separation.garments if one.problem is None):
                self._recover(path, surface, separation, garment, frame)
            self.line["ok"] = all(each["error"] is None for each in self.line["garments"])

    def _separate(self, path: Path, labels: np.ndarray) -> tuple[RawScan, LabelledPerson]:
        from ...core.people.hints import Hints
        from ...core.people.separate import label_person
        from ...core.scan.load_raw import load_raw

        with self.clock.stage("load"):
            raw = load_raw(path)
        with self.clock.stage("separate") as hooks:
            separation = label_person(raw, Hints(label=labels) if self.order.true_labels else Hints(), hooks)
        self.line["peak_mb_labels"] = peak_mb()
        self._write_separation(separation)
        return raw, separation

    def _write_separation(self, separation: LabelledPerson) -> None:
        folder = self._folder()
        if folder is not None:
            from ...core.deliver.export.meshes import write_ply
            from ...core.people.labels import write_labels

            write_labels(separation.label, separation.confidence, folder / "labels.npz")
            write_ply(separation.body.vertices, separation.body.faces, folder / "body.ply")

    def _folder(self, *names: str) -> Path | None:
        """Return a folder of this run's results, created if it is missing; None if results are not kept."""
        if self.order.out is None:
            return None
        state = "" if self.order.state == "as_is" else f"@{self.order.state}"
        folder = Path(self.order.out).joinpath(self.pack.name + state, *names)
        folder.mkdir(parents=True, exist_ok=True)
        return folder

    def _measure_separation(
        self, raw: RawScan, separation: LabelledPerson, points: np.ndarray, faces: np.ndarray, labels: np.ndarray
    ) -> TruthFrame:
        from .packs import read_mesh_file
        from .raw_borders import find_edges, measure_borders
        from .raw_frame import find_frame
        from .raw_labels import measure_calibration, measure_labels
        from .raw_outcome import judge_outcome
        from .raw_packs import read_cover
        from .raw_shape import measure_true_body

        line, found = self.line, separation.label
        score = measure_labels(labels, found)
        border = measure_borders(points, find_edges(points, faces), labels, found)
        frame = find_frame(raw, points)
        body = (frame.apply(separation.body.vertices), separation.body.faces)
        of_body = measure_true_body(read_mesh_file(self.pack.body), read_cover(self.pack), body)
        worn = {each.part: each.category for each in self.pack.garments}
        names = {each.part: each.category for each in separation.garments}
        problems = (separation.problem, *(each.problem for each in separation.garments))
        code = next((each.code for each in problems if each is not None), None)
        line |= {
            "problem": code,
            "outcome": judge_outcome(worn, names, score.part_iou, code, False).value,
            "outfit": [_name(each.part, each.category) for each in separation.garments],
            "outfit_confidence": _share_of_best([each.score for each in separation.outfits]),
            "labels": asdict(score),
            "calibration": asdict(measure_calibration(labels, found, separation.confidence)),
            "border": {
                "median_mm": MM_PER_M * border.median,
                "p95_mm": MM_PER_M * border.p95,
                "by_part_mm": {name: MM_PER_M * value for name, value in border.by_part.items()},
            },
            "body": {
                name: {"mean_mm": MM_PER_M * each.mean, "p95_mm": MM_PER_M * each.p95} for name, each in of_body.items()
            },
            "frame_mm": MM_PER_M * frame.error,
            "warnings": [*raw.notes, *separation.warnings],
        }
        line["garments"] = [_describe(garment) for garment in separation.garments]
        return frame

    def _find_surface(self, raw: RawScan, separation: LabelledPerson) -> PersonSurface:
        from ...core.people.garments import build_person_surface

        with self.clock.stage("surface"):
            return build_person_surface(raw, separation.body)

    def _recover(
        self, path: Path, surface: PersonSurface, separation: LabelledPerson, garment: FoundGarment, frame: TruthFrame
    ) -> None:
        from ...core.deliver.export.result import write_recovery
        from ...core.garment.garmentcode import load_pattern
        from ...core.people.garments import extract_garment
        from ...core.recover.pipeline import recover
        from ...core.recover.recovery import Request
        from ...core.recover.settings import RecoverySettings

        truth = next((each for each in self.pack.garments if each.part == garment.part), None)
        line = next(each for each in self.line["garments"] if each["part"] == garment.part.word)
        template = None if truth is None or self.order.shipped else truth.template
        settings = RecoverySettings(method=self.order.method, preset=self.order.preset)
        word = garment.part.word
        with keep_failure(line):
            with self.clock.stage(f"{word}.cut"):
                reading = extract_garment(surface, separation, garment.part)
            if template is not None:
                reading = replace(reading, pattern=load_pattern(template))
            with self.clock.stage(f"{word}.recover"):
                recovery = recover(Request(scan=path, template=template, settings=settings, reading=reading))
            line |= {
                "category": recovery.target.category,
                "template": recovery.template,
                "verdicts": {gate.name: gate.verdict for gate in recovery.report.gates if gate.verdict != "pass"},
                "untrusted": [each.name for each in recovery.target.contours if not each.trusted],
                "cpu_seconds": recovery.report.cpu_seconds,
                "stage_seconds": recovery.report.stage_seconds,
                "body_penetration_mm": recovery.report.metrics.get("body_penetration_mm"),
                "warnings": list(recovery.report.warnings),
            }
            folder = self._folder(word)
            if folder is not None:
                write_recovery(recovery, folder)
            if truth is not None:
                line["category_right"] = recovery.target.category == truth.category
                line |= _measure_garment(recovery, truth, frame, template is not None)


def _measure_garment(recovery: Recovery, truth: TrueGarment, frame: TruthFrame, own_template: bool) -> Line:
    """Measure a recovered garment against the visible part of its truth, and its pattern."""
    from .packs import read_mesh_file
    from .pattern_match import is_same_cut, measure_panels, measure_pattern
    from .raw_packs import read_garment_pattern, read_visible
    from .raw_shape import measure_visible

    detail = (frame.apply(recovery.meshes.detail), recovery.garment.faces)
    score = measure_visible(detail, read_mesh_file(truth.mesh), read_visible(truth))
    line: Line = {f"{name}_mm": MM_PER_M * value for name, value in asdict(score).items()}
    pattern = read_garment_pattern(truth)
    if pattern is not None and (own_template or is_same_cut(recovery.pattern, pattern)):
        pattern = replace(pattern, seams=())  # a raw pack's outlines have no edges for a seam to name
        line["pattern"] = measure_pattern(recovery.pattern, pattern, own_template)
        line["panels"] = measure_panels(recovery.pattern, pattern, own_template)
    return line


class StageClock:
    """Sum CPU seconds by stage, and within a stage by the names of its progress reports."""

    def __init__(self, seconds: dict[str, float]) -> None:
        self.seconds = seconds
        self._name: str | None = None
        self._since = 0.0
        self._outer = ""

    def stage(self, name: str) -> StageClock:
        """Begin a stage; use it as a context that yields hooks."""
        self._outer = name
        return self

    def __enter__(self) -> Hooks:
        from ...core.run.hooks import Hooks

        self._turn_to(self._outer)
        return Hooks(on_progress=lambda stage, fraction, message: self._turn_to(f"{self._outer}.{stage}"))

    def __exit__(self, *_: object) -> None:
        self._turn_to(None)

    def _turn_to(self, name: str | None) -> None:
        now = spent_seconds()
        if self._name is not None:
            self.seconds[self._name] = self.seconds.get(self._name, 0.0) + now - self._since
        self._name, self._since = name, now


def spent_seconds() -> float:
    """Return the CPU seconds of this process and of its finished children, which read the files."""
    used = [resource.getrusage(process) for process in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def _describe(garment: FoundGarment) -> Line:
    """Return the line of a garment that was found and is not recovered yet."""
    return {
        "part": garment.part.word,
        "found_category": garment.category,
        "category": None,
        "category_right": None,
        "confidence": garment.confidence,
        "contours": {each.name: None if each.is_inferred else each.confidence for each in garment.contours},
        "error": None,
        "cpu_seconds": None,
    }


def _name(part: Any, category: str) -> str:
    return f"{part.word}:{category}"


def _share_of_best(scores: list[float]) -> float | None:
    """Return the probability of the best of some readings, from their log-probabilities up to a constant."""
    if not scores:
        return None
    weights = np.exp(np.array(scores) - max(scores))
    return float(weights[0] / weights.sum())


if __name__ == "__main__":
    answer_order(sys.argv[1:], RawOrder, run_pack)
