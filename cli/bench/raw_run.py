"""The raw packs of a bench: each scan of a dressed person is segmented, and its garments are recovered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .lines import Line
from .process import run_in_process
from .raw_target import RawOrder, empty_line
from .table import mean, round_to_three_digits

if TYPE_CHECKING:
    from .raw_packs import RawPack

STATE_NAMES = ("as_is", "noise_5mm", "holes_10", "no_colours", "decimated_10k", "cloud_50k")
"""The states of a raw scan, listed here so that the options need not import the module that creates them."""

COLUMNS = (
    ("cloth IoU", "labels.cloth_iou"),
    ("mean IoU", "labels.mean_iou"),
    ("border", "border.median_mm"),
    ("95 %", "border.p95_mm"),
    ("body cloth", "body.covered.mean_mm"),
    ("body bare", "body.bare.mean_mm"),
    ("ECE", "calibration.error"),
    ("sure", "calibration.sure"),
    ("right", "calibration.sure_right"),
    ("CPU s", "cpu_seconds"),
    ("MB", "peak_mb"),
)
"""Columns of the table of scans; distances in mm."""


@dataclass(frozen=True)
class RawChoice:
    """Describe how raw packs are run; fields as in `RawOrder`.

    Attributes:
        states: Names of the states into which each scan is brought.
        timeout: Time limit of each run [s].
    """

    method: str
    preset: str
    shipped: bool
    out: str | None
    states: tuple[str, ...]
    labels_only: bool
    true_labels: bool
    timeout: float


def run_raw_packs(packs: Sequence[RawPack], choice: RawChoice, as_json: bool) -> list[Line]:
    """Run raw packs in all states, one process each; print lines or tables."""
    from ..terminal import print_json, print_note

    lines: list[Line] = []
    runs = [(state, pack) for state in choice.states for pack in packs]
    for index, (state, pack) in enumerate(runs, start=1):
        line = run_raw_pack(pack, order_of(pack, state, choice), choice.timeout)
        lines.append(line)
        print_note(f"[{index}/{len(runs)}] {summarise(line)}")
        if as_json:
            print_json(line)
    if lines and not as_json:
        print_raw_tables(lines)
    return lines


def order_of(pack: RawPack, state: str, choice: RawChoice) -> RawOrder:
    """Return the order of one run."""
    return RawOrder(
        pack=str(pack.folder.resolve()),
        method=choice.method,
        preset=choice.preset,
        shipped=choice.shipped,
        out=choice.out,
        state=state,
        labels_only=choice.labels_only,
        true_labels=choice.true_labels,
    )


def run_raw_pack(pack: RawPack, order: RawOrder, timeout: float) -> Line:
    """Run one raw pack in a process of its own, and return its line in every case."""
    line = empty_line(pack.name, order) | {"outcome": "failed"}
    return run_in_process("raw_target", order, line, timeout)


def summarise(line: Line) -> str:
    """Return the outcome of a run as one line."""
    name = line["target"] + ("" if line["state"] == STATE_NAMES[0] else f" ({line['state']})")
    if line["error"]:
        return f"{name}: {line['outcome']}: {line['error']['code']}: {line['error']['message']}"
    words = [line["outcome"], *line["outfit"], *([line["problem"]] if line["problem"] else [])]
    figures = [f"{title} {value:.3g}" for title, value in zip_columns(line) if value is not None]
    return f"{name}: {' '.join(words)}; {', '.join(figures)}"


def zip_columns(line: Line) -> list[tuple[str, float | None]]:
    """Return the figures of `COLUMNS` with their titles."""
    return [(title, pick(line, path)) for title, path in COLUMNS]


def pick(line: Line, path: str) -> Any:
    """Return the value of a line at a dotted path, or None."""
    found: Any = line
    for name in path.split("."):
        found = found.get(name) if isinstance(found, dict) else None
    return found


def print_raw_tables(lines: Sequence[Line]) -> None:
    """Print the scans, the garments, and the number of runs by outcome."""
    from ..terminal import print_table

    rows: list[list[object]] = []
    for line in lines:
        code = line["error"]["code"] if line["error"] else line["problem"]
        rows.append(
            [
                line["target"],
                line["state"],
                line["outcome"],
                code,
                *round_to_three_digits([v for _, v in zip_columns(line)]),
            ]
        )
    means = round_to_three_digits([mean([pick(line, path) for line in lines]) for _, path in COLUMNS])
    rows.append(["mean", None, None, None, *means])
    columns = ["scan", "state", "outcome", "code", *(title for title, _ in COLUMNS)]
    print_table(columns, rows, title="Raw scans (distances in mm)")
    garments = [(line, each) for line in lines for each in line["garments"]]
    shown = ("s2t_mm", "t2s_mm", "pattern.panel_area_error", "pattern.panel_area_error_all", "cpu_seconds")
    cells = [
        [line["target"], line["state"], each["part"], each["category"] or each["found_category"],
         each["error"]["code"] if each["error"] else None, *round_to_three_digits([pick(each, path) for path in shown])]
        for line, each in garments
    ]  # fmt: skip
    if cells:
        means = round_to_three_digits([mean([pick(each, path) for _, each in garments]) for path in shown])
        cells.append(["mean", *[None] * 4, *means])
        columns = ["scan", "state", "garment", "category", "error", "s2t", "t2s", "area", "area, all", "CPU s"]
        print_table(columns, cells, title="Garments (mm to the visible truth)")
    counts = [[name, sum(line["outcome"] == name for line in lines)] for name in OUTCOMES]
    print_table(["outcome", "runs"], counts)


OUTCOMES = ("right", "doubtful", "refused", "wrong", "failed")
"""Possible outcomes of a run; `failed` is a fault of garmentq."""
