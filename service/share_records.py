"""Records of share links; see `records.py`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

from .records import JobId, JsonRecord

if TYPE_CHECKING:
    from .models import ShareRow

SHARE_DAYS = (1, 7, 30)
"""Choices for the validity of a link [d]: a meeting, a week, and the longest."""

DEFAULT_SHARE_DAYS = 7
"""Validity of a link if none is chosen [d]."""

SHARE_PATH = "/shared/"
"""Beginning of the address of a shared result; the token follows."""


@dataclass(frozen=True)
class Share(JsonRecord):
    """Describe a share link, without its token.

    Attributes:
        id: Its id, by which it is revoked.
        job: The job whose result it shows.
        key: Id of the key that made it; empty: the local user.
        created: When it was made [s since 1970].
        expires: When it stops being valid [s since 1970].
        opened: How often its page was shown.
    """

    id: JobId = field(metadata={"alias": "share"})
    job: JobId
    key: str
    created: float
    expires: float
    opened: int

    @classmethod
    def from_row(cls, row: ShareRow) -> Self:
        """Read a row of the table of share links."""
        return cls(row.id, row.job, row.key, row.created, row.expires, row.opened)
