"""Judge what was recovered of an unseen set beside what was drafted and draped, and print it as tables."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from bench_compare import list_verdicts
from bench_runs import Job
from foreign_panels import compare_pieces, join_halves
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.garment.parts.cut import Cut, Hood
from garmentq.core.garment.templates import find_cut
from garmentq.core.geometry.geometry import face_areas
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.scan.contours.target import TOP_CATEGORIES
from garmentq.training.designs import name_finished

Line = Mapping[str, Any]

GARMENT_COLUMNS = (
    "target", "front, collar", "found", "detail s2t", "t2s", "simulation t2s", "re-drape t2s", "area %",
    "outline", "CPU s", "MB", "gates",
)  # fmt: skip

PERSON_COLUMNS = (
    "target", "front, collar", "true", "outcome", "found", "cloth IoU", "body, cloth", "bare", "s2t", "t2s",
    "area %", "outline", "CPU s", "MB", "gates",
)  # fmt: skip


def measure_distances(ours: Path, truth: Path) -> tuple[float, float]:
    """Return RMS distances [mm] from one surface to another and back, each face counted by its area."""
    meshes = [trimesh.load(path, process=False) for path in (ours, truth)]
    surfaces = [(np.asarray(mesh.vertices), np.asarray(mesh.faces)) for mesh in meshes]
    return _measure_to(surfaces[0], surfaces[1]), _measure_to(surfaces[1], surfaces[0])


def _measure_to(one: tuple[np.ndarray, np.ndarray], other: tuple[np.ndarray, np.ndarray]) -> float:
    middles, areas = one[0][one[1]].mean(axis=1), face_areas(*one)
    distance = TriangleSurface(*other).distance(middles)
    return float(1e3 * np.sqrt((areas * distance**2).sum() / areas.sum()))


def measure_panels(ours: Path, drafted: Path) -> tuple[float | None, float | None]:
    """Return mean errors of the areas [%] and outlines [mm] of wide panels; None where they do not correspond."""
    pairs = compare_pieces(join_halves(load_pattern(ours)), join_halves(load_pattern(drafted)))
    if not pairs:
        return None, None
    return (
        100.0 * float(np.mean([abs(pair.area) for pair in pairs])),
        1e3 * float(np.mean([pair.outline for pair in pairs])),
    )


def compare_finish(pack: Path, found: str | None) -> str | None:
    """Return what is sewn to the neck and centre front of a target's top, true and found, `shirt, open; shirt, open`.

    Args:
        pack: Its folder.
        found: Name of the cut that was recovered, or None.
    """
    draft = json.loads((pack / "meta.json").read_text())["drawn"]["drafts"][-1]
    if found is None or draft["category"] not in TOP_CATEGORIES:
        return None
    drawn = name_finished(draft["category"], draft.get("parts", ""))
    return "; ".join(describe_finish(find_cut(name)) for name in (drawn, found))


def describe_finish(cut: Cut) -> str:
    """Return the collar or hood and the front of a cut."""
    worn = f"hood {cut.hood_worn}" if cut.hood is not Hood.NONE else f"{cut.collar}"
    return f"{worn}, {cut.front}"


def describe_garment(job: Job, line: Line, out: Path) -> list[object]:
    """Return the cells of a garment."""
    words, name = list_verdicts(line), job.pack.name
    if line["error"] is not None:
        return [name, None, words["outcome"], *[None] * 6, line["cpu_seconds"], line["peak_mb"], "refused"]
    result = out / job.place / "result" / name
    truth = job.pack / "truth.ply"
    detail = measure_distances(result / "detail.ply", truth)
    others = [
        measure_distances(result / f"{kind}.ply", truth)[1] if (result / f"{kind}.ply").exists() else None
        for kind in ("simulation", "redrape")
    ]
    panels = measure_panels(result / "pattern.json", job.pack / "drafted.json")
    finish = compare_finish(job.pack, line["cut"])
    return [name, finish, line["cut"], *detail, *others, *panels, line["cpu_seconds"], line["peak_mb"], words["gates"]]


def describe_person(job: Job, line: Line, out: Path) -> list[object]:
    """Return the cells of a person; those of his garments are means."""
    labels, body = line["labels"] or {}, line["body"] or {}
    sums: dict[str, list[float]] = {"s2t_mm": [], "t2s_mm": [], "area": [], "outline": []}
    for garment in line["garments"]:
        for name in ("s2t_mm", "t2s_mm"):
            sums[name].append(garment.get(name))
        role = garment["part"].replace("-", "")
        ours = out / job.place / "result" / job.pack.name / garment["part"] / "pattern.json"
        drafted = job.pack / "truth" / f"drafted_{role}.json"
        if ours.exists() and drafted.exists():
            area, outline = measure_panels(ours, drafted)
            sums["area"].append(area)
            sums["outline"].append(outline)
    manifest, found = out / job.place / "result" / job.pack.name / "upper" / "manifest.json", None
    if manifest.exists():
        found = json.loads(manifest.read_text()).get("cut")
    outcome = line["error"]["code"] if line["error"] else f"{line['outcome']} {line['problem'] or ''}".strip()
    return [
        job.pack.name, compare_finish(job.pack, found), ", ".join(line["true_outfit"]), outcome,
        ", ".join(line["outfit"]), labels.get("cloth_iou"),
        *((body.get(kind) or {}).get("mean_mm") for kind in ("covered", "bare")), *map(_mean, sums.values()),
        line["cpu_seconds"], line["peak_mb"], "; ".join(describe_gates(one) for one in line["garments"]),
    ]  # fmt: skip


def describe_gates(garment: Line) -> str:
    """Return a garment of a person, and the gates that do not pass or its error's code."""
    if garment.get("error"):
        return f"{garment['part']}: {garment['error']['code']}"
    failed = ", ".join(f"{name} {verdict}" for name, verdict in garment.get("verdicts", {}).items())
    return f"{garment['part']}: {failed or 'pass'}"


