"""Text of errors for others than the operator: callers, pages, events, messages and jobs."""

from __future__ import annotations

from ..core.run.errors import GarmentqError, keep_printable
from ..core.run.sandbox import LONGEST_MESSAGE

SERVICE_CODE_PREFIXES = ("service.", "store.")
"""Beginnings of the codes of faults of the service itself: their messages name hosts, folders and users."""


def show_message(error: GarmentqError) -> str:
    """Return an error's message on one line; for a fault of the service itself the fixed text of its class.

    The code that reports such an error must log its own message.
    """
    message = explain_kind(error) if is_service_error(error) else error.message
    return keep_printable(message.replace("\n", " "))[:LONGEST_MESSAGE]


def is_service_error(error: GarmentqError) -> bool:
    """Return whether an error is a fault of the service itself, not of the request."""
    return error.code.startswith(SERVICE_CODE_PREFIXES)


def explain_kind(error: GarmentqError) -> str:
    """Return the fixed text of an error's class: meaning and next step, without details of this installation."""
    return (type(error).__doc__ or "").strip().split("\n", 1)[0]
