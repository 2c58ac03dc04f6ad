"""Keep what lists of jobs are filtered and sorted by in the jobs' own columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from .models import BodyRow, JobFileRow, JobRow, MaterialRow, PatternRow
from .named_files import find_hashes

LISTED_SETTINGS = ("method", "preset")
LISTED_COSTS = ("cpu_seconds", "peak_mb")
RESULT_FIELDS = ("garment", "template", "fabric", "body", *LISTED_COSTS)
"""Columns that a job has from its result; a job that is retried has none."""


def read_listed_settings(request: Mapping[str, Any]) -> dict[str, str | None]:
    """Return the columns of a job that repeat its request's settings."""
    settings = request.get("settings")
    found = settings if isinstance(settings, dict) else {}
    return {name: found[name] if isinstance(found.get(name), str) else None for name in LISTED_SETTINGS}


def read_listed_costs(result: Mapping[str, Any]) -> dict[str, float | None]:
    """Return the columns of a job that repeat its result's cost."""
    return {name: float(result[name]) if result.get(name) is not None else None for name in LISTED_COSTS}


def list_request(session: Session, job: str, request: Mapping[str, Any]) -> None:
    """Store which files a job's request names."""
    session.flush()
    session.execute(delete(JobFileRow).where(JobFileRow.job == job))
    session.add_all(JobFileRow(job=job, sha256=key) for key in sorted(set(find_hashes(request))))


def list_result(session: Session, job: str) -> None:
    """Copy what the rows of a job's result say into its own."""
    session.flush()
    row = session.get_one(JobRow, job, populate_existing=True)
    pattern = select(PatternRow.category, PatternRow.template, MaterialRow.name).where(PatternRow.job == job)
    found = session.execute(pattern.join(MaterialRow, MaterialRow.id == PatternRow.material)).one_or_none()
    row.garment, row.template, row.fabric = found or (None, None, None)
    row.body = session.scalar(select(BodyRow.source).where(BodyRow.job == job))
    for name, value in read_listed_costs(row.result or {}).items():
        setattr(row, name, value)
