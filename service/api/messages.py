"""Messages to webhooks, as the OpenAPI document describes them; `service/webhooks.py` writes them."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Header
from pydantic import ConfigDict

from ..records import Failure
from ..states import State
from .answers import Answer
from .nulls import hide_nulls

router = APIRouter(tags=["webhooks"])

EXAMPLE = {
    "id": "9c1f5f1d0c9b4a7e8d2f6a7b8c9d0e1f", "type": "job.succeeded", "at": 1795250071.9,
    "job": {
        "job": "3685ecfd4f81", "state": "succeeded", "name": "skirt", "kind": "recover", "family": "3685ecfd4f81",
        "parent": None, "verdict": "pass", "error": None,
    },
}  # fmt: skip


class EndedJob(Answer):
    """Describe an ended job; `parent` is the job that made it, `family` the first of all above it."""

    job: str
    state: State
    name: str
    kind: str
    family: str
    parent: str | None
    verdict: str | None
    error: Failure | None


class Message(Answer):
    """Report to a webhook that a job ended, or test the webhook: a message of the type `test` has no `job`.

    `job.verdict_changed` reports the new verdict of a result whose re-drape has ended. `id` is the same when the
    message is sent again; `at` is when it happened [s since 1970].
    """

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": hide_nulls(EXAMPLE)})
    id: str
    type: Literal["job.succeeded", "job.failed", "job.dead", "job.cancelled", "job.verdict_changed", "test"]
    at: float
    job: EndedJob | None = None


@router.post(
    "job-ended", operation_id="take_message", status_code=204, summary="Receive the message that a job ended.",
    responses={204: {"description": "Accepted, within 5 s."}, "default": {"description": "Not accepted; sent again."}},
)  # fmt: skip
def take_message(
    message: Message,
    webhook_id: Annotated[str, Header(description="The message's `id`.")],
    webhook_timestamp: Annotated[int, Header(description="When it is sent [s since 1970].")],
    webhook_signature: Annotated[str, Header(description="`v1,` and the HMAC-SHA256 of `ID.TIMESTAMP.BODY`, base64.")],
) -> None:
    """Receive a message, signed by Standard Webhooks 1.0.0; docs/reference/http.md has the rules."""
