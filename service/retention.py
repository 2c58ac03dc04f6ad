"""Retention: delete families and subjects whose time is over, by the settings of the home, of a tag or of a subject."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, exists, or_, select
from sqlalchemy.orm import Session, aliased

from ..core.run.errors import GarmentqError, NotFound
from .database import Database, clock, skip_damaged_rows
from .deletion import delete_jobs
from .models import JobInputRow, JobRow, JobTagRow, SubjectJobRow, SubjectRow
from .persons import delete_subject
from .settings import ServiceSettings
from .states import ENDED
from .store import Store
from .uploads import DAY_SECONDS

log = logging.getLogger(__name__)

RETENTION_BATCH_SIZE = 5
"""Number of families, or of subjects, that a worker deletes in one round: its loop waits for their files too."""


@dataclass(frozen=True)
class Expired:
    """Describe what is to be deleted: roots of families, and ids of subjects."""

    families: tuple[str, ...] = ()
    subjects: tuple[str, ...] = ()

    @property
    def count(self) -> int:
        """Return how many there are."""
        return len(self.families) + len(self.subjects)


@skip_damaged_rows
def find_expired(database: Database, settings: ServiceSettings, limit: int | None = None) -> Expired:
    """Find the families and subjects whose retention is over, at most some of each (None: all).

    A subject's own retention counts before those of its jobs' tags, the longest of which counts before the home's. It
    begins with the end of the last job of the family, or of a job that reads a result of it; open families stay.
    """
    tags = settings.tag_days
    with database.read() as session:
        families = dict.fromkeys(_find_by_tags(session, tags, limit))
        if settings.keep_days:
            families |= dict.fromkeys(_find_old(session, settings.keep_days, _has_tag(tags), limit))
        return Expired(tuple(families)[:limit], tuple(_find_subjects(session, limit)))


def delete_expired(database: Database, store: Store, expired: Expired) -> int:
    """Delete families and subjects; return how many. One that cannot be deleted now is logged and stays."""
    count = 0
    for subject in expired.subjects:
        count += _try(lambda one=subject: delete_subject(database, store, one, _find_key(database, one)), subject)
    for job in expired.families:
        count += _try(lambda one=job: delete_jobs(database, store, [one]), job)
    return count


def enforce_retention(database: Database, store: Store, settings: ServiceSettings) -> bool:
    """Delete some of what is over; return whether there may be more."""
    expired = find_expired(database, settings, RETENTION_BATCH_SIZE)
    done = delete_expired(database, store, expired) if expired.count else 0
    return done >= RETENTION_BATCH_SIZE


def _try(delete: Any, name: str) -> int:
    try:
        delete()
    except NotFound:
        pass  # it was deleted with another one
    except GarmentqError as error:
        log.warning("the retention of %s is over, and it cannot be deleted: %s", name, error)
        return 0
    return 1


def _find_key(database: Database, subject: str) -> str | None:
    """Return the key of a subject, so that what other keys have stays."""
    with database.read() as session:
        return session.scalar(select(SubjectRow.key).where(SubjectRow.id == subject))


def _find_by_tags(session: Session, tags: Mapping[str, float], limit: int | None) -> Iterable[str]:
    """Yield the roots of old families with a tag that has a retention; the longest of a family's tags counts."""
    for tag, days in tags.items():
        if days < math.inf:
            longer = [other for other, more in tags.items() if more > days]
            yield from _find_old(session, days, _has_tag(longer), limit, tag)


def _has_tag(tags: Iterable[str]) -> ColumnElement[bool]:
    other = aliased(JobTagRow)
    return exists().where(other.job == JobRow.id, other.tag.in_(list(tags)))


def _find_old(
    session: Session, days: float, is_kept: ColumnElement[bool], limit: int | None, tag: str = ""
) -> list[str]:
    """Return the roots (with a tag) whose families ended long ago, in that order, without those that are kept."""
    member, reader, own = aliased(JobRow), aliased(JobRow), aliased(SubjectRow)
    before = clock() - DAY_SECONDS * days
    read = exists().where(
        JobInputRow.input == member.id, JobInputRow.job == reader.id,
        reader.state.not_in(ENDED) | (reader.finished > before),
    )  # fmt: skip
    is_fresh = exists().where(
        member.family == JobRow.family, member.state.not_in(ENDED) | (member.finished > before) | read
    )
    has_own = exists().where(
        SubjectJobRow.job == JobRow.id, SubjectJobRow.subject == own.id,
        own.keep_days.is_not(None) | own.keep_until.is_not(None),
    )  # fmt: skip
    statement = select(JobRow.id).where(JobRow.finished < before, JobRow.parent.is_(None))
    if tag:
        statement = statement.join(JobTagRow, JobTagRow.job == JobRow.id).where(JobTagRow.tag == tag)
    statement = statement.where(~is_kept, ~has_own, ~is_fresh)
    return list(session.scalars(statement.order_by(JobRow.finished, JobRow.created, JobRow.id).limit(limit)))


def _find_subjects(session: Session, limit: int | None) -> list[str]:
    """Return the subjects whose retention is over and that have no open job."""
    job, last = aliased(JobRow), aliased(JobRow)
    before = clock() - DAY_SECONDS * SubjectRow.keep_days
    is_fresh = exists().where(
        SubjectJobRow.subject == SubjectRow.id, SubjectJobRow.job == last.id,
        (last.finished > before) | (last.created > before),
    )  # fmt: skip
    is_open = exists().where(
        SubjectJobRow.subject == SubjectRow.id, SubjectJobRow.job == job.id, job.state.not_in(ENDED)
    )
    by_days = SubjectRow.keep_days.is_not(None) & (SubjectRow.created < before) & ~is_fresh
    is_over = or_(SubjectRow.keep_until < clock(), by_days)
    return list(session.scalars(select(SubjectRow.id).where(is_over, ~is_open).order_by(SubjectRow.id).limit(limit)))
