"""Dependencies of every route: the application state and the authenticated caller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Request, Security
from fastapi.dependencies.models import Dependant
from fastapi.security import HTTPAuthorizationCredentials, HTTPBearer
from sqlalchemy import select

from ...core.run.text import TextBad, has_unstorable_text
from ..database import starts_with
from ..jobs import JobUnknown, find_job
from ..keys import Caller
from ..models import JobRow, OwnerRow
from ..services import Services
from ..store_size import StoreSize
from .guard import CALLER
from .limited_calls import LimitedCalls
from .limits import ApiLimits
from .meter import Meter
from .problems import RequestBad
from .request_times import RequestTimes
from .threads import ThreadPools


@dataclass(frozen=True)
class AppState(Services):
    """Describe what the routes work with: an open home, and the limits of its callers.

    Attributes:
        limits: Limits of requests.
        local_token: Token that authenticates the local user while no keys exist; empty: there is no local user.
        meter: Counts the requests of each key.
        limited: Runs functions that call a limited process.
        lanes: Thread pools beside that of the routes.
        times: Counts the requests of all callers.
        store_size: Reports the size of the stored files.
    """

    limits: ApiLimits
    local_token: str
    meter: Meter
    limited: LimitedCalls
    lanes: ThreadPools
    times: RequestTimes
    store_size: StoreSize


bearer = HTTPBearer(auto_error=False, description="A token from `garmentq keys create`.")


async def get_app_state(request: Request) -> AppState:
    """Return the state of the application."""
    rooms: AppState = request.app.state.rooms
    return rooms


async def get_caller(
    request: Request, described: Annotated[HTTPAuthorizationCredentials | None, Security(bearer)]
) -> Caller:
    """Return the caller that the guard has authenticated; `described` only declares in OpenAPI that a key is needed."""
    caller: Caller = request.scope[CALLER]
    return caller


async def get_reader(caller: Annotated[Caller, Depends(get_caller)]) -> Caller:
    """Require the scope `read`."""
    caller.check_scope("read")
    return caller


async def get_submitter(caller: Annotated[Caller, Depends(get_caller)]) -> Caller:
    """Require the scope `submit`."""
    caller.check_scope("submit")
    return caller


async def get_admin(caller: Annotated[Caller, Depends(get_caller)]) -> Caller:
    """Require the scope `admin`."""
    caller.check_scope("admin")
    return caller


async def refuse_unknown(request: Request) -> None:
    """Refuse a query parameter that the route does not have: a misspelt filter would change the result silently.

    Raises:
        RequestBad: if there is one.
    """
    known = _find_parameters(request.scope["route"].dependant)
    unknown = sorted(set(request.query_params) - known)
    if unknown:
        raise RequestBad(f"there is no parameter '{unknown[0][:60]}'; there are {', '.join(sorted(known)) or 'none'}.")


async def refuse_text(request: Request) -> None:
    """Refuse a JSON body with text that cannot be stored, anywhere in it.

    Raises:
        TextBad: if there is one.
    """
    if request.scope["route"].body_field is None:
        return
    try:
        body = await request.json()
    except (ValueError, RecursionError):
        return  # not JSON: the route refuses it
    if has_unstorable_text(body):
        raise TextBad()


def _find_parameters(route: Dependant) -> set[str]:
    """Return the names of the query parameters of a route and of all that it depends on."""
    names = {field.alias for field in route.query_params}
    return names.union(*(_find_parameters(one) for one in route.dependencies))


async def get_watcher(caller: Annotated[Caller, Depends(get_caller)]) -> Caller:
    """Require the scope `metrics`."""
    caller.check_scope("metrics")
    return caller


AppStateDependency = Annotated[AppState, Depends(get_app_state)]
Reader = Annotated[Caller, Depends(get_reader)]
Watcher = Annotated[Caller, Depends(get_watcher)]
Submitter = Annotated[Caller, Depends(get_submitter)]
Admin = Annotated[Caller, Depends(get_admin)]


def find_own(rooms: AppState, caller: Caller, job: str) -> JobRow:
    """Return a job that the caller may see, by its id or the beginning of it; another key's job counts as unknown.

    Raises:
        JobUnknown: if there is none.
    """
    unknown = JobUnknown(f"there is no job '{job[:40]}'; `garmentq status` lists them all.")
    if not (job.isascii() and job.isalnum() and 4 <= len(job) <= 16):
        raise unknown
    if caller.sees_all:
        return find_job(rooms.database, job)
    with rooms.database.read() as session:
        statement = select(JobRow).join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == caller.key)
        rows = session.scalars(statement.where(starts_with(JobRow.id, job)).limit(2)).all()
    if len(rows) != 1:
        raise unknown
    return rows[0]
