"""A recovery's rows and files: how they get in, and how they come out."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from ..core.errors import NotFound
from .database import Database, clock, serialise
from .jobs import Claim, succeed, write_fenced
from .models import (
    ArtifactRow,
    BodyRow,
    JobRow,
    MaterialRow,
    MetricRow,
    PanelRow,
    PatternRow,
    ScanRow,
)
from .records import Artifact, JobReport
from .store import Store

if TYPE_CHECKING:
    from ..core.body import Body
    from ..core.recovery import Recovery
    from ..core.simulate import Fabric

JOBS_AT_ONCE = 500
"""Jobs of one question for what they found."""

RESULT = "result"
CHECKPOINT = "checkpoint"
PREVIOUS = "checkpoint.1"
"""The checkpoint before the newest of a name: kept for the case that the newest is damaged, no older one is."""


class ResultMissing(NotFound):
    """The job has no result; `garmentq status JOB` tells why."""

    code = "result.missing"


def store_recovery(database: Database, store: Store, claim: Claim, recovery: Recovery, folder: Path) -> None:
    """Keep the files first, then write all rows and end the job in one fenced transaction.

    A crash between the two leaves files that nobody names, which does no harm. Checkpoints are let go.

    Args:
        database: Where the rows go.
        store: Where the files go.
        claim: The right to write them.
        recovery: What was found.
        folder: Holds the files that were written for it; names below it are kept.

    Raises:
        FenceLost: where another worker has taken the job over; nothing is written then.
    """
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    files = [(path.relative_to(folder).as_posix(), store.put(path)) for path in paths]
    with database.write() as session:
        write_fenced(session, claim, touched=clock())
        for table in (PanelRow, PatternRow, BodyRow, MetricRow, ArtifactRow):
            session.execute(delete(table).where(table.job == claim.job))
        for name, kept in files:
            _add_artifact(session, claim.job, RESULT, name, kept.sha256, kept.size)
        _add_scan(session, recovery)
        session.add(_body_row(claim.job, recovery.body))
        material = _add_material(session, recovery.fabric)
        session.flush()
        _add_pattern(session, claim.job, recovery, material)
        for name, value in recovery.metrics.items():
            session.add(MetricRow(job=claim.job, name=name, value=_finite(value)))
        succeed(session, claim, _summary(recovery))


def save_checkpoint(database: Database, store: Store, claim: Claim, name: str, content: bytes) -> None:
    """Keep a stage's state; of each name the newest and the one before are kept.

    Raises:
        FenceLost: where another worker has taken the job over.
    """
    kept = store.put_bytes(content)
    with database.write() as session:
        write_fenced(session, claim, touched=clock())
        session.execute(delete(ArtifactRow).where(_named(claim.job, PREVIOUS, name)))
        session.execute(update(ArtifactRow).where(_named(claim.job, CHECKPOINT, name)).values(kind=PREVIOUS))
        _add_artifact(session, claim.job, CHECKPOINT, name, kept.sha256, kept.size)


def load_checkpoint(database: Database, store: Store, job: str, name: str, kind: str = CHECKPOINT) -> bytes | None:
    """Give a stage's state, or None where none was kept."""
    with database.read() as session:
        key = session.scalars(select(ArtifactRow.sha256).where(_named(job, kind, name))).one_or_none()
    return None if key is None else store.get_bytes(key)


def list_files(database: Database, job: str) -> list[ArtifactRow]:
    """Give a job's result files by name."""
    with database.read() as session:
        wanted = (ArtifactRow.job == job) & (ArtifactRow.kind == RESULT)
        return list(session.scalars(select(ArtifactRow).where(wanted).order_by(ArtifactRow.name)))


def export_files(database: Database, store: Store, job: str, folder: Path, names: Sequence[str] = ()) -> list[Path]:
    """Copy a job's result files (all, or those named) into a folder.

    Raises:
        ResultMissing: where the job has no result, or no file of a name.
    """
    files = choose_files(job, [Artifact.from_row(row) for row in list_files(database, job)], names)
    return [store.copy(file.sha256, folder / file.name) for file in files]


def choose_files(job: str, files: Sequence[Artifact], names: Sequence[str]) -> list[Artifact]:
    """Return those of a job's files that are named, or all where none is.

    Raises:
        ResultMissing: where the job has no result, or no file of a name.
    """
    if not files:
        raise ResultMissing(f"job {job} has no result files; `garmentq status {job}` tells why.")
    unknown = set(names) - {file.name for file in files}
    if unknown:
        known = ", ".join(file.name for file in files)
        raise ResultMissing(f"job {job} has no file {', '.join(sorted(unknown))}; it has {known}.")
    return [file for file in files if not names or file.name in names]


def report_jobs(database: Database, rows: Sequence[JobRow]) -> list[JobReport]:
    """Return jobs with what they found, in the order of their rows; three questions for each `JOBS_AT_ONCE`."""
    reports: list[JobReport] = []
    with database.read() as session:
        for start in range(0, len(rows), JOBS_AT_ONCE):
            chunk = rows[start : start + JOBS_AT_ONCE]
            found = _find_patterns(session, [row.id for row in chunk])
            reports += [JobReport.from_row(row, **found[row.id]) for row in chunk]
    return reports


def _find_patterns(session: Session, jobs: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return for each job the fields of its report that other tables hold."""
    found: dict[str, dict[str, Any]] = {job: {"metrics": {}} for job in jobs}
    patterns = (
        select(PatternRow.job, PatternRow.category, PatternRow.template, MaterialRow.name)
        .join(MaterialRow, MaterialRow.id == PatternRow.material)
        .where(PatternRow.job.in_(jobs))
    )
    for job, garment, template, fabric in session.execute(patterns):
        found[job] |= {"garment": garment, "template": template, "fabric": fabric}
    for job, source in session.execute(select(BodyRow.job, BodyRow.source).where(BodyRow.job.in_(jobs))):
        found[job]["body"] = source
    metrics = select(MetricRow.job, MetricRow.name, MetricRow.value).where(MetricRow.job.in_(jobs))
    for job, name, value in sorted(session.execute(metrics)):
        found[job]["metrics"][name] = value
    return found


def _named(job: str, kind: str, name: str) -> Any:
    return (ArtifactRow.job == job) & (ArtifactRow.kind == kind) & (ArtifactRow.name == name)


def _add_artifact(session: Session, job: str, kind: str, name: str, sha256: str, size: int) -> None:
    session.add(ArtifactRow(job=job, kind=kind, name=name, sha256=sha256, size=size, created=clock()))


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


def _body_row(job: str, body: Body) -> BodyRow:
    from ..core.body import JOINTS

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
    from ..core.pattern import polygon_area

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
            {**asdict(gate), "value": _finite(gate.value), "limit": _finite(gate.limit)} for gate in recovery.gates
        ],
        "warnings": list(recovery.warnings),
        "stage_seconds": {name: round(value, 3) for name, value in recovery.stage_seconds.items()},
        "cpu_seconds": round(recovery.cpu_seconds, 3),
        "peak_mb": round(recovery.peak_mb, 1),
        "manifest": json.loads(json.dumps(recovery.manifest, default=str)),
    }


def _finite(value: float | None) -> float | None:
    """Give a number that every database can keep, or None."""
    return None if value is None or not math.isfinite(value) else float(value)
