"""What every route gets: the rooms it works with, and who asks."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from anyio import CapacityLimiter
from fastapi import Depends, Request, Security
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer

from ..database import Database
from ..jobs import JobUnknown, find_job
from ..keys import Caller, admit, owns
from ..models import JobRow
from ..settings import ServiceSettings
from ..store import Store
from .limits import ApiLimits


@dataclass(frozen=True)
class Rooms:
    """Hold what the routes work with.

    Attributes:
        settings: Which home.
        database: Its database.
        store: Its files.
        limits: What a request may cost.
        is_open: True where a caller without a key may be the local user.
        streams: Open event streams by key.
        checks: Lets a few scans be checked at a time.
    """

    settings: ServiceSettings
    database: Database
    store: Store
    limits: ApiLimits
    is_open: bool
    streams: dict[str, int] = field(default_factory=dict)
    checks: list[CapacityLimiter] = field(default_factory=list)

    @property
    def incoming(self) -> Path:
        """Give the folder of unfinished transfers."""
        return self.settings.home / "incoming"


bearer = HTTPBearer(auto_error=False, description="A token from `garmentq keys create`.")


def get_rooms(request: Request) -> Rooms:
    """Give the rooms of the application."""
    rooms: Rooms = request.app.state.rooms
    return rooms


def get_caller(
    rooms: Annotated[Rooms, Depends(get_rooms)],
    credentials: Annotated[HTTPAuthorizationCredentials | None, Security(bearer)],
) -> Caller:
    """Tell who asks.

    Raises:
        KeyMissing, KeyBad: where nobody may.
    """
    return admit(rooms.database, credentials.credentials if credentials else None, rooms.is_open)


def get_reader(caller: Annotated[Caller, Depends(get_caller)]) -> Caller:
    """Ask for the scope `read`."""
    caller.must("read")
    return caller


def get_submitter(caller: Annotated[Caller, Depends(get_caller)]) -> Caller:
    """Ask for the scope `submit`."""
    caller.must("submit")
    return caller


def get_admin(caller: Annotated[Caller, Depends(get_caller)]) -> Caller:
    """Ask for the scope `admin`."""
    caller.must("admin")
    return caller


RoomsOf = Annotated[Rooms, Depends(get_rooms)]
Reader = Annotated[Caller, Depends(get_reader)]
Submitter = Annotated[Caller, Depends(get_submitter)]
Admin = Annotated[Caller, Depends(get_admin)]


def find_own(rooms: Rooms, caller: Caller, job: str) -> JobRow:
    """Give a job that the caller may see; another key's job is as unknown as none. Only whole ids are taken
    from a key that does not see all, so that a beginning tells nothing of the jobs of others.

    Raises:
        JobUnknown: where there is none.
    """
    row = find_job(rooms.database, job) if job.isalnum() and len(job) <= 16 else None
    is_whole = row is not None and (caller.sees_all or row.id == job)
    if row is None or not is_whole or not owns(rooms.database, caller, row.id):
        raise JobUnknown(f"there is no job '{job[:40]}'; `garmentq status` lists them all.")
    return row
