"""`/v1/jobs/{job}/shares`: links that show one result to whoever has them."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path

from ..keys import Caller
from ..share_records import SHARE_PATH
from ..shares import create_share, list_shares, revoke_share
from .access import AppStateDependency, Reader, Submitter, find_own
from .answers import NewShare, Share, Shares
from .problems import show_answer, show_list
from .schemas import ShareIn

router = APIRouter(prefix="/jobs/{job}/shares", tags=["shares"])

EXAMPLE = {
    "share": "5f1d0c9b7a3e", "job": "3685ecfd4f81", "key": "0c9b7a3e5f1d", "created": 1795250000.1,
    "expires": 1795854800.1, "opened": 2,
}  # fmt: skip

ShareId = Annotated[str, Path(pattern="^[0-9a-f]{1,16}$")]


@router.post(
    "", status_code=201, name="create_share", summary="Share a result.",
    responses=show_answer(EXAMPLE | {"path": "/shared/..."}, 201, NewShare, (408,)),
)  # fmt: skip
def create(job: str, payload: ShareIn, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Make a link that shows the garment, its pattern, its measures and its PDF, but neither the body nor other jobs.

    The path with the token is only in this response. The link ends after `days`, with its job, or with its key.
    """
    row = find_own(rooms, caller, job)
    share, token = create_share(rooms.database, row.id, payload.days, caller.key)
    return share.as_json() | {"path": f"{SHARE_PATH}{token}"}


@router.get(
    "", name="list_shares", summary="List the links of a result.",
    responses=show_answer(show_list("shares", [EXAMPLE]), model=Shares),
)  # fmt: skip
def list_all(job: str, rooms: AppStateDependency, caller: Reader) -> Any:
    """Return the caller's valid links to a result, without their tokens."""
    row = find_own(rooms, caller, job)
    return show_list("shares", [one.as_json() for one in list_shares(rooms.database, row.id, _find_maker(caller))])


@router.delete(
    "/{share}", name="revoke_share", summary="Revoke a link.", responses=show_answer(EXAMPLE, model=Share),
)  # fmt: skip
def revoke(job: str, share: ShareId, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Revoke a link to a result; whoever has it sees nothing any more."""
    row = find_own(rooms, caller, job)
    return revoke_share(rooms.database, row.id, share, _find_maker(caller)).as_json()


def _find_maker(caller: Caller) -> str | None:
    """Return the key whose links the caller sees; None: those of all keys."""
    return None if caller.sees_all else caller.key