def _mean(values: Iterable[float | None]) -> float | None:
    some = [value for value in values if value is not None]
    return float(np.mean(some)) if some else None


def format_rows(columns: Sequence[str], rows: list[list[object]]) -> list[str]:
    """Return rows as a table of Markdown with the means of its numbers."""
    means: list[object] = ["mean"]
    for column in list(zip(*rows, strict=True))[1:]:
        numbers = [cell for cell in column if isinstance(cell, float)]
        means.append(_mean(numbers))
    lines = [f"| {' | '.join(columns)} |", f"|{'---|' * len(columns)}"]
    return lines + [f"| {' | '.join(map(_format, row))} |" for row in [*rows, means]]


def _format(cell: object) -> str:
    if cell is None:
        return ""
    return (
        f"{cell:.3g}"
        if isinstance(cell, float) and abs(cell) < 100.0
        else f"{cell:.0f}"
        if isinstance(cell, float)
        else str(cell)
    )


def format_set(jobs: Sequence[Job], lines: Sequence[Line], out: Path) -> list[str]:
    """Return the tables of one mode: garments, then persons."""
    garments, persons = [], []
    for job, line in zip(jobs, lines, strict=True):
        if "outcome" in line:
            persons.append(describe_person(job, line, out))
        else:
            garments.append(describe_garment(job, line, out))
    told: list[str] = []
    for columns, rows in ((GARMENT_COLUMNS, garments), (PERSON_COLUMNS, persons)):
        if rows:
            told += ["", *format_rows(columns, rows)]
    return told


def describe_targets(packs: Iterable[Path]) -> list[str]:
    """Return a line of Markdown for each target: who drafted and draped it, pose, noise and holes of its scan."""
    rows = [
        "| target | drafted by | draped by | pose | noise [mm] | holes | crossing faces |",
        "|---|---|---|---|---|---|---|",
    ]
    for pack in packs:
        told = json.loads((pack / "meta.json").read_text())
        drawn = told["drawn"]
        programs = ", ".join(draft["program"] for draft in drawn["drafts"])
        rows.append(
            f"| {pack.name} | {programs} | {drawn['solver']} | {drawn['pose']} | {1e3 * drawn['noise']:.2f} | "
            f"{len(drawn['holes'])} | {', '.join(map(str, told['crossing']))} |"
        )
    return rows
