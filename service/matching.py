"""Compare the patterns of two files, each read in a limited process, and read a user's pairs of panels."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..core.run.errors import BadInput
from ..core.run.sandbox import Bounds, IsStopped, call_limited, never_stopped
from ..core.run.text import read_json

BOUNDS = Bounds(memory_bytes=1024**3, cpu_seconds=30, wall_seconds=120.0)
"""Limits of a comparison: two patterns of ten panels take 3 s."""

MAX_PAIRS_FILE_SIZE = 100_000
"""Largest file of pairs that is read [bytes]: 200 panels with long names take 20 KB."""


class PairsUnreadable(BadInput):
    """The pairs cannot be read; write {"panel of the first": "panel of the second"}, or CSV with two names a line."""

    code = "match.pairs_unreadable"


def match_files(
    first: Path,
    second: Path,
    pairs: Mapping[str, str],
    only_given: bool = False,
    outlines: bool = False,
    is_stopped: IsStopped = never_stopped,
) -> dict[str, Any]:
    """Compare two pattern files in a limited process.

    Args:
        first, second: The files.
        pairs: Names of the second's panels by the first's, for those that a user paired.
        only_given: Pair no others.
        outlines: Add each pattern's outlines [m], by the panels' names.
        is_stopped: As for `call_limited`.

    Returns:
        The fields of `Comparison` as JSON values, and what `compare_files` adds.

    Raises:
        BadInput: if a file is not a pattern, or a pair is invalid.
    """
    arguments: dict[str, Any] = {"first": str(first.absolute()), "second": str(second.absolute()), "pairs": dict(pairs)}
    arguments |= {"only_given": only_given, "outlines": outlines}
    return call_limited("garmentq.core.judge.comparison:compare_files", arguments, BOUNDS, is_stopped).result


def read_pairs(path: Path) -> dict[str, str]:
    """Read pairs of panels, as JSON or as CSV.

    Raises:
        PairsUnreadable: if the file is neither.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_PAIRS_FILE_SIZE + 1)
        text = content.decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise PairsUnreadable(f"{path}: {PairsUnreadable().message}") from error
    if len(content) > MAX_PAIRS_FILE_SIZE:
        raise PairsUnreadable(f"{path} is larger than {MAX_PAIRS_FILE_SIZE} bytes; {PairsUnreadable().message}")
    found = _read_json(text) if text.lstrip().startswith(("{", "[")) else _read_csv(text)
    if found is None:
        raise PairsUnreadable(f"{path}: {PairsUnreadable().message}")
    return found


def _read_json(text: str) -> dict[str, str] | None:
    try:
        found = read_json(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(found, dict) or not all(isinstance(value, str) for value in found.values()):
        return None
    return found


def _read_csv(text: str) -> dict[str, str] | None:
    try:
        rows = [row for row in csv.reader(io.StringIO(text), strict=True) if row]
    except csv.Error:
        return None
    if any(len(row) != 2 for row in rows) or len({row[0] for row in rows}) < len(rows):
        return None
    return {first.strip(): second.strip() for first, second in rows}
