"""`garmentq bench`: recover target packs and compare the results with their truth."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .. import exits
from ..options import gather, json_option, method_options
from ..output import NewFolder
from .lines import Line
from .process import one_thread, run_in_process
from .raw_run import STATE_NAMES, RawChoice, run_raw_packs
from .target import TargetOrder, empty_line

if TYPE_CHECKING:
    from .packs import Pack

BENCH_TARGET_TIMEOUT = 1800.0
"""Time limit of one target [s]: thirty times the usual time of a recovery, so that only one that hangs is stopped."""


@dataclass(frozen=True)
class BenchOptions:
    """Describe the options of a bench; each field is the option of its name."""

    method: str
    preset: str
    only: tuple[str, ...]
    shipped: bool
    damage: bool
    ablate: bool
    out: Path | None
    timeout: float
    labels_only: bool
    true_labels: bool
    states: bool
    state: tuple[str, ...]
    whole: bool


bench_options = gather(
    BenchOptions,
    [
        *method_options(),
        click.option("--only", multiple=True, metavar="NAME", help="Run only this pack; may be repeated."),
        click.option("--library", "shipped", is_flag=True, help="Use the shipped templates, not the packs' own."),
        click.option("--damage", is_flag=True, help="Damage each target in ten ways and compare with the clean truth."),
        click.option("--ablate", is_flag=True, help="Switch off one part of inverse loop or deformer at a time."),
        click.option("--out", type=NewFolder(), help="Keep each result in OUT/TARGET/."),
        click.option(
            "--timeout",
            type=click.FloatRange(min=1.0),
            default=BENCH_TARGET_TIMEOUT,
            show_default=True,
            help="Time limit of a target [s].",
        ),
        click.option("--labels-only", is_flag=True, help="Raw scans: stop after the labelling."),
        click.option("--true-labels", is_flag=True, help="Raw scans: use the true labels."),
        click.option("--states", is_flag=True, help="Raw scans: with noise, holes, no colours, ...; labels only."),
        click.option(
            "--state",
            multiple=True,
            type=click.Choice(STATE_NAMES),
            help="Raw scans: only this state; may be repeated.",
        ),
        click.option("--whole", is_flag=True, help="Raw scans: also recover the garments of each state."),
    ],
)


@click.command("bench")
@click.argument("directory", type=click.Path(exists=True, file_okay=False, path_type=Path))
@bench_options
@json_option
@click.pass_context
def command(context: click.Context, directory: Path, options: BenchOptions, as_json: bool) -> None:
    """Recover every target pack in a folder and compare with the truth.

    A pack is a folder with meta.json, garment.ply, body.ply and perhaps template.json and pattern.json; or a raw pack:
    scan.ply, the scan of a dressed person, and truth/ (docs/reference/files.md).

    Each target runs in a process of its own. The exit status is 5 if any target failed, or if a person's outfit is
    wrong without a warning. With --damage each target is recovered under noise, holes, outliers, flipped faces, a cut
    hem, other units and axes, with both presets. With --ablate the inverse loop runs without curvature weights, seam
    loss or materials, and the deformer without grading, contours, normals or bending, one at a time, beside the thesis'
    tables 3.4 and 4.3.

    \b
    Example:
      garmentq bench targets
      garmentq bench targets --only gc_skirt2 --out results --json
      garmentq bench targets --only gc_skirt2 --damage
      garmentq bench targets --only gc_skirt2 --only gpg_tee --ablate
    """
    from ..terminal import print_json, print_note
    from .packs import read_packs
    from .raw_packs import read_raw_packs
    from .table import print_tables

    packs, raw_packs = read_packs(directory, options.only), read_raw_packs(directory, options.only)
    if options.damage or options.ablate:
        study = _DAMAGE if options.damage else _ABLATION
        context.exit(_study(study, packs, options.preset, options.timeout, as_json))
    lines: list[Line] = []
    out = str(options.out.resolve()) if options.out else None
    raw_lines = run_raw_packs(raw_packs, _raw_choice(options, out), as_json)
    for index, pack in enumerate(packs, start=1):
        order = TargetOrder(str(pack.folder.resolve()), options.method, options.preset, options.shipped, out)
        line = run_target(pack, order, options.timeout)
        lines.append(line)
        print_note(f"[{index}/{len(packs)}] {_summary(line)}")
        if as_json:
            print_json(line)
    if not as_json and lines:
        print_tables(lines, {pack.name: pack.category for pack in packs})
    misled = any(line["outcome"] == "wrong" for line in raw_lines)
    failed = misled or any(not line["ok"] for line in [*lines, *raw_lines])
    context.exit(exits.FAILED if failed else exits.OK)


def _raw_choice(options: BenchOptions, out: str | None) -> RawChoice:
    """Return how raw packs are run: unchanged and completely, or in some states up to the labels."""
    states = options.state or (STATE_NAMES[1:] if options.states else STATE_NAMES[:1])
    is_study = options.states or bool(options.state)
    return RawChoice(
        method=options.method,
        preset=options.preset,
        shipped=options.shipped,
        out=out,
        states=states,
        labels_only=options.labels_only or (is_study and not options.whole),
        true_labels=options.true_labels,
        timeout=options.timeout,
    )


def run_target(pack: Pack, order: TargetOrder, timeout: float) -> Line:
    """Run one target in a process of its own, and return its line in every case."""
    return run_in_process("target", order, empty_line(pack.name, order.method), timeout)


@dataclass(frozen=True)
class _Study:
    """Describe a study that runs each pack many times.

    Attributes:
        module: Module that runs one pack: ORDER.json in, LINES.jsonl out.
        runs: How often it recovers the pack: the time limit is for one.
    """

    module: str
    runs: int


_DAMAGE = _Study("damage_run", 22)  # eleven states of the target with two presets
_ABLATION = _Study("ablation", 9)  # the rows of both tables


def _study(study: _Study, packs: tuple[Pack, ...], preset: str, timeout: float, as_json: bool) -> int:
    """Run a study on the packs that are a garment with a body, and print it."""
    from ..terminal import print_json, print_note
    from . import ablation, damage_run

    lines: list[Line] = []
    for pack in packs:
        if pack.body is None:
            print_note(f"{pack.name}: skipped, it is a dressed person's scan")
            continue
        order = {"pack": str(pack.folder.resolve())} | ({"preset": preset} if study is _ABLATION else {})
        found, error = _run_study(study, order, timeout)
        if error is not None:
            no_line = damage_run.empty_line(pack.name, "study", "default")
            found.append((no_line if study is _DAMAGE else ablation.empty_line(pack.name)) | {"error": error})
        lines += found
        for line in found:
            if as_json:
                print_json(line)
    if not as_json and lines:
        (damage_run.print_study if study is _DAMAGE else ablation.print_ablation)(lines)
    return exits.OK if lines and all(line["ok"] for line in lines) else exits.FAILED


def _run_study(study: _Study, order: dict[str, str], timeout: float) -> tuple[list[Line], dict[str, str] | None]:
    """Run a study of one pack in a process of its own; return its lines, and the error if it did not finish."""
    with tempfile.TemporaryDirectory(prefix="garmentq-study-") as folder:
        order_file, lines, log = (Path(folder) / name for name in ("order.json", "lines.jsonl", "log.txt"))
        order_file.write_text(json.dumps(order), encoding="utf-8")
        process = [sys.executable, "-m", f"garmentq.cli.bench.{study.module}", str(order_file), str(lines)]
        error = None
        try:
            with log.open("wb") as out:
                ended = subprocess.run(process, stdout=out, stderr=out, timeout=study.runs * timeout, env=one_thread())
            if ended.returncode != 0:
                words = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
                message = ": ".join([f"the process ended with status {ended.returncode}", *words[-1:]])
                error = {"code": "bench.crashed", "message": message}
        except subprocess.TimeoutExpired:
            error = {
                "code": "bench.timed_out",
                "message": f"stopped after {study.runs * timeout:.0f} s; raise --timeout.",
            }
        written = lines.read_text(encoding="utf-8").splitlines() if lines.exists() else []
        return [json.loads(line) for line in written], error


def _summary(line: Line) -> str:
    """Return the outcome of a target as one line."""
    if not line["ok"]:
        error = line["error"] or {}
        return f"{line['target']}: {error.get('code')}: {error.get('message')}"
    metrics = line["metrics"]
    s2t, t2s = metrics["surface_rms_mm.s2t"], metrics["surface_rms_mm.t2s"]
    return f"{line['target']}: {line['category']}, {s2t:.2f} / {t2s:.2f} mm, {line['cpu_seconds']:.0f} s"
