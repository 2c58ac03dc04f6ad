"""Whether a queue has anything to do."""

from __future__ import annotations

from sqlalchemy import exists, or_, select

from .database import Database
from .models import DeliveryRow, JobRow, OutboxRow
from .states import OPEN


def has_work(database: Database) -> bool:
    """Return whether a job is open, a wake-up is to be published, or a webhook message is to be sent or repeated."""
    is_open = exists().where(JobRow.state.in_(OPEN))
    is_unpublished, is_unsent = exists().where(OutboxRow.id.is_not(None)), exists().where(DeliveryRow.due.is_not(None))
    with database.read() as session:
        return bool(session.scalar(select(or_(is_open, is_unpublished, is_unsent))))
