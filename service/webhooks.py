"""Webhooks: addresses that receive messages when jobs end. Messages are stored in the database until they are accepted.

A message is written in the transaction that ends the job. It is sent again until it is answered with 2xx: its sender
may die between the response and recording it, so a receiver may see a message twice, under the same id.
"""

from __future__ import annotations

import base64
import secrets
import uuid
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, delete, exists, func, select
from sqlalchemy.orm import Session

from ..core.run.errors import BadInput, NotFound
from .clocks import AHEAD_SECONDS
from .database import Database, change_rows, clock, skip_damaged_rows
from .keys import DEFAULT_GRACE_HOURS, check_grace, lock_key
from .models import ApiKeyRow, DeliveryRow, JobRow, OwnerRow, WebhookRow
from .states import ENDED, State
from .webhook_address import check_url
from .webhook_records import Receipt, Webhook

MAX_KEY_WEBHOOKS = 10
"""Largest number of webhooks of one key."""

TAKEN_SECONDS = 30.0
"""Time for which a message is claimed by its sender [s]; sending takes 5 s at most, or the sender has died."""

FIRST_PAUSE, PAUSE_GROWTH_FACTOR, MAX_DELIVERY_PAUSE = 10.0, 4.0, 6 * 3600.0
"""First pause after a message was not accepted [s], the factor by which each next pause is longer, and the longest
pause [s]: 10 s, 40 s, 160 s, ... up to 6 h."""

MAX_DELIVERY_TRIES = 9
"""Largest number of attempts for a message; with these pauses the last is 16 hours after the first, longer than a
night."""

KEPT_SECONDS = 7 * 86400.0
"""Time for which an accepted or abandoned message is kept [s]."""

SECRET_BYTES = 32
"""Number of random bytes of a signing secret, as many as SHA-256 has."""


class WebhookUnknown(NotFound):
    """There is no such webhook; `garmentq webhooks list` shows them."""

    code = "webhook.unknown"


class WebhooksFull(BadInput):
    """The key has reached its number of webhooks; delete one first."""

    code = "webhook.too_many"


@dataclass(frozen=True)
class Message:
    """Describe a message that is to be sent.

    Attributes:
        id: Its id, the same in every attempt.
        url: Its address.
        secret: Secret that signs it.
        body: Its content, as JSON values.
        earlier_secret: Secret before the last rotation, which signs it too; None if it no longer does.
    """

    id: str
    url: str
    secret: str
    body: dict[str, Any]
    earlier_secret: str | None = None


def create_webhook(
    database: Database, url: str, states: Sequence[State], networks: str, key: str = ""
) -> tuple[Webhook, str]:
    """Create a webhook for a key's jobs that end from now on; return it with its secret, which is returned only here.

    Args:
        database: The webhooks' database.
        url: Address of the messages.
        states: End states that it receives messages about; empty: all.
        networks: Networks that are allowed beyond the public ones.
        key: Key of the jobs; empty: all jobs.

    Raises:
        WebhookBad: if the address cannot be used.
        WebhooksFull: if the key has reached its number of webhooks.
    """
    check_url(url, networks)
    secret = _make_secret()
    state_names = [state.value for state in sorted(set(states) or ENDED)]
    row = WebhookRow(
        id=secrets.token_hex(6), key=key, url=url, secret=secret, states=state_names, created=clock(), served=0.0,
        taken_until=0.0,
    )  # fmt: skip
    with database.write() as session:
        lock_key(session, key)
        count = session.scalar(select(func.count()).select_from(WebhookRow).where(WebhookRow.key == key)) or 0
        if count >= MAX_KEY_WEBHOOKS:
            raise WebhooksFull(f"there are {count} webhooks, the largest number of a key; delete one first.")
        session.add(row)
        session.flush()
        session.refresh(row)
    return Webhook.from_row(row, 0), secret


