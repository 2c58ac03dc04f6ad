"""Which bytes of a file the header `Range` asks for."""

from __future__ import annotations

import re

from ...core.run.errors import BadInput

MAX_REQUEST_RANGES = 100
"""Ranges of one request; where more are asked for the whole file is sent."""

RANGE_PATTERN = re.compile(r"(\d{0,19})\s*-\s*(\d{0,19})")


class RangeBad(BadInput):
    """The file has no such range; ask for its list."""

    code = "request.range"

    def __init__(self, status: int) -> None:
        """Refuse with 400 where the header cannot be read, with 416 where it asks for bytes that there are none of."""
        super().__init__()
        self.status = status


def read_ranges(text: str, size: int) -> list[tuple[int, int]]:
    """Return the ranges that a header asks for, each from its first byte up to but without its end, none twice.

    Args:
        text: `bytes=FIRST-LAST,FIRST-,-COUNT`.
        size: The file's size [bytes].

    Returns:
        The ranges in the file's order; none where the whole file is to be sent.

    Raises:
        RangeBad: where the header cannot be read, or asks for bytes behind the end.
    """
    unit, _, rest = text.partition("=")
    parts = [part.strip() for part in rest.split(",") if part.strip()]
    if unit.strip().lower() != "bytes" or not parts:
        raise RangeBad(400)
    if len(parts) > MAX_REQUEST_RANGES:
        return []
    merged: list[tuple[int, int]] = []
    for start, stop in sorted(_read_one(part, size) for part in parts):
        if merged and start <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(merged[-1][1], stop))
        else:
            merged.append((start, stop))
    return merged


def _read_one(part: str, size: int) -> tuple[int, int]:
    found = RANGE_PATTERN.fullmatch(part)
    if found is None or found[1] == found[2] == "":
        raise RangeBad(400)
    if not found[1]:
        start, stop = max(size - int(found[2]), 0), size
    else:
        start, stop = int(found[1]), min(int(found[2]) + 1, size) if found[2] else size
    if start >= size:
        raise RangeBad(416)
    if start >= stop:
        raise RangeBad(400)
    return start, stop
