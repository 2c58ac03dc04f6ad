"""The end of a recovery: what is measured of it, how it is judged, and the manifest that reproduces it."""

from __future__ import annotations

import platform
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from ..body.body_tape import tabulate_body
from ..garment.contour_edges import name_open_edges
from ..garment.pieces.numbers import measure_pieces
from ..judge.contour_shape import measure_contour_shapes
from ..judge.edge_lengths import find_length_differences
from ..judge.estimates import summarise_estimates
from ..judge.fairness import measure_fairness
from ..judge.fit import Reference, measure_fit, measure_mesh
from ..judge.gates import evaluate_gates
from ..judge.line_intervals import LineInterval, has_sure_lines, measure_intervals
from ..judge.patterns import measure_seams
from ..judge.plausibility import measure_plausibility
from ..judge.seen import find_seen_faces, measure_inferred_area
from ..judge.wear import measure_sides, measure_upright, measure_wear
from ..run.clock import Clock
from ..run.finding import FindingKind
from ..run.report import Metrics, ResultReport
from ..scan.contours.body_mismatch import find_misfit_warnings
from ..scan.contours.target import mark_hidden_border
from .case import Case
from .grade.cut_name import describe_cut_change, name_recovered
from .line_evidence import find_line_evidence
from .recovery import Recovery
from .settings import LATER
from .state import RecoveryState, made

PACKAGES = ("garmentq", "torch", "numpy", "scipy", "numba", "trimesh", "libigl")
"""The packages whose versions decide the digits of a result; the manifest names them."""

MANIFEST_FINDING_KINDS = {
    "candidates": FindingKind.CUT, "openings": FindingKind.OPENING, "panel_changes": FindingKind.PANEL_CHANGE,
    "proved_corners": FindingKind.CORNER, "choices": FindingKind.CHOICE,
}  # fmt: skip
"""Names in the manifest under which findings stand."""

SHOWN_FINDING_KINDS = (FindingKind.NOTE, FindingKind.PANEL_CHANGE, FindingKind.CORNER)
"""Findings that are warnings, in the order in which a result shows them."""


REDRAPE_MISSING = "redrape_missing"
"""Name of the metric, 1, of a result whose method re-drapes the pattern, and for which that was not done."""


@dataclass(frozen=True, kw_only=True)
class UnfinishedRecovery(Recovery):
    """Describe the result of a recovery whose re-drape was left for later, with what `pipeline.finish` starts from."""

    case: Case
    state: RecoveryState


def deliver(case: Case, state: RecoveryState, clock: Clock, known: Metrics | None = None) -> Recovery:
    """Measure and judge a finished state, and return it as the result; `known` metrics, as they were before its
    re-drape, are not measured again."""
    garment, settings, last = made(state.garment), case.settings, state
    garment = replace(garment, pattern=name_open_edges(garment))
    state = state.with_findings(*(corner.describe() for corner in state.corners))
    omissions = [one.describe() for one in case.undeclared or () if one.is_off_body]
    omissions += find_misfit_warnings(case.scan.vertices, case.body)
    with clock.stage("measure", "measuring the result"):
        pieces = measure_pieces(garment.pattern)
        measured = measure(case, state) if known is None else measure_redrape(case, state, known)
        metrics = {**measured, **pieces.metrics}
        cut = state.template
        if case.request.template is None:
            cut = name_recovered(garment.pattern, cut, state.body, settings.chosen_parts)
    messages = [one.message for kind in SHOWN_FINDING_KINDS for one in state.findings if one.kind is kind]
    seen = find_seen_faces(garment, case.scan.surface)
    gates = evaluate_gates(metrics)
    lines: tuple[LineInterval, ...] = ()
    if has_sure_lines(gates):
        lines = measure_intervals(garment.pattern, find_line_evidence(garment, case.scan_target, state.body, seen))
    hanging = made(state.meshes).drape_on_scan
    messages += find_length_differences(garment, hanging, case.scan_target, lines)
    warnings = (*omissions, *case.scan.repairs, *messages, *describe_cut_change(cut, state.template))
    manifest = describe(case, state) | {"cut": cut, "lines": [line.describe() for line in lines]}
    manifest["inferred"] = {name: round(share, 3) for name, share in measure_inferred_area(garment, seen).items()}
    for name, kind in MANIFEST_FINDING_KINDS.items():
        manifest[name] = [one.evidence for one in state.findings if one.kind is kind]
    found = Recovery(
        scan=case.scan,
        body=state.body,
        target=case.scan_target,
        template=state.template,
        pattern=garment.pattern,
        fabric=state.fabric,
        garment=garment,
        meshes=made(state.meshes),
        report=ResultReport.of(clock, metrics, gates, warnings, manifest),
        estimates=state.estimates,
        nearest_fabrics=state.nearest,
        point_std=state.point_std,
        rotation=made(state.drape).rotation,
        pieces=pieces.pieces,
        seen=seen,
    )
    is_finished = REDRAPE_MISSING not in metrics or settings.redrape != LATER
    return found if is_finished else UnfinishedRecovery(**vars(found), case=case, state=last)


