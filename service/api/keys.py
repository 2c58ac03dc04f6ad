"""`/v1/keys`: create, list, rotate and revoke keys."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path

from ..keys import DEFAULT_GRACE_HOURS, create_key, list_keys, revoke_key, rotate_key
from ..records import Key as KeyRecord
from .access import Admin, AppStateDependency
from .answers import Key, Keys, NewKey
from .problems import show_answer, show_list
from .schemas import GraceHours, KeyIn

router = APIRouter(prefix="/keys", tags=["keys"])

EXAMPLE = {
    "key": "5f1d0c9b7a3e", "name": "atelier", "scopes": ["read", "submit"], "quota": 100, "created": 1795250000.1,
    "revoked": None, "priority": 0, "expires": None, "used": 1795250800.5,
    "earlier_until": None,
}  # fmt: skip

KeyId = Annotated[str, Path(pattern="^[0-9A-Za-z]{1,16}$")]


@router.post(
    "", status_code=201, name="create_key", summary="Create a key.",
    responses=show_answer(EXAMPLE | {"token": "gq_..."}, 201, NewKey, (408,)),
)  # fmt: skip
def create(payload: KeyIn, rooms: AppStateDependency, caller: Admin) -> Any:
    """Create a key; its token is only in this response."""
    row, token = create_key(
        rooms.database, payload.name, tuple(payload.scopes), payload.quota, payload.priority, payload.days
    )
    return KeyRecord.from_row(row).as_json() | {"token": token}


@router.get(
    "", name="list_keys", summary="List the keys.", responses=show_answer(show_list("keys", [EXAMPLE]), model=Keys)
)
def list_all(rooms: AppStateDependency, caller: Admin) -> Any:
    """Return every key, without its token."""
    return show_list("keys", [KeyRecord.from_row(row).as_json() for row in list_keys(rooms.database)])


@router.delete(
    "/{key}", name="revoke_key", summary="Revoke a key.",
    responses=show_answer(EXAMPLE | {"revoked": 1795250900.0}, model=Key),
)  # fmt: skip
def revoke(key: KeyId, rooms: AppStateDependency, caller: Admin) -> Any:
    """Revoke a key; its jobs stay."""
    return KeyRecord.from_row(revoke_key(rooms.database, key)).as_json()


@router.post(
    "/{key}/token", name="rotate_key", summary="Give a key a new token.",
    responses=show_answer(EXAMPLE | {"token": "gq_...", "earlier_until": 1795337200.0}, 200, NewKey, (409,)),
)  # fmt: skip
def rotate(key: KeyId, rooms: AppStateDependency, caller: Admin, hours: GraceHours = DEFAULT_GRACE_HOURS) -> Any:
    """Give a key a new token, which is only in this response; the one before stays valid for some hours.

    Jobs, webhooks and uploads stay the key's own.
    """
    row, token = rotate_key(rooms.database, key, hours)
    return KeyRecord.from_row(row).as_json() | {"token": token}
