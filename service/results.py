"""A job's result: storing and reading its rows and files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from ..core.run.errors import NotFound
from .database import Database, clock, skip_damaged_rows
from .families import make_children
from .jobs import Claim, fail_with_result, succeed, write_fenced
from .kinds import Kind, KindUnknown, find_kind
from .kinds.redrape_request import REDRAPE
from .kinds.rows import list_result
from .models import (
    ArtifactRow,
    BodyRow,
    JobInputRow,
    JobRow,
    JobTagRow,
    JobWaitRow,
    MaterialRow,
    MetricRow,
    PanelRow,
    PatternRow,
    PieceRow,
    SubjectJobRow,
    SubjectRow,
)
from .places import find_places
from .records import Artifact, Child, JobReport, Redrape, RedrapeState
from .settings import ServiceSettings
from .states import State
from .store import Store

RESULT = "result"
CHECKPOINT = "checkpoint"
PREVIOUS = "checkpoint.1"
"""Kind of the checkpoint before the newest of a name: it is kept in case the newest is damaged; older ones are not."""

JOBS_AT_ONCE = 500
"""Number of jobs of one query for results."""


class ResultMissing(NotFound):
    """The job has no result; `garmentq status JOB` shows why."""

    code = "result.missing"


@skip_damaged_rows
def store_result(database: Database, store: Store, claim: Claim, kind: Kind, result: Any, folder: Path) -> State:
    """Store the files first, then write all rows, end the job and create its children in one fenced transaction.

    A crash between the two leaves files that no row names, which `gc` deletes. Checkpoints are dropped.

    Args:
        database: The database for the rows.
        store: The store for the files.
        claim: The claim that permits the write.
        kind: The job's kind.
        result: What `Kind.run` returned.
        folder: Folder with the result's files; names below it are kept.

    Returns:
        How the job ended: `succeeded`, or `failed` if the kind reports a failure with its result.

    Raises:
        FenceLost: if another worker has taken the job over; nothing is written then.
    """
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    files = [(path.relative_to(folder).as_posix(), store.put(path)) for path in paths]
    with database.write() as session:
        if kind.changes:  # before the job's own row: rows of a family are locked from above
            session.get(JobRow, claim.inputs[kind.changes], with_for_update=True)
        write_fenced(session, claim, touched=clock())
        for table in (PieceRow, PanelRow, PatternRow, BodyRow, MetricRow, ArtifactRow):
            session.execute(delete(table).where(table.job == claim.job))
        for name, kept in files:
            _add_artifact(session, claim.job, RESULT, name, kept.sha256, kept.size)
        outcome = kind.store(session, claim, result)
        if outcome.failure is not None:
            fail_with_result(session, claim, outcome.failure, outcome.summary)
            list_result(session, claim.job)
            return State.FAILED
        succeed(session, claim, outcome.summary)
        list_result(session, claim.job)
        make_children(session, claim.job, outcome.children)
        return State.SUCCEEDED


def save_checkpoint(database: Database, store: Store, claim: Claim, name: str, content: bytes) -> None:
    """Store a stage's state; of each name the newest and the one before are kept.

    Raises:
        FenceLost: if another worker has taken the job over.
    """
    kept = store.put_bytes(content)
    with database.write() as session:
        write_fenced(session, claim, touched=clock())
        session.execute(delete(ArtifactRow).where(_named(claim.job, PREVIOUS, name)))
        session.execute(update(ArtifactRow).where(_named(claim.job, CHECKPOINT, name)).values(kind=PREVIOUS))
        _add_artifact(session, claim.job, CHECKPOINT, name, kept.sha256, kept.size)


def load_checkpoint(database: Database, store: Store, job: str, name: str, kind: str = CHECKPOINT) -> bytes | None:
    """Return a stage's state, or None if none was stored."""
    with database.read() as session:
        key = session.scalars(select(ArtifactRow.sha256).where(_named(job, kind, name))).one_or_none()
    return None if key is None else store.get_bytes(key)


def list_files(database: Database, job: str) -> list[ArtifactRow]:
    """Return a job's result files by name."""
    with database.read() as session:
        condition = (ArtifactRow.job == job) & (ArtifactRow.kind == RESULT)
        return list(session.scalars(select(ArtifactRow).where(condition).order_by(ArtifactRow.name)))


def export_files(database: Database, store: Store, job: str, folder: Path, names: Sequence[str] = ()) -> list[Path]:
    """Copy a job's result files (all, or those named) into a folder.

    Raises:
        ResultMissing: if the job has no result, or no file of a name.
    """
    files = choose_files(job, [Artifact.from_row(row) for row in list_files(database, job)], names)
    return [store.copy(file.sha256, folder / file.name) for file in files]