def measure(case: Case, state: RecoveryState) -> Metrics:
    """Measure all meshes against the scan, the truth that the user gave, and what the fit knows."""
    garment, meshes, body, seed = made(state.garment), made(state.meshes), state.body, case.settings.seed
    metrics = summarise_estimates(state.estimates, state.point_std)
    for name, equilibrium in (("drape", state.drape), ("sim", state.simulated), ("redrape", state.redrape)):
        if equilibrium is not None:
            metrics |= equilibrium.measure(name)
    metrics |= measure_fit(garment, meshes, make_reference(case, state)) | measure_seams(garment.pattern)
    proved = {corner.join: corner.angle for corner in state.corners}
    metrics |= measure_fairness(garment.pattern, state.base, proved) | measure_plausibility(garment.pattern)
    metrics |= measure_contour_shapes(garment, meshes.drape_on_scan, case.scan_target, body)
    metrics |= measure_wear(state.target, body, meshes.detail, garment.faces, seed) | measure_upright(case.scan_target)
    metrics |= tabulate_body(body)
    cuts = [one for one in state.findings if one.kind is FindingKind.CUT]
    names = ("cut.misfit", "cut.next_misfit", "cut.third_misfit")
    metrics |= {name: one.value for name, one in zip(names, cuts, strict=False)}
    if cuts:
        metrics["cut.collar_probability"] = cuts[0].evidence.get("collar_probability")
    rotation = made(state.drape).rotation
    metrics["drape.spin_rad_s"] = 0.0 if rotation is None else rotation.rate
    metrics |= measure_sides(meshes.detail, garment.contours, body) if state.base.symmetric else {}
    metrics["inferred_ends"] = float(sum(one.hidden and one.is_limb_end for one in case.scan_target.contours))
    metrics["body.fit_rms_mm"] = 1e3 * body.fit_rms
    if meshes.simulation is not None and meshes.redraped is None:
        metrics[REDRAPE_MISSING] = 1.0
    if case.undeclared is not None:
        metrics["body.undeclared_mm"] = 1e3 * max((one.offset for one in case.undeclared), default=0.0)
    return metrics


def measure_redrape(case: Case, state: RecoveryState, known: Metrics) -> Metrics:
    """Return known metrics with those of the re-draped mesh, which `measure` measures in the same way."""
    nodes, before = made(made(state.meshes).redraped), {name: known[name] for name in known if name != REDRAPE_MISSING}
    found = measure_mesh(made(state.garment), nodes, make_reference(case, state))
    return before | made(state.redrape).measure("redrape") | {f"redrape.{name}": found[name] for name in found}


def make_reference(case: Case, state: RecoveryState) -> Reference:
    """Return what meshes are measured against: the scan."""
    scan, contours = case.scan, case.scan_target.contours_of_scan()
    hidden = mark_hidden_border(scan.faces, scan.hidden, contours)
    seed = case.settings.seed
    return Reference(scan.surface, contours, state.wearer.exposed, seed, hidden=hidden)


def describe(case: Case, state: RecoveryState) -> dict[str, Any]:
    """Return what reproduces the result: versions, hashes, settings and what was understood of the input."""
    scan, body = case.scan, state.body
    return {
        "versions": {name: _version(name) for name in PACKAGES} | {"python": platform.python_version()},
        "scan": {"name": scan.name, "sha256": scan.sha256, "units": scan.units, "up": scan.up_axis},
        "body": {"source": body.source, "fit_rms_m": float(np.round(body.fit_rms, 6))},
        "template": state.template,
        "category": state.target.category,
        "fitted_faces": len(state.target.faces),
        "settings": case.settings.as_dict(),
    }


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
