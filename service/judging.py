"""Change a stored result, and report the verdict that it has then."""

from __future__ import annotations

from typing import Any

from sqlalchemy.orm import Session

from .jobs import judge_result, record
from .kinds.rows import list_result
from .models import JobRow
from .states import State
from .webhooks import queue_messages

VERDICT_CHANGED = "verdict_changed"
"""Event of a result that was judged anew; `job.verdict_changed` is the type of its message."""


def change_result(session: Session, row: JobRow, changed: dict[str, Any], by: str) -> None:
    """Replace parts of a result that was stored, and report its verdict if that has changed: as an event, by webhooks.

    Args:
        session: A writing transaction.
        row: The job with the result, locked in this transaction.
        changed: The new parts, by their names in the job's result.
        by: Id of the job that changes it; its own events, which are followed still, have the new verdict too.
    """
    before, result = row.verdict, {**(row.result or {}), **changed}
    row.result, row.verdict = result, judge_result(result)
    list_result(session, row.id)
    if row.verdict == before:
        return
    for job in (row.id, by):
        record(session, job, VERDICT_CHANGED, job=row.id, verdict=row.verdict, before=before)
    session.flush()
    queue_messages(session, row.id, State(row.state), VERDICT_CHANGED)