@skip_damaged_rows
def list_webhooks(database: Database, key: str | None = None) -> list[Webhook]:
    """Return the webhooks of a key, or with None all, oldest first."""
    owed = select(func.count()).select_from(DeliveryRow)
    owed = owed.where(DeliveryRow.webhook == WebhookRow.id, DeliveryRow.due.is_not(None))
    statement = select(WebhookRow, owed.correlate(WebhookRow).scalar_subquery())
    if key is not None:
        statement = statement.where(WebhookRow.key == key)
    with database.read() as session:
        rows = session.execute(statement.order_by(WebhookRow.created, WebhookRow.id)).all()
    return [Webhook.from_row(row, count) for row, count in rows]


def delete_webhook(database: Database, webhook: str, key: str | None = None) -> Webhook:
    """Delete a webhook and its unsent messages, and return it; with a key only one of its own.

    Raises:
        WebhookUnknown: if there is none.
    """
    with database.write() as session:
        row = _find(session, webhook, key)
        session.delete(row)
        return Webhook.from_row(row, 0)


def rotate_secret(
    database: Database, webhook: str, hours: float = DEFAULT_GRACE_HOURS, key: str | None = None
) -> tuple[Webhook, str]:
    """Give a webhook a new secret, and return both; the one before signs its messages too, for some hours.

    Args:
        database: The webhook's database.
        webhook: Its id.
        hours: How long the secret before stays [h].
        key: Key that must own it; None: any.

    Raises:
        WebhookUnknown: if there is none.
        GraceBad: if `hours` is out of range.
    """
    check_grace(hours)
    secret = _make_secret()
    with database.write() as session:
        row = _find(session, webhook, key)
        row.earlier_secret, row.earlier_until = row.secret, clock() + 3600.0 * hours
        row.secret = secret
        session.flush()
        session.refresh(row)
        unsent = (DeliveryRow.webhook == row.id) & DeliveryRow.due.is_not(None)
        owed = session.scalar(select(func.count()).select_from(DeliveryRow).where(unsent)) or 0
        return Webhook.from_row(row, owed), secret


def queue_trial(database: Database, webhook: str, key: str | None = None) -> str:
    """Queue a message of the type `test`, before all others and for one attempt; return the message's id.

    Raises:
        WebhookUnknown: if there is none.
    """
    mark = uuid.uuid4().hex
    with database.write() as session:
        row = _find(session, webhook, key)
        body = {"id": mark, "type": "test", "at": session.scalar(select(clock()))}
        once = {"due": 0.0, "tries": MAX_DELIVERY_TRIES - 1}
        session.add(DeliveryRow(id=mark, webhook=row.id, job=None, body=body, created=clock(), **once))
    return mark


def read_receipt(database: Database, message: str) -> Receipt | None:
    """Return the outcome of a message that is no longer to be sent; None while it is."""
    with database.read() as session:
        row = session.get(DeliveryRow, message)
        return None if row is None or row.due is not None else Receipt(row.status, row.error)


def withdraw_message(database: Database, message: str) -> None:
    """Delete a message."""
    with database.write() as session:
        session.execute(delete(DeliveryRow).where(DeliveryRow.id == message))


def queue_messages(session: Session, job: str, state: State, event: str = "") -> None:
    """Queue one message for each webhook that may see an ended job, in the transaction that ends or changes the job.

    Args:
        session: The transaction.
        job: Id of the job.
        state: How it ended, which the webhook must have asked for.
        event: What happened; empty: it ended.
    """
    owned = exists().where(OwnerRow.job == job, OwnerRow.key == WebhookRow.key)
    hooks = session.scalars(select(WebhookRow).where((WebhookRow.key == "") | owned, _is_valid())).all()
    hook_ids = [hook.id for hook in hooks if state in hook.states]
    if not hook_ids:
        return
    names = ("name", "kind", "family", "parent", "verdict", "error_code", "error_message")
    statement = select(*(getattr(JobRow, name) for name in names), clock().label("at")).where(JobRow.id == job)
    row = session.execute(statement).one()
    error = {"code": row.error_code, "message": row.error_message} if row.error_code else None
    shown = {"job": job, "state": state, **{name: getattr(row, name) for name in names[:5]}, "error": error}
    for hook in hook_ids:
        mark = uuid.uuid4().hex
        body = {"id": mark, "type": f"job.{event or state}", "at": row.at, "job": shown}
        session.add(DeliveryRow(id=mark, webhook=hook, job=job, body=body, created=clock(), due=clock(), tries=0))


