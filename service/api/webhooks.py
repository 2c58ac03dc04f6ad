"""`/v1/webhooks`: addresses that receive messages when jobs end."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path

from ..keys import DEFAULT_GRACE_HOURS, Caller
from ..states import State
from ..webhook_records import Receipt
from ..webhook_trial import try_webhook
from ..webhooks import create_webhook, delete_webhook, list_webhooks, rotate_secret
from .access import AppStateDependency, Reader, Submitter
from .answers import NewWebhook, Webhook, Webhooks
from .problems import show_answer, show_list
from .schemas import GraceHours, WebhookIn

router = APIRouter(prefix="/webhooks", tags=["webhooks"])

EXAMPLE = {
    "webhook": "5f1d0c9b7a3e", "key": "0c9b7a3e5f1d", "url": "https://studio.example/garmentq",
    "states": ["succeeded", "failed"], "created": 1795250000.1, "served": 1795250900.5, "status": 204, "error": None,
    "owed": 0, "earlier_until": None,
}  # fmt: skip

WebhookId = Annotated[str, Path(pattern="^[0-9A-Za-z]{1,16}$")]


@router.post(
    "", status_code=201, name="create_webhook", summary="Create a webhook.",
    responses=show_answer(EXAMPLE | {"secret": "whsec_..."}, 201, NewWebhook, (408,)),
)  # fmt: skip
def create(payload: WebhookIn, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Send messages to an address about the caller's own jobs that end from now on.

    The secret that signs the messages is only in this response. The address must be https and public, unless the
    operator allows others; docs/reference/http.md describes the messages.
    """
    states = [State(state) for state in payload.states]
    webhook, secret = create_webhook(rooms.database, payload.url, states, rooms.settings.webhook_networks, caller.key)
    return webhook.as_json() | {"secret": secret}


@router.get(
    "", name="list_webhooks", summary="List the webhooks.",
    responses=show_answer(show_list("webhooks", [EXAMPLE]), model=Webhooks),
)  # fmt: skip
def list_all(rooms: AppStateDependency, caller: Reader) -> Any:
    """Return the caller's webhooks without their secrets; `owed` is the number of unsent messages."""
    return show_list("webhooks", [one.as_json() for one in list_webhooks(rooms.database, _find_realm(caller))])


@router.delete(
    "/{webhook}", name="delete_webhook", summary="Delete a webhook.", responses=show_answer(EXAMPLE, model=Webhook),
)  # fmt: skip
def delete(webhook: WebhookId, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Delete a webhook and its unsent messages."""
    return delete_webhook(rooms.database, webhook, _find_realm(caller)).as_json()


@router.post(
    "/{webhook}/secret", name="rotate_secret", summary="Give a webhook a new secret.",
    responses=show_answer(EXAMPLE | {"secret": "whsec_...", "earlier_until": 1795337200.0}, 200, NewWebhook),
)  # fmt: skip
def rotate(
    webhook: WebhookId, rooms: AppStateDependency, caller: Submitter, hours: GraceHours = DEFAULT_GRACE_HOURS
) -> Any:
    """Give a webhook a new secret, which is only in this response.

    For some hours messages have two signatures, of the new secret and of the one before.
    """
    one, secret = rotate_secret(rooms.database, webhook, hours, _find_realm(caller))
    return one.as_json() | {"secret": secret}


@router.post(
    "/{webhook}/test", summary="Test a webhook.",
    responses=show_answer({"status": 204, "error": None}, model=Receipt),
)  # fmt: skip
async def test_webhook(webhook: WebhookId, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Send a message of the type `test` once, through the usual courier, before the other unsent messages.

    The response comes within 30 s: the status that the address returned, or why there was none.
    """
    rooms.meter.count_test(caller.key)
    return await try_webhook(rooms.database, webhook, _find_realm(caller))


def _find_realm(caller: Caller) -> str | None:
    """Return the key whose webhooks the caller sees; None: those of all keys."""
    return None if caller.sees_all else caller.key
