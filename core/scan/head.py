"""Read the beginning of a file as far as its header goes, however long the comments in it are."""

from __future__ import annotations

import re
from pathlib import Path

FIRST = 1 << 16
"""Bytes that are read at first; the header of nearly every file ends within."""
MOST_HEAD_BYTES = 1 << 22
"""Longest header that is read [bytes]: comments with a scanner's whole log or a registration's matrices fit in."""


def read_head(path: Path, end: re.Pattern[bytes]) -> bytes:
    """Return the first bytes of a file, to where `end` is found at least, or about `MOST_HEAD_BYTES` of them."""
    with path.open("rb") as file:
        head = file.read(FIRST)
        while end.search(head) is None and len(head) < MOST_HEAD_BYTES and (more := file.read(len(head))):
            head += more
    return head
