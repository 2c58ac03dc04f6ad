"""What of an error may be shown to others than the operator: to callers, on pages, in events, messages and jobs."""

from __future__ import annotations

from ..core.run.errors import GarmentqError, keep_printable
from ..core.run.sandbox import LONGEST_MESSAGE

SERVICE_CODE_PREFIXES = ("service.", "store.")
"""How codes begin of what is wrong with the service itself: their messages name hosts, folders and users."""


def show_message(error: GarmentqError) -> str:
    """Return an error's message on one line; of what is wrong with the service itself the fixed text of its kind.

    Who tells such an error writes its own message into the log.
    """
    message = explain_kind(error) if is_service_error(error) else error.message
    return keep_printable(message.replace("\n", " "))[:LONGEST_MESSAGE]


def is_service_error(error: GarmentqError) -> bool:
    """Return whether an error tells of the service itself, not of what it was asked."""
    return error.code.startswith(SERVICE_CODE_PREFIXES)


def explain_kind(error: GarmentqError) -> str:
    """Return what is said of every error of a kind and what to do, with nothing of this installation in it."""
    return (type(error).__doc__ or "").strip().split("\n", 1)[0]
