"""Parser of the header `Range`."""

from __future__ import annotations

import re

from ...core.run.errors import BadInput

MAX_REQUEST_RANGES = 100
"""Largest number of ranges in one request; beyond it the whole file is sent."""

RANGE_PATTERN = re.compile(r"(\d{0,19})\s*-\s*(\d{0,19})")


class RangeBad(BadInput):
    """The file has no such range; request the list of files for its size."""

    code = "request.range"

    def __init__(self, status: int) -> None:
        """Refuse with 400 if the header cannot be parsed, with 416 if a range is beyond the file's end."""
        super().__init__()
        self.status = status


def read_ranges(text: str, size: int) -> list[tuple[int, int]]:
    """Return the ranges of a header as half-open intervals [first, end), merged where they overlap.

    Args:
        text: `bytes=FIRST-LAST,FIRST-,-COUNT`.
        size: The file's size [bytes].

    Returns:
        The ranges in the file's order; none if the whole file is to be sent.

    Raises:
        RangeBad: if the header cannot be parsed, or a range is beyond the file's end.
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
