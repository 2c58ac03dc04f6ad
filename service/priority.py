"""Change of a family's priority after its submission."""

from __future__ import annotations

from sqlalchemy import exists, select, update
from sqlalchemy.orm import Session

from .database import Database
from .jobs import JobUnknown, record
from .kinds.redrape_request import REDRAPE
from .models import JobRow, OwnerRow
from .states import OPEN

PRIORITY_EVENT = "priority_changed"
"""Kind of the event of each open job whose priority changes."""


def change_priority(database: Database, job: str, priority: int, key: str = "") -> int:
    """Change the priority of all jobs of a job's family; children that are made later have it too.

    Re-drapes keep theirs, the lowest. If other API keys requested the family too, its priority is only raised.

    Args:
        database: The jobs' database.
        job: A job of the family.
        priority: The new priority.
        key: Id of the caller's key; empty: the local user.

    Returns:
        The job's own priority after this call.

    Raises:
        JobUnknown: if there is none of that id.
    """
    with database.write() as session:
        row = session.get(JobRow, job)
        if row is None:
            raise JobUnknown(f"there is no job '{job}'; `garmentq status` lists them all.")
        root = session.get_one(JobRow, row.family or row.id, with_for_update=True)
        others = exists().where(OwnerRow.job == root.id, OwnerRow.key != key)
        if key and session.scalar(select(others)):
            priority = max(priority, root.priority)
        _write(session, root.family or root.id, priority)
        session.refresh(row)
        return row.priority


def _write(session: Session, family: str, priority: int) -> None:
    changed = (JobRow.family == family) & (JobRow.kind != REDRAPE) & (JobRow.priority != priority)
    is_open = select(JobRow.id).where(changed, JobRow.state.in_(OPEN)).order_by(JobRow.id)
    for job in session.scalars(is_open.with_for_update()).all():
        record(session, job, PRIORITY_EVENT, priority=priority)
    statement = update(JobRow).where(changed).values(priority=priority)
    session.execute(statement.execution_options(synchronize_session=False))
