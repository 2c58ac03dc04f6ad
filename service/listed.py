"""Keep what lists of jobs are filtered and sorted by in the jobs' own columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sqlalchemy import delete
from sqlalchemy.orm import Session

from .models import JobFileRow
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
