"""Cursors of lists: where the next page begins, whatever was added meanwhile."""

from __future__ import annotations

import base64
import json
import math
from dataclasses import dataclass

from ..core.run.errors import BadInput

MAX_CURSOR_LENGTH = 1000
"""Largest length of a cursor [letters]. A name has at most 255 letters; JSON and base64 make at most 8 of one in most
scripts."""

Value = str | float | None


class CursorBad(BadInput):
    """The cursor belongs to no page of this list; take `next` of the page before, with the same `sort`."""

    code = "query.cursor_bad"


@dataclass(frozen=True)
class Cursor:
    """Describe the last job of a page.

    Attributes:
        sort: What the list is sorted by, with `-` for the largest first.
        value: That field or metric of the job; None: it has none, and so have all that follow.
        created: When the job was created [s since 1970].
        job: Id of the job.
    """

    sort: str
    value: Value
    created: float
    job: str

    def encode(self) -> str:
        """Return the cursor as one word for an address."""
        text = json.dumps([self.sort, self.value, self.created, self.job], separators=(",", ":"), ensure_ascii=False)
        return base64.urlsafe_b64encode(text.encode()).decode().rstrip("=")


def decode_cursor(text: str, sort: str) -> Cursor:
    """Return the cursor of a list that is sorted in one way.

    Raises:
        CursorBad: if it is damaged, or belongs to another list.
    """
    try:
        if len(text) > MAX_CURSOR_LENGTH:
            raise ValueError
        padded = text + "=" * (-len(text) % 4)
        found = json.loads(base64.b64decode(padded.encode("ascii"), altchars=b"-_", validate=True))
        own, value, created, job = found
    except (ValueError, TypeError, RecursionError):
        raise CursorBad() from None
    is_known = isinstance(value, str | None) or _is_number(value)
    if own != sort or not is_known or not _is_number(created) or not isinstance(job, str):
        raise CursorBad()
    if any("\x00" in one or not one.isprintable() for one in (job, value) if isinstance(one, str)):
        raise CursorBad()
    return Cursor(sort, value, float(created), job)


def _is_number(value: object) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False
