"""Show what a job found."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .terminal import print_table, show_time

FIRST = (
    "surface_rms_mm.s2t", "surface_rms_mm.t2s", "graded.surface_rms_mm.s2t", "graded.surface_rms_mm.t2s",
    "hausdorff_mm", "normal_cosine", "body_penetration_mm", "seam_mismatch_mm", "flipped_faces",
    "self_intersecting_faces",
)  # fmt: skip
"""Metrics that a user looks at first; the others follow by name."""


def print_result(found: dict[str, Any], files: list[Path]) -> None:
    """Print a job's result as tables, then where its files are."""
    print_table(
        ["job", "scan", "garment", "template", "fabric", "body", "CPU s", "peak MB", "ended"],
        [
            [
                found["job"], found["name"], found["garment"], found["template"], found["fabric"], found["body"],
                found["cpu_seconds"], found["peak_mb"], show_time(found["finished"]),
            ]
        ],
    )  # fmt: skip
    metrics = found["metrics"]
    names = [name for name in FIRST if name in metrics] + [name for name in metrics if name not in FIRST]
    print_table(["metric", "value"], [[name, metrics[name]] for name in names if metrics[name] is not None])
    gates = found["gates"]
    if gates:
        rows = [[g["name"], g["verdict"], g["value"], g["limit"], g["message"]] for g in gates]
        print_table(["gate", "verdict", "value", "limit", ""], rows)
    if found["warnings"]:
        print_table(["warning"], [[text] for text in found["warnings"]])
    if files:
        print_table(["file", "path"], [[path.name, str(path)] for path in files])


def flatten(found: Sequence[dict[str, Any]]) -> tuple[list[str], list[list[object]]]:
    """Give described jobs as columns and rows: one column for each metric that any of them has."""
    plain = ("job", "name", "state", "garment", "template", "fabric", "body", "attempts", "created", "finished")
    metrics = sorted({name for item in found for name in item["metrics"]})
    rows = [[*(item[name] for name in plain), *(item["metrics"].get(name) for name in metrics)] for item in found]
    return [*plain, *metrics], rows