def has_due(database: Database) -> bool:
    """Return whether a message is to be sent now."""
    with database.read() as session:
        return bool(session.scalar(select(exists().where(_is_waiting()))))


@skip_damaged_rows
def claim_due_messages(database: Database, most: int) -> list[Message]:
    """Claim some messages to send, one for each webhook, the webhook served longest ago first."""
    hooks = select(WebhookRow, WebhookRow.earlier_until > clock()).where(_is_waiting())
    hooks = hooks.order_by(WebhookRow.served, WebhookRow.id).limit(most)
    found = []
    with database.write() as session:
        for hook, has_two in session.execute(hooks.with_for_update(skip_locked=True)).all():
            messages = select(DeliveryRow).where(DeliveryRow.webhook == hook.id, _is_due())
            row = session.scalars(messages.order_by(DeliveryRow.due, DeliveryRow.created).limit(1)).one()
            hook.taken_until, hook.served = clock() + TAKEN_SECONDS, clock()
            found.append(Message(row.id, hook.url, hook.secret, row.body, hook.earlier_secret if has_two else None))
    return found


def note_receipt(database: Database, message: str, receipt: Receipt) -> None:
    """Record the outcome of a message: if it was not accepted, it is due again after a pause, until it is abandoned."""
    with database.write() as session:
        row = session.get(DeliveryRow, message)
        if row is None:
            return  # the job or the webhook was deleted meanwhile
        hook = session.get(WebhookRow, row.webhook)
        assert hook is not None
        row.tries += 1
        is_over = receipt.error is None or row.tries >= MAX_DELIVERY_TRIES
        row.due = None if is_over else clock() + find_pause(row.tries)
        row.status, row.error = receipt.status, receipt.error
        hook.taken_until, hook.status, hook.error = 0.0, receipt.status, receipt.error


def find_pause(tries: int) -> float:
    """Return the pause [s] after a number of failed attempts."""
    return min(MAX_DELIVERY_PAUSE, FIRST_PAUSE * PAUSE_GROWTH_FACTOR ** (min(tries, 20) - 1))


@skip_damaged_rows
def forget_messages(database: Database) -> int:
    """Delete messages that ended long ago, or whose key is no longer valid; return how many rows."""
    over = DeliveryRow.due.is_(None) & (DeliveryRow.created < clock() - KEPT_SECONDS)
    is_orphan = DeliveryRow.webhook.in_(select(WebhookRow.id).where(~_is_valid()))
    with database.write() as session:
        return change_rows(session, delete(DeliveryRow).where(over | is_orphan))


def _make_secret() -> str:
    return "whsec_" + base64.b64encode(secrets.token_bytes(SECRET_BYTES)).decode()


def _is_due() -> ColumnElement[bool]:
    """Return the condition of a due message; one beyond the longest pause is due too (the clock was set back)."""
    return (DeliveryRow.due <= clock()) | (DeliveryRow.due > clock() + MAX_DELIVERY_PAUSE + AHEAD_SECONDS)


def _is_waiting() -> ColumnElement[bool]:
    """Return the condition of a valid webhook that has a due message and no current sender."""
    latest = clock() + TAKEN_SECONDS + AHEAD_SECONDS
    is_free = (WebhookRow.taken_until <= clock()) | (WebhookRow.taken_until > latest)
    return is_free & exists().where(DeliveryRow.webhook == WebhookRow.id, _is_due()) & _is_valid()


def _is_valid() -> ColumnElement[bool]:
    """Return the condition of a webhook whose key was neither revoked nor has expired."""
    is_over = ApiKeyRow.revoked.is_not(None) | (ApiKeyRow.expires <= clock())
    return ~exists().where(ApiKeyRow.id == WebhookRow.key, is_over)


def _find(session: Session, webhook: str, key: str | None) -> WebhookRow:
    row = session.get(WebhookRow, webhook)
    if row is None or key not in (None, row.key):
        raise WebhookUnknown()
    return row
