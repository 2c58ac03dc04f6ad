"""Rows of a garment's result: wearer, fabric, pattern and metrics, the same for every kind that has one."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from sqlalchemy.orm import Session

from ..database import take_advisory_lock
from ..listed import read_listed_costs
from ..models import BodyRow, JobRow, MaterialRow, MetricRow, PanelRow, PatternRow, PieceRow

if TYPE_CHECKING:
    from ...core.body.body import Body
    from ...core.cloth.fabric import Fabric
    from ...core.garment.pattern import Pattern
    from ...core.garment.pieces.numbers import PieceNumbers
    from ...core.run.report import ResultReport


def describe_body(job: str, body: Body) -> BodyRow:
    """Return the row of a wearer as a job estimated it."""
    import numpy as np

    from ...core.body.body import JOINTS

    joints = {name: position.tolist() for name, position in zip(JOINTS, body.joints, strict=True)}
    parameters = {name: np.asarray(value).tolist() for name, value in body.parameters.items()}
    return BodyRow(job=job, source=body.source, fit_rms=float(body.fit_rms), joints=joints, parameters=parameters)


def _add_material(session: Session, fabric: Fabric) -> str:
    values = asdict(fabric)
    values["sources"] = [list(pair) for pair in fabric.sources]
    key = hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()
    take_advisory_lock(session, key)  # two workers may be the first to use a fabric
    if session.get(MaterialRow, key) is None:
        session.add(MaterialRow(id=key, **values))
    return key


def add_pattern(session: Session, job: str, pattern: Pattern, fabric: Fabric, names: tuple[str, str]) -> None:
    """Add the rows of a pattern, its panels and its fabric.

    Args:
        session: The transaction.
        job: Id of the job.
        pattern: The pattern.
        fabric: The fabric.
        names: The garment's category, and the name of its base pattern.
    """
    from ...core.garment.polygon import polygon_area

    category, template = names
    material = _add_material(session, fabric)
    session.flush()
    session.add(
        PatternRow(
            job=job,
            name=pattern.name,
            category=category,
            template=template,
            material=material,
            seams=len(pattern.seams),
        )
    )
    session.flush()
    for panel in pattern.panels:
        edges = [{"kind": e.kind, "handles": e.handles.tolist(), "contour": e.contour} for e in panel.edges]
        points, area = panel.points.tolist(), polygon_area(panel.points)
        session.add(PanelRow(job=job, name=panel.name, label=panel.label, points=points, edges=edges, area=area))


def add_pieces(session: Session, job: str, pieces: Iterable[PieceNumbers]) -> None:
    """Add the rows of a job's production pieces."""
    for one in pieces:
        session.add(PieceRow(job=job, **vars(one)))


def add_metrics(session: Session, job: str, metrics: Mapping[str, float | None]) -> None:
    """Add the rows of a job's metrics."""
    for name, value in metrics.items():
        session.add(MetricRow(job=job, name=name, value=keep_finite(value)))


def show_garment(session: Session, job: str) -> dict[str, Any]:
    """Return a job's garment, template, fabric and body by name, None where it has none."""
    pattern, body = session.get(PatternRow, job), session.get(BodyRow, job)
    material = session.get(MaterialRow, pattern.material) if pattern else None
    return {
        "garment": pattern.category if pattern else None,
        "template": pattern.template if pattern else None,
        "fabric": material.name if material else None,
        "body": body.source if body else None,
    }


def list_result(session: Session, job: str) -> None:
    """Copy what the rows of a job's result say into its own."""
    session.flush()
    row = session.get_one(JobRow, job, populate_existing=True)
    for name, value in {**show_garment(session, job), **read_listed_costs(row.result or {})}.items():
        setattr(row, name, value)


def summarise(report: ResultReport) -> dict[str, Any]:
    """Return a result's verdicts, warnings, cost and manifest as JSON values for its job's row."""
    return {
        "gates": [
            {**asdict(gate), "value": keep_finite(gate.value), "limit": keep_finite(gate.limit)}
            for gate in report.gates
        ],
        "warnings": list(report.warnings),
        "stage_seconds": {name: round(value, 3) for name, value in report.stage_seconds.items()},
        "cpu_seconds": round(report.cpu_seconds, 3),
        "peak_mb": round(report.peak_mb, 1),
        "manifest": json.loads(json.dumps(report.manifest, default=str)),
    }


def keep_finite(value: float | None) -> float | None:
    """Return a number that every database can store, or None."""
    return None if value is None or not math.isfinite(value) else float(value)