def choose_files(job: str, files: Sequence[Artifact], names: Sequence[str]) -> list[Artifact]:
    """Return the named files of a job, or all if none is named.

    Raises:
        ResultMissing: if the job has no result, or no file of a name.
    """
    if not files:
        raise ResultMissing(f"job {job} has no result files; `garmentq status {job}` shows why.")
    unknown = set(names) - {file.name for file in files}
    if unknown:
        known = ", ".join(file.name for file in files)
        raise ResultMissing(f"job {job} has no file {', '.join(sorted(unknown))}; it has {known}.")
    return [file for file in files if not names or file.name in names]


@skip_damaged_rows
def report_jobs(database: Database, rows: Sequence[JobRow], settings: ServiceSettings) -> list[JobReport]:
    """Return jobs with their results, in the order of their rows; ten queries for each `JOBS_AT_ONCE`."""
    reports: list[JobReport] = []
    places = find_places(database, [row.id for row in rows if row.state == State.QUEUED])
    with database.read() as session:
        for start in range(0, len(rows), JOBS_AT_ONCE):
            chunk = rows[start : start + JOBS_AT_ONCE]
            ids = [row.id for row in chunk]
            found, family = _find_patterns(session, ids), _find_family(session, ids)
            garments = _load_garments(session, ids)
            for row in chunk:
                details, kept = _show_details(session, row, settings), found[row.id] | family[row.id]
                kept["redrape"] = kept["redrape"] or _read_redrape(kept["metrics"])
                place = asdict(places[row.id]) if row.id in places else {}
                reports.append(JobReport.from_row(row, details=details, **kept, **place))
            del garments
    return reports


def _load_garments(session: Session, jobs: Sequence[str]) -> list[object]:
    """Load the rows that `Kind.show` reads; the session has them while the returned list exists."""
    patterns = list(session.scalars(select(PatternRow).where(PatternRow.job.in_(jobs))))
    materials = select(MaterialRow).where(MaterialRow.id.in_({row.material for row in patterns}))
    bodies = select(BodyRow).where(BodyRow.job.in_(jobs))
    return [*patterns, *session.scalars(materials), *session.scalars(bodies)]


def _find_patterns(session: Session, jobs: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return for each job the fields of its report from other tables."""
    nothing = dict.fromkeys(("garment", "template", "fabric", "body"))
    found: dict[str, dict[str, Any]] = {job: {**nothing, "metrics": {}} for job in jobs}
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


def _find_family(session: Session, jobs: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return for each job its children, inputs, awaited siblings, tags and subject."""
    lists = ("children", "waits", "tags")
    found: dict[str, dict[str, Any]] = {
        job: {"inputs": {}, "redrape": None, "subject": None, **{name: [] for name in lists}} for job in jobs
    }
    names = select(SubjectJobRow.job, SubjectRow.name).join(SubjectRow, SubjectRow.id == SubjectJobRow.subject)
    for job, name in session.execute(names.where(SubjectJobRow.job.in_(jobs))):
        found[job]["subject"] = name
    children = select(JobRow).where(JobRow.parent.in_(jobs)).order_by(JobRow.created, JobRow.id)
    for child in session.scalars(children):
        found[child.parent or ""]["children"].append(Child(child.id, child.name, child.kind, child.state))
        if child.kind == REDRAPE:
            found[child.parent or ""]["redrape"] = Redrape.from_job(child)
    for row in session.scalars(select(JobInputRow).where(JobInputRow.job.in_(jobs)).order_by(JobInputRow.name)):
        found[row.job]["inputs"][row.name] = row.input
    for wait in session.scalars(select(JobWaitRow).where(JobWaitRow.job.in_(jobs)).order_by(JobWaitRow.awaited)):
        found[wait.job]["waits"].append(wait.awaited)
    for kept in session.scalars(select(JobTagRow).where(JobTagRow.job.in_(jobs)).order_by(JobTagRow.tag)):
        found[kept.job]["tags"].append(kept.tag)
    return found


def _read_redrape(metrics: Mapping[str, float | None]) -> Redrape | None:
    """Return the re-drape of a recovery that has no job for it, by its metrics."""
    if "redrape_missing" in metrics:
        return Redrape(RedrapeState.NEVER)
    return Redrape(RedrapeState.DONE) if "redrape.surface_rms_mm.s2t" in metrics else None


def _show_details(session: Session, row: JobRow, settings: ServiceSettings) -> dict[str, Any]:
    checked = {} if row.checked is None else {"checked": row.checked}
    try:
        return checked | find_kind(settings, row.kind).show(session, row)
    except KindUnknown:
        return checked


def _named(job: str, kind: str, name: str) -> Any:
    return (ArtifactRow.job == job) & (ArtifactRow.kind == kind) & (ArtifactRow.name == name)


def _add_artifact(session: Session, job: str, kind: str, name: str, sha256: str, size: int) -> None:
    session.add(ArtifactRow(job=job, kind=kind, name=name, sha256=sha256, size=size, created=clock()))
