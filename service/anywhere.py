"""The same questions to the database of a home, or by HTTP to the service that GARMENTQ_URL names.

The functions have the names and arguments of those in `jobs.py`, `results.py`, `query.py` and `submission.py`, so that
a command reads the same in both cases.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import database as rooms
from . import jobs, query, results, submission, templates
from .database import Database
from .jobs import ENDED
from .results import ResultMissing
from .settings import ServiceSettings
from .store import Store
from .submission import Order, Submitted

if TYPE_CHECKING:
    from .client import Client

__all__ = [
    "ENDED", "Place", "ResultMissing", "cancel", "describe_job", "export_files", "find_job", "find_jobs",
    "find_jobs_by_id", "import_template", "is_remote", "list_files", "list_jobs", "list_templates", "open_database",
    "read_events", "read_template", "retry", "submit",
]  # fmt: skip

Place = Any
"""A `Database` or a `Client`; rows of both have the same attributes."""


def is_remote() -> bool:
    """Tell whether GARMENTQ_URL names a service."""
    return bool(os.environ.get("GARMENTQ_URL"))


def open_database(settings: ServiceSettings) -> Place:
    """Give a client where GARMENTQ_URL names a service (GARMENTQ_API_KEY is its key), else the home's database.

    Raises:
        DatabaseUnreachable, ServiceUnreachable: where it cannot be reached.
    """
    if not is_remote():
        return rooms.open_database(settings)
    from .client import Client

    return Client(os.environ["GARMENTQ_URL"], os.environ.get("GARMENTQ_API_KEY", ""))


def find_job(place: Place, job: str) -> Any:
    """Give a job by its id."""
    return jobs.find_job(place, job) if isinstance(place, Database) else place.find_job(job)


def find_jobs_by_id(place: Place, ids: Sequence[str]) -> list[Any]:
    """Give the jobs of some ids, in the order of the ids."""
    return jobs.find_jobs_by_id(place, ids) if isinstance(place, Database) else [place.find_job(job) for job in ids]


def list_jobs(place: Place, limit: int = 50) -> list[Any]:
    """Give the newest jobs, newest first."""
    return jobs.list_jobs(place, limit) if isinstance(place, Database) else place.list_jobs(limit)


def read_events(place: Place, job: str, after: int = 0) -> list[Any]:
    """Give a job's events with an id above `after`, in order."""
    return jobs.read_events(place, job, after) if isinstance(place, Database) else place.read_events(job, after)


def cancel(place: Place, job: str) -> str:
    """Stop a job; give its state after that."""
    state: str = jobs.cancel(place, job) if isinstance(place, Database) else place.cancel(job)
    return state


def retry(place: Place, job: str) -> None:
    """Queue an ended job again."""
    if isinstance(place, Database):
        jobs.retry(place, job)
    else:
        place.retry(job)


def describe_job(place: Place, row: Any) -> dict[str, Any]:
    """Give a job and what it found as plain JSON values."""
    return results.describe_job(place, row) if isinstance(place, Database) else row.described


def list_files(place: Place, job: str) -> list[Any]:
    """Give a job's result files by name."""
    return results.list_files(place, job) if isinstance(place, Database) else place.list_files(job)


def export_files(place: Place, store: Store, job: str, folder: Path, names: Sequence[str] = ()) -> list[Path]:
    """Copy a job's result files into a folder, each checked against its hash."""
    if isinstance(place, Database):
        return results.export_files(place, store, job, folder, names)
    client: Client = place
    return client.export_files(job, folder, names)


def find_jobs(
    place: Place, given: dict[str, str], wheres: Sequence[str], sort: str = "-created", limit: int = 50
) -> list[Any]:
    """Give the jobs whose fields are as given, and that meet every condition.

    Raises:
        QueryBad: where a condition cannot be read.
    """
    conditions = [query.Condition(name, "=", value) for name, value in given.items()]
    for text in wheres:
        conditions += query.parse_conditions(text)
    if isinstance(place, Database):
        return query.find_jobs(place, conditions, sort, limit)
    client: Client = place
    return list(client.find_jobs(wheres, sort, limit, **given))


def submit(place: Place, store: Store, order: Order) -> Submitted:
    """Keep or send the files, and queue the job."""
    return submission.submit(place, store, order) if isinstance(place, Database) else place.submit(order)


def list_templates(place: Place) -> list[dict[str, Any]]:
    """Give shipped and imported templates: name, category, source, title."""
    return templates.describe_templates(place) if isinstance(place, Database) else place.list_templates()


def read_template(place: Place, store: Store, name: str) -> bytes | None:
    """Give a template's pattern file; None for one that is shipped with this very program."""
    if not isinstance(place, Database):
        content: bytes = place.read_template(name)
        return content
    kept = templates.find_template(place, name)
    return store.get_bytes(kept.sha256) if kept else None


def import_template(place: Place, store: Store, name: str, path: Path, category: str, panels: int) -> None:
    """Keep or send a checked pattern file as a template."""
    if isinstance(place, Database):
        templates.keep_template(place, store, name, path, category, panels)
    else:
        place.import_template(name, path)
