"""Compare the lines of two commits over the same targets: paired means, what is worse, verdicts that changed."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from garmentq.core.judge.gates import evaluate_gates

LEAST_RISE = 0.03
"""Share by which a paired mean must rise to be worse."""

ERRORS = 2.0
"""Standard errors of the mean by which it must rise, too."""

OUTSIDE = 0.5
"""Of the range of the runs before: a single figure that leaves it by more is listed."""

GARMENT = (
    "surface_rms_mm.s2t", "surface_rms_mm.t2s", "normal_cosine", "body_penetration_mm", "panel_area_error",
    "panel_area_error_all", "panel_outline_mm", "sim.surface_rms_mm.s2t", "sim.surface_rms_mm.t2s",
    "redrape.surface_rms_mm.s2t", "redrape.surface_rms_mm.t2s", "truth_body_rms_mm",
)  # fmt: skip
"""Metrics of a pack; less is better."""

RAW = {
    "1 - cloth IoU": "labels.cloth_iou", "1 - mean IoU": "labels.mean_iou", "border median [mm]": "border.median_mm",
    "body below cloth [mm]": "body.covered.mean_mm", "bare body [mm]": "body.bare.mean_mm",
    "calibration error": "calibration.error",
}  # fmt: skip
"""Figures of a raw pack by the place in its line; a share of what is right is turned round."""

COSTS = ("CPU [s]", "memory [MB]")
"""What a run costs; never worse or better as a recovery."""

Line = Mapping[str, Any]


@dataclass(frozen=True)
class Change:
    """Describe how one figure changed over a set.

    Attributes:
        name: Of the figure.
        before: Paired mean.
        after: Paired mean.
        error: Standard error of the difference, from the scatter of the commit before; of the differences without.
        count: Targets that have it in every run.
        left: Targets whose own figure left the range of the runs before, as text.
    """

    name: str
    before: float
    after: float
    error: float
    count: int
    left: tuple[str, ...]

    @property
    def is_worse(self) -> bool:
        """Return whether it rose by more than a share and by more than its error allows."""
        rise = self.after - self.before
        return self.name not in COSTS and rise > LEAST_RISE * abs(self.before) and rise > ERRORS * self.error


def list_figures(line: Line) -> dict[str, float]:
    """Return the figures of a line by name; less is better."""
    found: dict[str, float | None] = {"CPU [s]": line["cpu_seconds"], "memory [MB]": line["peak_mb"]}
    if "outcome" not in line:
        found |= {name: line["metrics"].get(name) for name in GARMENT}
        return {name: float(value) for name, value in found.items() if value is not None}
    for name, path in RAW.items():
        value: Any = line
        for word in path.split("."):
            value = value.get(word) if isinstance(value, Mapping) else None
        found[name] = value if value is None or not name.startswith("1 - ") else 1.0 - value
    sums: dict[str, list[float]] = defaultdict(list)
    for garment in line["garments"]:
        for name in ("s2t_mm", "t2s_mm"):
            sums[f"garment.{name}"].append(garment.get(name))
        pattern = garment.get("pattern") or {}
        for name in ("panel_area_error", "panel_area_error_all", "panel_outline_mm"):
            sums[f"garment.{name}"].append(pattern.get(name))
    for name, every in sums.items():
        some = [value for value in every if value is not None]
        found[name] = float(np.mean(some)) if some else None
    return {name: float(value) for name, value in found.items() if value is not None}


def list_verdicts(line: Line) -> dict[str, str]:
    """Return what a line says in words: how it ended, what was found, the gates that do not pass."""
    if line["error"] is not None:
        return {"outcome": str(line["error"]["code"])}
    if "outcome" in line:
        words = {"outcome": f"{line['outcome']} {line['problem'] or ''}".strip(), "outfit": ", ".join(line["outfit"])}
        for garment in line["garments"]:
            failed = ", ".join(sorted(map(str, garment.get("verdicts") or ())))
            words[f"{garment['part']} gates"] = failed or "pass"
        return words
    gates = {gate.name: str(gate.verdict) for gate in evaluate_gates(line["metrics"])}
    failed = ", ".join(f"{name} {verdict}" for name, verdict in sorted(gates.items()) if verdict != "pass")
    return {
        "outcome": "recovered",
        "category": str(line["category"]),
        "cut": str(line["cut"]),
        "gates": failed or "pass",
    }


def compare_lines(before: Iterable[Sequence[Line]], after: Iterable[Line]) -> list[Change]:
    """Compare figures of the same targets.

    Args:
        before: Of each target its runs by the commit before: with the scan moved by rounding, or only one.
        after: Of each target its run by the other commit, in the same order.
    """
    rows: dict[str, list[tuple[str, np.ndarray, float]]] = defaultdict(list)
    for runs, last in zip(before, after, strict=True):
        every, figures = [list_figures(run) for run in runs], list_figures(last)
        for name, value in figures.items():
            if all(name in one for one in every):
                rows[name].append((str(last["target"]), np.array([one[name] for one in every]), value))
    return [_change(name, found) for name, found in rows.items()]


def _change(name: str, rows: list[tuple[str, np.ndarray, float]]) -> Change:
    means = np.array([runs.mean() for _, runs, _ in rows])
    ends = np.array([value for _, _, value in rows])
    runs = len(rows[0][1])
    if runs > 1:
        # The mean of some runs and the one of the other commit scatter alike, each on its own.
        variances = np.array([one.var(ddof=1) for _, one, _ in rows])
        error = float(np.sqrt(variances.sum() * (1.0 + 1.0 / runs)) / len(rows))
    else:
        error = float((ends - means).std(ddof=1) / np.sqrt(len(rows))) if len(rows) > 1 else float("inf")
    left = []
    for target, one, value in rows:
        reach = OUTSIDE * np.ptp(one)
        if runs > 1 and not one.min() - reach <= value <= one.max() + reach:
            left.append(f"{target} {one.mean():.4g} -> {value:.4g}")
    return Change(name, float(means.mean()), float(ends.mean()), error, len(rows), tuple(left))


def format_changes(changes: Iterable[Change]) -> list[str]:
    """Return the changes as a table of Markdown, and below it single figures that left their range."""
    lines = ["| figure | targets | before | after | change | standard error | |", "|---|---|---|---|---|---|---|"]
    changes = list(changes)
    for one in changes:
        rise = one.after - one.before
        share = f"{100.0 * rise / one.before:+.1f} %" if one.before else f"{rise:+.3g}"
        word = "**worse**" if one.is_worse else ""
        lines.append(
            f"| {one.name} | {one.count} | {one.before:.4g} | {one.after:.4g} | {share} | {one.error:.2g} | {word} |"
        )
    for one in changes:
        if one.left and one.name not in COSTS:
            lines.append(f"\nOutside of its own range, {one.name}: {'; '.join(one.left)}")
    return lines


def format_verdicts(before: Iterable[Line], after: Iterable[Line]) -> list[str]:
    """Return a line for each target whose verdict, category, cut or outfit is another one."""
    found = []
    for one, other in zip(before, after, strict=True):
        old, new = list_verdicts(one), list_verdicts(other)
        for name in sorted({*old, *new}):
            if old.get(name) != new.get(name):
                found.append(f"- {other['target']}: {name} {old.get(name)!r} -> {new.get(name)!r}")
    return found or ["No verdict changed."]
