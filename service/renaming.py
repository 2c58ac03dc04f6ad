"""Change the name and the tags of a family of jobs."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import delete, exists, select

from .batches import forget_tags, note_tags
from .database import Database
from .deletion import JobShared
from .jobs import JobUnknown
from .models import JobRow, JobTagRow, OwnerRow
from .submission import check_labels
from .terms import JobTerms


def rename_family(
    database: Database, job: str, name: str | None = None, tags: Sequence[str] | None = None, key: str = ""
) -> None:
    """Write another name or other tags of a job's family: the name of its first job, the tags of each.

    Args:
        database: The database.
        job: Id of any job of the family.
        name: The new name; None: as it is.
        tags: All tags from now on; None: as they are.
        key: The caller's API key; empty: the operator.

    Raises:
        LabelBad: if they cannot be used.
        JobUnknown: if there is no such job.
        JobShared: if another key owns the family too.
    """
    check_labels(JobTerms(name or "", tuple(tags or ())))
    with database.write() as session:
        family = session.scalar(select(JobRow.family).where(JobRow.id == job))
        root = session.get(JobRow, family, with_for_update=True) if family else None
        if root is None:
            raise JobUnknown(f"there is no job '{job[:40]}'; `garmentq status` lists them all.")
        if key and session.scalar(select(exists().where(OwnerRow.job == root.id, OwnerRow.key != key))):
            raise JobShared("another key has the same job, so its name stays; ask the operator to change it.")
        if name:
            root.name = name
        if tags is not None:
            members = list(session.scalars(select(JobRow.id).where(JobRow.family == root.id)))
            before = session.scalars(select(JobTagRow.tag).where(JobTagRow.job == root.id)).all()
            session.execute(delete(JobTagRow).where(JobTagRow.job.in_(members)))
            session.add_all(JobTagRow(job=one, tag=tag) for one in members for tag in dict.fromkeys(tags))
            session.flush()
            for owner in session.scalars(select(OwnerRow.key).where(OwnerRow.job == root.id)).all() or [""]:
                note_tags(session, owner, tags)
            forget_tags(session, before)
