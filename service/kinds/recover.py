"""The kind `recover`: a garment's scan becomes a pattern, a fabric and meshes."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from sqlalchemy.orm import Session

from ...core.recovery import STAGES
from ..database import serialise
from ..jobs import Claim
from ..models import BodyRow, JobRow, MaterialRow, MetricRow, PanelRow, PatternRow, ScanRow
from .kind import Kind, Outcome, Turned, Work
from .person_request import make_person
from .recover_request import AS_PERSON, PERSON, READING, TOLD, RecoverRequest
from .request import pack_request

if TYPE_CHECKING:
    from ...core.body import Body
    from ...core.hooks import Hooks
    from ...core.recovery import Recovery, Request
    from ...core.simulate import Fabric
    from ..settings import ServiceSettings


class Recover(Kind):
    """Recover a garment's pattern, fabric and meshes from its scan."""

    name = "recover"
    request = RecoverRequest
    stages = ("check", *STAGES)

    def checker(self, settings: ServiceSettings) -> str:
        """Return the reader of scans, bodies, labels and patterns."""
        return settings.checker

    def choose_input(self, request: RecoverRequest, name: str) -> tuple[str, ...]:
        """Return the reading of the garment, and what says how sure it is; no other garment's, picture or report."""
        return (f"{request.part}/{READING}", TOLD) if name == PERSON and request.part is not None else ()

    def run(self, request: RecoverRequest, work: Work, hooks: Hooks) -> Recovery:
        """Run the pipeline and write its files."""
        person = work.inputs.get(PERSON)
        recovery: Recovery = work.settings.find("pipeline")(request.unpack(work.files, person), hooks)
        if request.part is not None and person is not None:
            recovery.metrics["confidence"] = _read_confidence(person, request.part)
        work.settings.find("writer")(recovery, work.out)
        return recovery

    def turn(self, request: RecoverRequest, work: Work, hooks: Hooks) -> Turned | None:
        """Return a person's job where the scan shows its wearer's head, hands or feet, or its labels name parts."""
        if request.part is not None or not request.is_open:
            return None
        if (work.files / AS_PERSON).exists() or _is_person(request.unpack(work.files), hooks):
            return Turned("person", pack_request(make_person(request)))
        return None

    def store(self, session: Session, claim: Claim, result: Recovery) -> Outcome:
        """Add the rows of pattern, panels, fabric, wearer and metrics."""
        _add_scan(session, result)
        session.add(describe_body(claim.job, result.body))
        material = _add_material(session, result.fabric)
        session.flush()
        _add_pattern(session, claim.job, result, material)
        for name, value in result.metrics.items():
            session.add(MetricRow(job=claim.job, name=name, value=keep_finite(value)))
        return Outcome(_summary(result))

    def show(self, session: Session, row: JobRow) -> dict[str, Any]:
        """Return garment, template, fabric and body by name."""
        pattern = session.get(PatternRow, row.id)
        material = session.get(MaterialRow, pattern.material) if pattern else None
        body = session.get(BodyRow, row.id)
        return {
            "garment": pattern.category if pattern else None,
            "template": pattern.template if pattern else None,
            "fabric": material.name if material else None,
            "body": body.source if body else None,
        }


def _read_confidence(person: Path, part: str) -> float | None:
    """Return how sure it is that a garment's points are its own, as the job that took the person apart wrote it."""
    told = json.loads((person / TOLD).read_text(encoding="utf-8"))
    return next((one["confidence"] for one in told["garments"] if one["part"] == part), None)


def _is_person(request: Request, hooks: Hooks) -> bool:
    """Return whether a scan that was read with its wearer shows the whole person."""
    reading = request.reading
    if reading is None or request.body is None or request.labels is not None:
        return False
    from ...core.person.whole import shows_person, stands_tall
    from ...core.pipeline import find_body

    if not stands_tall(reading.pieces.garment, reading.pieces.wearer):
        return False
    return shows_person(reading.pieces.garment, find_body(request, reading.pieces, hooks))


def _add_scan(session: Session, recovery: Recovery) -> None:
    row = session.get(ScanRow, recovery.scan.sha256) if recovery.scan.sha256 else None
    if row is not None:
        scan = recovery.scan
        row.details = {
            "units": scan.units,
            "up_axis": scan.up_axis,
            "vertices": len(scan.vertices),
            "faces": len(scan.faces),
            "repairs": list(scan.repairs),
            "contours": {c.name: c.length for c in recovery.target.contours},
        }


def describe_body(job: str, body: Body) -> BodyRow:
    """Return the row of a wearer as a job saw it."""
    from ...core.body import JOINTS

    joints = {name: position.tolist() for name, position in zip(JOINTS, body.joints, strict=True)}
    parameters = {name: np.asarray(value).tolist() for name, value in body.parameters.items()}
    return BodyRow(job=job, source=body.source, fit_rms=float(body.fit_rms), joints=joints, parameters=parameters)


def _add_material(session: Session, fabric: Fabric) -> str:
    values = asdict(fabric)
    values["sources"] = [list(pair) for pair in fabric.sources]
    key = hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()
    serialise(session, key)  # two workers may be the first to use a fabric
    if session.get(MaterialRow, key) is None:
        session.add(MaterialRow(id=key, **values))
    return key


def _add_pattern(session: Session, job: str, recovery: Recovery, material: str) -> None:
    from ...core.pattern import polygon_area

    pattern = recovery.pattern
    category = pattern.category or recovery.target.category
    session.add(
        PatternRow(
            job=job,
            name=pattern.name,
            category=category,
            template=recovery.template,
            material=material,
            seams=len(pattern.seams),
        )
    )
    session.flush()
    for panel in pattern.panels:
        edges = [{"kind": e.kind, "handles": e.handles.tolist(), "contour": e.contour} for e in panel.edges]
        points, area = panel.points.tolist(), polygon_area(panel.points)
        session.add(PanelRow(job=job, name=panel.name, label=panel.label, points=points, edges=edges, area=area))


def _summary(recovery: Recovery) -> dict[str, Any]:
    return {
        "gates": [
            {**asdict(gate), "value": keep_finite(gate.value), "limit": keep_finite(gate.limit)}
            for gate in recovery.gates
        ],
        "warnings": list(recovery.warnings),
        "stage_seconds": {name: round(value, 3) for name, value in recovery.stage_seconds.items()},
        "cpu_seconds": round(recovery.cpu_seconds, 3),
        "peak_mb": round(recovery.peak_mb, 1),
        "manifest": json.loads(json.dumps(recovery.manifest, default=str)),
    }


def keep_finite(value: float | None) -> float | None:
    """Return a number that every database can keep, or None."""
    return None if value is None or not math.isfinite(value) else float(value)
