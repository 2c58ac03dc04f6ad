"""Read the beginning of a file as far as its header goes, however long the comments in it are."""

from __future__ import annotations

import re
from pathlib import Path

FIRST = 1 << 16
"""Bytes that are read at first; the header of nearly every file ends within."""
MOST = 1 << 22
"""Longest header that is read [bytes]: comments with a scanner's whole log or a registration's matrices fit in."""


def read_head(path: Path, end: re.Pattern[bytes]) -> bytes:
    """Return the first bytes of a file, at least to where `end` is found, and no more than about `MOST` without it."""
    with path.open("rb") as file:
        head = file.read(FIRST)
        while end.search(head) is None and len(head) < MOST and (more := file.read(len(head))):
            head += more
    return head
