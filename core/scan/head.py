"""Read the beginning of a file to the end of its header, however long the comments in it are."""

from __future__ import annotations

import re
from pathlib import Path

INITIAL_HEAD_BYTES = 1 << 16
"""Size of the first read of a file [bytes]; the header of nearly every file ends within it."""
MAX_HEAD_BYTES = 1 << 22
"""Longest header that is read [bytes]: comments with a scanner's log or a registration's matrices fit in."""


def read_head(path: Path, end: re.Pattern[bytes]) -> bytes:
    """Return the first bytes of a file, at least to where `end` is found, or about `MAX_HEAD_BYTES` of them."""
    with path.open("rb") as file:
        head = file.read(INITIAL_HEAD_BYTES)
        while end.search(head) is None and len(head) < MAX_HEAD_BYTES and (more := file.read(len(head))):
            head += more
    return head
