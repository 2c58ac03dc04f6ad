"""Families of jobs as a gallery shows them: a person or garment, its garments, and what was made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from sqlalchemy import ColumnElement, select
from sqlalchemy.orm import Session

from .database import Database, skip_damaged_rows
from .jobs import IDS_AT_ONCE
from .models import JobInputRow, JobRow, JobTagRow, OwnerRow
from .places import Place, find_places
from .states import OPEN, State

GARMENT_KIND = "recover"
"""Kind of the jobs below a person that each make one garment."""


@dataclass(frozen=True)
class GalleryJob:
    """Describe one job of a family without its result.

    Attributes:
        id: Its id.
        name: Its name; of a garment of a person the garment's word.
        kind: Name of its kind.
        state: Its state.
        stage: Stage that runs, or ran last.
        progress: Share of that stage that is done.
        overall: Share of its work that is done.
        verdict: pass, doubtful or fail; None: no check was made.
        error_code: Code of the error with which it ended, or None.
        error_message: Sentence of that error, or None.
        garment: Category of its garment, or None.
        created: When it was created [s since 1970].
        parent: The job that made it, or None.
        place: Place of a queued job, 1 is next; None if it has none, or far behind.
        expected_start: When a queued job should start [s since 1970]; None if unknown.
    """

    id: str
    name: str
    kind: str
    state: State
    stage: str
    progress: float
    overall: float
    verdict: str | None
    error_code: str | None
    error_message: str | None
    garment: str | None
    created: float
    parent: str | None
    place: int | None = None
    expected_start: float | None = None

    @property
    def is_open(self) -> bool:
        """Return whether it has not ended."""
        return self.state in OPEN


COLUMNS = (
    JobRow.id, JobRow.name, JobRow.kind, JobRow.state, JobRow.stage, JobRow.progress, JobRow.overall, JobRow.verdict,
    JobRow.error_code, JobRow.error_message, JobRow.garment, JobRow.created, JobRow.parent,
)  # fmt: skip
"""Columns of `GalleryJob`, in its order, but for its place: results and requests are not read."""


@dataclass(frozen=True)
class GalleryFamily:
    """Describe one family.

    Attributes:
        root: Its first job.
        garments: The garments below a person, oldest first.
        others: Re-drapes, exports, edits and everything else that was made of it, oldest first.
        tags: Its tags.
    """

    root: GalleryJob
    garments: tuple[GalleryJob, ...] = ()
    others: tuple[GalleryJob, ...] = ()
    tags: tuple[str, ...] = ()

    @property
    def main_jobs(self) -> tuple[GalleryJob, ...]:
        """Return the jobs whose results the family is for: the first, and the garments."""
        return self.root, *self.garments

    @property
    def progress(self) -> float | None:
        """Return the share of its main jobs' work that is done; None if none of them is open."""
        main = self.main_jobs
        if not any(job.is_open for job in main):
            return None
        return sum(job.overall if job.is_open else 1.0 for job in main) / len(main)


@skip_damaged_rows
def read_families(database: Database, roots: Sequence[str], owner: str | None = None) -> list[GalleryFamily]:
    """Return the families of some root jobs with all that was made of their results, in the order of the roots.

    Args:
        database: The database.
        roots: Ids of the roots.
        owner: Only the jobs of this key besides the roots; None: all.
    """
    with database.read() as session:
        family_of = {root: root for root in roots}
        found = dict(_read(session, JobRow.id, roots))
        level: list[str] = [root for root in roots if root in found]
        below: list[GalleryJob] = []
        while level:
            made = [(job, parent) for parent, job in _read_below(session, level)]
            made += [(job, read) for read, job in _read_readers(session, level, owner)]
            level = []
            for job, source in made:
                if job.id not in family_of:
                    family_of[job.id] = family_of[source]
                    below.append(job)
                    level.append(job.id)
        tags = _read_tags(session, list(found))
    places = find_places(database, [job.id for job in (*found.values(), *below) if job.state == State.QUEUED])
    found = {root: _place(job, places) for root, job in found.items()}
    families: dict[str, list[GalleryJob]] = {root: [] for root in found}
    for job in sorted((_place(job, places) for job in below), key=lambda one: (one.created, one.id)):
        families[family_of[job.id]].append(job)
    return [_arrange(found[root], families[root], tags.get(root, ())) for root in roots if root in found]


def _place(job: GalleryJob, places: Mapping[str, Place]) -> GalleryJob:
    return replace(job, **asdict(places[job.id])) if job.id in places else job


def _arrange(root: GalleryJob, below: Sequence[GalleryJob], tags: Sequence[str]) -> GalleryFamily:
    garments = [job for job in below if job.parent == root.id and job.kind == GARMENT_KIND]
    others = [job for job in below if job not in garments]
    return GalleryFamily(root, tuple(garments), tuple(others), tuple(tags))


def _read(session: Session, column: Any, values: Sequence[str]) -> list[tuple[str, GalleryJob]]:
    """Return the jobs whose column has one of some values, each with that value."""
    return _run(session, select(column, *COLUMNS), lambda chunk: column.in_(chunk), values)


def _read_below(session: Session, jobs: Sequence[str]) -> list[tuple[str, GalleryJob]]:
    return _read(session, JobRow.parent, jobs)


def _read_readers(session: Session, jobs: Sequence[str], owner: str | None) -> list[tuple[str, GalleryJob]]:
    """Return the jobs that read the results of some others, each with the job that it reads."""
    statement = select(JobInputRow.input, *COLUMNS).join(JobInputRow, JobInputRow.job == JobRow.id)
    if owner is not None:
        statement = statement.join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == owner)
    return _run(session, statement, lambda chunk: JobInputRow.input.in_(chunk), jobs)


def _run(session: Session, statement: Any, choose: Any, values: Sequence[str]) -> list[tuple[str, GalleryJob]]:
    found: list[tuple[str, GalleryJob]] = []
    for start in range(0, len(values), IDS_AT_ONCE):
        is_chosen: ColumnElement[bool] = choose(values[start : start + IDS_AT_ONCE])
        for first, *rest in session.execute(statement.where(is_chosen)):
            found.append((first, GalleryJob(*rest)))
    return found


def _read_tags(session: Session, jobs: Sequence[str]) -> dict[str, list[str]]:
    tags: dict[str, list[str]] = {}
    for start in range(0, len(jobs), IDS_AT_ONCE):
        chosen = JobTagRow.job.in_(jobs[start : start + IDS_AT_ONCE])
        for job, tag in session.execute(select(JobTagRow.job, JobTagRow.tag).where(chosen).order_by(JobTagRow.tag)):
            tags.setdefault(job, []).append(tag)
    return tags
