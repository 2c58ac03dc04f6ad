"""Show a job's result: ten lines a garment, or all its numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import click

from ..core.run.errors import keep_printable
from ..service.order import PERSON
from ..service.records import Gate, JobReport, Redrape, RedrapeState
from .person_summary import describe_person
from .terminal import format_cell, print_table, show_time

FIRST_METRICS = (
    "surface_rms_mm.s2t", "surface_rms_mm.t2s", "graded.surface_rms_mm.s2t", "graded.surface_rms_mm.t2s",
    "hausdorff_mm", "normal_cosine", "body_penetration_mm", "seam_mismatch_mm", "flipped_faces",
    "self_intersecting_faces",
)  # fmt: skip
"""Metrics that are listed first; the others follow by name."""

FIRST_FILES = ("report.html", "pattern.svg", "detail.ply", "labels.npz")
"""Result files to open first: pictures and verdicts, the pattern at true scale, the mesh on the scan; of a person the
labels, which can be corrected."""

PREFIXES = (("", "detail mesh"), ("sim.", "simulation mesh"), ("redrape.", "re-draped pattern"))
"""Prefixes of the metrics of the delivered meshes, and the meshes' names in the summary."""

REST_NOTES = {1.0: ", at rest", 0.0: ", not at rest"}
"""Text of the summary for a drape's metric `at_rest`; none for meshes that are not drapes, and for older results."""


def print_result(job: JobReport, files: Sequence[Path], verbose: bool = False) -> None:
    """Print a job's result: ten lines, or with `verbose` all metrics, gates, warnings and files as tables."""
    if verbose:
        print_tables(job, files)
        return
    click.echo(keep_printable(f"{job.garment or job.kind} (job {job.id})"))
    for title, text in summarise(job, files):
        click.echo(f"  {title:<10} {keep_printable(text)}")


def summarise(job: JobReport, files: Sequence[Path]) -> Iterator[tuple[str, str]]:
    """Yield the lines of a summary as title and text: the result, its quality, and the files to open next."""
    if job.kind == PERSON:
        yield from describe_person(job)
    else:
        yield from _describe_garment(job) if job.garment is not None else _describe_details(job)
        yield "checks", _describe_gates(job.gates)
    if job.redrape is not None and job.redrape.state is not RedrapeState.DONE:
        yield "re-drape", _describe_redrape(job.redrape)
    warnings = job.warnings
    more = f" (and {len(warnings) - 1} more, see --verbose)" if len(warnings) > 1 else ""
    yield "warnings", f"{warnings[0]}{more}" if warnings else "none"
    yield "cost", f"{job.cpu_seconds or 0.0:.0f} s CPU, {job.peak_mb or 0.0:.0f} MB"
    names = {path.name: path for path in files if path.parent == files[0].parent}
    chosen = [str(names[name]) for name in FIRST_FILES if name in names] or [str(path) for path in files]
    yield "open", ", ".join(chosen) or f"garmentq export {job.id} --out DIR"


def _describe_garment(job: JobReport) -> Iterator[tuple[str, str]]:
    metrics: Mapping[str, float | None] = job.metrics
    yield "scan", f"{job.name}; wearer: {job.body or 'not known'}"
    yield "pattern", f"base pattern {job.template}, {_describe_count(metrics, 'vertices')} vertices in each mesh"
    yield "fabric", f"{job.fabric}; {_describe_bending(metrics)}"
    distances = "; ".join(_describe_distances(metrics))
    yield "surface", f"RMS to the scan / back: {distances}" if distances else "not measured"
    depths = "; ".join(_describe_depths(metrics))
    yield "body", f"depth inside it / crossing faces: {depths}" if depths else "not measured"


def _describe_details(job: JobReport) -> Iterator[tuple[str, str]]:
    """Yield the details of a job that is not a recovery, and the jobs that it made."""
    yield "name", job.name
    for name, value in job.details.items():
        yield name, format_cell(value)
    if job.children:
        yield "made", ", ".join(f"{child.name} ({child.job}, {child.state})" for child in job.children)


def print_tables(job: JobReport, files: Sequence[Path]) -> None:
    """Print a job's whole result as tables, then the paths of its files."""
    print_table(
        ["job", "scan", "verdict", "garment", "template", "fabric", "body", "CPU s", "peak MB", "ended"],
        [
            [
                job.id, job.name, job.verdict, job.garment, job.template, job.fabric, job.body,
                job.cpu_seconds, job.peak_mb, show_time(job.finished),
            ]
        ],
    )  # fmt: skip
    metrics = job.metrics
    names = [name for name in FIRST_METRICS if name in metrics] + [
        name for name in metrics if name not in FIRST_METRICS
    ]
    print_table(["metric", "value"], [[name, metrics[name]] for name in names if metrics[name] is not None])
    gates = job.gates
    if gates:
        rows = [[g.name, g.verdict, g.value, g.limit, g.message] for g in gates]
        print_table(["gate", "verdict", "value", "limit", ""], rows)
    if job.warnings:
        print_table(["warning"], [[text] for text in job.warnings])
    if files:
        print_table(["file", "path"], [[path.name, str(path)] for path in files])


def _describe_count(metrics: Mapping[str, float | None], name: str) -> str:
    value = metrics.get(name)
    return "unknown number of" if value is None else f"{value:.0f}"


def _describe_bending(metrics: Mapping[str, float | None]) -> str:
    """Return the bending stiffness with one standard deviation, or why there is none."""
    stiffness, std = metrics.get("fabric.k"), metrics.get("fabric.k.std")
    if "fabric.k.identifiable" not in metrics:
        return "its stiffness was not fitted"
    if not metrics["fabric.k.identifiable"] or stiffness is None or std is None:
        return "its bending stiffness is not identifiable from this scan"
    return f"bending stiffness {stiffness:.2g} N m, within a factor of {math.exp(std):.1f}"


def _describe_distances(metrics: Mapping[str, float | None]) -> Iterator[str]:
    for prefix, mesh in PREFIXES:
        ways = [metrics.get(f"{prefix}surface_rms_mm.{direction}") for direction in ("s2t", "t2s")]
        if ways[0] is not None and ways[1] is not None:
            at_rest = metrics.get(f"{prefix}at_rest")
            yield f"{mesh} {ways[0]:.1f} / {ways[1]:.1f} mm{'' if at_rest is None else REST_NOTES.get(at_rest, '')}"


def _describe_depths(metrics: Mapping[str, float | None]) -> Iterator[str]:
    for prefix, mesh in PREFIXES:
        depth = metrics.get(f"{prefix}body_penetration_mm")
        crossed = metrics.get(f"{prefix}self_intersecting_faces")
        if depth is not None:
            yield f"{mesh} {depth:.1f} mm / {crossed or 0:.0f}"


def _describe_redrape(redrape: Redrape) -> str:
    code = f" ({redrape.code})" if redrape.code else ""
    return f"{redrape.state}{code}" + (f", job {redrape.job}" if redrape.job else "")


def _describe_gates(gates: Sequence[Gate]) -> str:
    """Return how many checks passed, and the message of the worst other one."""
    if not gates:
        return "none"
    order = {"fail": 0, "doubtful": 1}
    others = sorted((gate for gate in gates if gate.verdict in order), key=lambda gate: order[gate.verdict])
    passed = f"{len(gates) - len(others)} of {len(gates)} passed"
    return f"{passed}; {others[0].verdict}: {others[0].message}" if others else passed
