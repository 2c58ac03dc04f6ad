"""Bound the cost of reading the files of one recovery."""

from __future__ import annotations

from dataclasses import dataclass

from ..run.sandbox import Bounds


@dataclass(frozen=True)
class Limits(Bounds):
    """Bound the cost of reading: sizes that are checked in the headers, and the parsing process.

    Attributes:
        file_bytes: Largest file [bytes]; 512 MiB is an ASCII PLY of about 8 million vertices, far above any garment.
        count: Largest number of any one kind of element; 20 million keeps the arrays below 1 GB.
        is_confined: Whether this is a limited process: files are then parsed in it instead of in another one.
    """

    file_bytes: int = 512 * 1024**2
    count: int = 20_000_000
    is_confined: bool = False
