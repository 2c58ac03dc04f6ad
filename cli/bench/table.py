"""The bench's tables: every target, every metric, and the thesis' numbers beside ours where they are defined alike."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..terminal import print_table
from .lines import Line

KEY_COLUMNS = (
    ("s2t", "surface_rms_mm.s2t"),
    ("t2s", "surface_rms_mm.t2s"),
    ("graded", "graded.surface_rms_mm.s2t"),
    ("t2s", "graded.surface_rms_mm.t2s"),
    ("chamf.", "chamfer_vertex_m2e3"),
    ("normal", "normal_cosine"),
    ("area", "panel_area_error"),
    ("outl.", "panel_outline_mm"),
    ("inside", "body_penetration_mm"),
    ("flips", "flipped_faces"),
    ("cross.", "crossing_faces"),
    ("sim.", "sim.crossing_faces"),
    ("redr.", "redrape.crossing_faces"),
)
"""Columns of the first table; distances in mm. The last three are faces that pass through others, of detail, simulation
and re-draped mesh, without those that the body itself pinches."""

TARGETS_ABREAST = 6
"""Number of targets beside each other in the table of all metrics: as many as a wide terminal shows."""

THESIS_METRICS = (
    "chamfer_vertex_m2e3",
    "chamfer_vertex_floor_m2e3",
    "normal_cosine",
    "sim.chamfer_vertex_m2e3",
    "sim.normal_cosine",
    "panel_area_error_all",
)
"""Metrics that are defined as in the thesis (its surface error is over all panels), and the floor of the first. The
detail mesh is compared with PhyDeformer's, the simulation mesh and the pattern with IGPM's."""

THESIS = {
    "T-shirt": (("tshirt", "long_sleeve_tshirt"), (0.101, 0.017), (0.112, 0.049), 0.09),
    "Dress": (("dress",), (0.096, 0.029), (0.110, 0.075), 0.10),
    "Shorts": (("shorts",), (0.088, 0.019), (0.126, 0.043), 0.04),
    "Pants": (("trousers",), (0.084, 0.019), (0.142, 0.049), 0.08),
    "Skirt": (("skirt",), (0.086, 0.007), (0.106, 0.014), 0.04),
}
"""By the thesis' garment: our categories, Chamfer and normal of PhyDeformer (table 4.1), of IGPM (table 3.2; for the
dress also the last row of table 3.4), and IGPM's surface error (table 3.3). Its turning numbers are defined otherwise
and are left out."""


def print_tables(lines: Sequence[Line], categories: dict[str, str]) -> None:
    """Print all tables.

    Args:
        lines: One line per target, as `--json` prints them.
        categories: Each target's category by its author, for the comparison.
    """
    done = [line for line in lines if line["ok"]]
    _print_targets(lines, done)
    if done:
        _print_metrics(done)
        _print_thesis(done, categories)


def mean(values: Sequence[float | None]) -> float | None:
    """Return the unweighted mean of the known values, or None."""
    known = [value for value in values if value is not None and math.isfinite(value)]
    return sum(known) / len(known) if known else None


def round_to_three_digits(values: Sequence[float | None]) -> list[float | None]:
    """Round to three significant digits."""
    return [None if value is None else float(f"{value:.3g}") for value in values]


def _print_targets(lines: Sequence[Line], done: Sequence[Line]) -> None:
    rows: list[list[object]] = []
    for line in lines:
        state = "ok" if line["ok"] else "failed"
        values = [line["metrics"].get(name) for _, name in KEY_COLUMNS]
        rows.append(
            [
                line["target"],
                line["category"],
                state,
                *round_to_three_digits([*values, line["cpu_seconds"], line["peak_mb"]]),
            ]
        )
    means = [mean([line["metrics"].get(name) for line in done]) for _, name in KEY_COLUMNS]
    totals = [mean([line[name] for line in done]) for name in ("cpu_seconds", "peak_mb")]
    rows.append(["mean", None, f"{len(done)} of {len(lines)}", *round_to_three_digits([*means, *totals])])
    columns = ["target", "category", "state", *(title for title, _ in KEY_COLUMNS), "CPU s", "MB"]
    print_table(columns, rows, title="Targets (s2t and t2s in mm, the detail mesh's first, then the graded drape's)")
    failed = [[line["target"], line["error"]["code"], line["error"]["message"]] for line in lines if line["error"]]
    if failed:
        print_table(["target", "error", "message"], failed, title="Failures")


def _print_metrics(done: Sequence[Line]) -> None:
    """Print every metric, seconds by stage and memory of each target, a few beside each other, and their means."""
    flat = [
        line["metrics"]
        | {f"seconds.{stage}": seconds for stage, seconds in line["stage_seconds"].items()}
        | {"seconds": line["cpu_seconds"], "peak_mb": line["peak_mb"]}
        for line in done
    ]
    names = list(dict.fromkeys(name for values in flat for name in values))
    for low in range(0, len(done), TARGETS_ABREAST):
        shown = slice(low, low + TARGETS_ABREAST)
        rows = [
            [
                name,
                *round_to_three_digits(
                    [*(values.get(name) for values in flat[shown]), mean([values.get(name) for values in flat])]
                ),
            ]
            for name in names
        ]
        columns = ["metric", *(line["target"] for line in done[shown]), "mean of all"]
        print_table(columns, rows, title="All metrics" if low == 0 else "All metrics, continued")


def _print_thesis(done: Sequence[Line], categories: dict[str, str]) -> None:
    rows = []
    for garment, (ours, phydeformer, igpm, area) in THESIS.items():
        measured = [line["metrics"] for line in done if categories.get(line["target"]) in ours]
        if measured:
            values = round_to_three_digits(
                [mean([metrics.get(name) for metrics in measured]) for name in THESIS_METRICS]
            )
            rows.append([garment, len(measured), *values[:3], *phydeformer, *values[3:], *igpm, area])
    columns = [
        "garment", "targets", "chamfer", "its floor", "normal", "PhyDeformer chamfer", "normal",
        "sim. chamfer", "normal", "area, all panels", "IGPM chamfer", "normal", "area",
    ]  # fmt: skip
    if rows:
        print_table(columns, rows, title="Beside the thesis (tables 4.1, 3.2, 3.3; other targets, same definitions)")
