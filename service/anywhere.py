"""The same questions to the database of a home, or by HTTP to the service that GARMENTQ_URL names.

The functions have the names and arguments of those in `jobs.py`, `results.py`, `query.py` and `submission.py`, so that
a command reads the same in both cases.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.errors import BadInput
from . import database as rooms
from . import jobs, keys, query, reaper, results, submission, templates
from .database import Database
from .results import ResultMissing
from .settings import ServiceSettings
from .states import ENDED
from .store import Store
from .submission import Order, Submitted

if TYPE_CHECKING:
    from .client import Client

__all__ = [
    "ENDED", "LocalOnly", "Place", "ResultMissing", "cancel", "create_key", "describe_job", "export_files", "find_job",
    "find_jobs", "find_jobs_by_id", "import_template", "is_remote", "list_files", "list_jobs", "list_keys",
    "list_materials", "list_templates", "look", "open_database", "read_queue", "read_template", "retry", "revoke_key",
    "submit",
]  # fmt: skip

Place = Any
"""A `Database` or a `Client`; rows of both have the same attributes."""


class LocalOnly(BadInput):
    """This command works on a home of this machine; unset GARMENTQ_URL, or run it where the service runs."""

    code = "command.local_only"


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
    return _open_client()


def find_job(place: Place, job: str) -> Any:
    """Give a job by its id."""
    return jobs.find_job(place, job) if isinstance(place, Database) else place.find_job(job)


def find_jobs_by_id(place: Place, ids: Sequence[str]) -> list[Any]:
    """Give the jobs of some ids, in the order of the ids."""
    return list(jobs.find_jobs_by_id(place, ids) if isinstance(place, Database) else place.find_jobs_by_id(ids))


def list_jobs(place: Place, limit: int = 50) -> list[Any]:
    """Give the newest jobs, newest first."""
    return jobs.list_jobs(place, limit) if isinstance(place, Database) else place.list_jobs(limit)


def look(place: Place, job: str, after: int = 0) -> tuple[str, list[Any]]:
    """Give a job's state, and its events with an id above `after`, in order; an ended state comes with all of them."""
    if isinstance(place, Database):
        state = jobs.find_job(place, job).state
        return state, list(jobs.read_events(place, job, after))
    client: Client = place
    found, events = client.look(job, after)
    return found, list(events)


def read_queue(place: Place) -> tuple[dict[str, int], list[Any]]:
    """Count the jobs by state, and give the living workers."""
    if isinstance(place, Database):
        return query.count_states(place), list(reaper.list_workers(place))
    client: Client = place
    states, workers = client.read_queue()
    return states, list(workers)


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


def list_materials(name: str | None = None) -> list[dict[str, Any]]:
    """Give the fabrics, or one of them, with every parameter in SI units and its sources."""
    if is_remote():
        client: Client = _open_client()
        return [client.read_material(name)] if name else client.list_materials()
    from ..core.simulate import get_fabric, load_fabrics

    fabrics = (get_fabric(name),) if name else load_fabrics()
    return [{**asdict(fabric), "sources": dict(fabric.sources)} for fabric in fabrics]


def create_key(place: Place, name: str, scopes: tuple[str, ...], quota: int) -> tuple[Any, str]:
    """Make an API key; its token is given here and never again."""
    if isinstance(place, Database):
        return keys.create_key(place, name, scopes, quota)
    client: Client = place
    return client.create_key(name, scopes, quota)


def list_keys(place: Place) -> list[Any]:
    """Give every API key, oldest first."""
    return list(keys.list_keys(place)) if isinstance(place, Database) else list(place.list_keys())


def revoke_key(place: Place, key: str) -> Any:
    """Take an API key back."""
    return keys.revoke_key(place, key) if isinstance(place, Database) else place.revoke_key(key)


def _open_client() -> Client:
    from .client import Client

    return Client(os.environ["GARMENTQ_URL"], os.environ.get("GARMENTQ_API_KEY", ""))
