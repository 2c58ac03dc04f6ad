"""Base classes of errors that a user may see, with a stable code and a message that has the next step."""

from __future__ import annotations


class GarmentqError(Exception):
    """Something went wrong inside garmentq; please report it with the log.

    Each subclass has a stable `code` (`room.reason`), stored with a failed job and printed by the command line. The
    default message is the first line of its docstring, and has the user's next step.
    """

    code = "garmentq.error"

    def __init__(self, message: str | None = None) -> None:
        doc = (type(self).__doc__ or "").strip().split("\n", 1)[0]
        self.message = message or doc
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message


class BadInput(GarmentqError):
    """The input cannot be used; the code says why."""

    code = "input.bad"


class Unavailable(GarmentqError):
    """Something that the service needs is away or full; the service tries again by itself."""

    code = "service.unavailable"


class NotFound(GarmentqError):
    """Nothing of that name or id is known; list what there is and try again."""

    code = "not_found"


class Cancelled(GarmentqError):
    """The job was cancelled."""

    code = "job.cancelled"


def keep_printable(text: str) -> str:
    """Return a text on one line with each escape, reversed writing or broken letter replaced by `?`. Messages have
    names from users' files; a database refuses some of these letters, and a terminal executes others."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)
