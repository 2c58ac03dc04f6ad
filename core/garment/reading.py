"""Content of the files of one recovery, and its transfer from a limited process as plain arrays."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

from ..body.body import Body
from ..run.records import read_record, write_record
from ..run.sandbox import ReaderCrashed
from ..scan.pieces import ScanInput
from .pattern import Pattern


@dataclass(frozen=True)
class Reading:
    """Describe the content of the files of a request.

    Attributes:
        pieces: The garment, and the wearer's mesh where there is one.
        body: The wearer, where its file is of SMPL's format and has its own skeleton; else None.
        pattern: The base pattern, where it is a file; else None.
        category: The garment's category where it follows from the person's other clothes; else None.
    """

    pieces: ScanInput
    body: Body | None = None
    pattern: Pattern | None = None
    category: str | None = None


@dataclass(frozen=True)
class _StoredReading:
    """A reading, with the unknown keys of its pattern's file as JSON, the format of stored results of 0.1.0."""

    reading: Reading
    extra: str = ""


def save_reading(reading: Reading, path: Path) -> None:
    """Write a reading as plain arrays."""
    extra, pattern = "", reading.pattern
    if pattern is not None:
        extra, reading = json.dumps(pattern.extra), replace(reading, pattern=replace(pattern, extra={}))
    write_record(_StoredReading(reading, extra), path)


def load_reading(path: Path) -> Reading:
    """Read what `save_reading` wrote in a limited process, which is untrusted: no pickle, nothing compressed.

    Raises:
        ReaderCrashed: where it is something else.
    """
    stored = read_record(_StoredReading, path)
    if stored.reading.pattern is None:
        return stored.reading
    try:
        return replace(stored.reading, pattern=replace(stored.reading.pattern, extra=json.loads(stored.extra)))
    except (ValueError, RecursionError) as error:
        raise ReaderCrashed() from error


def save_given_pattern(pattern: Pattern, path: Path) -> None:
    """Write a pattern that was read from a user's file as plain arrays."""
    write_record(pattern, path)


def load_given_pattern(path: Path) -> Pattern:
    """Read what `save_given_pattern` wrote in a limited process, which is untrusted.

    Raises:
        ReaderCrashed: where it is something else.
    """
    return read_record(Pattern, path)
