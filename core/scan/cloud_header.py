"""Check the declared content of point clouds: the header of a PCD, and the first rows of an XYZ."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from .head import read_head
from .refusal import ContentMismatch, FileTruncated, HeaderBroken

_TYPES = {
    ("F", 4): "<f4", ("F", 8): "<f8", ("I", 1): "<i1", ("I", 2): "<i2", ("I", 4): "<i4", ("I", 8): "<i8",
    ("U", 1): "<u1", ("U", 2): "<u2", ("U", 4): "<u4", ("U", 8): "<u8",
}  # fmt: skip
_DATA = re.compile(rb"(?m)^DATA[ \t]+(\w+)[ \t]*\r?\n")
_FIRST_ROWS = 20
"""Number of rows of an XYZ that are checked."""
_ROW_BYTES = 4096
"""Largest number of bytes of a point of a PCD; more are descriptors of hundreds of numbers beside the position."""
_ENCODINGS = ("ascii", "binary", "binary_compressed")


@dataclass(frozen=True)
class PcdHeader:
    """Describe the data of a PCD file.

    Attributes:
        names: Names of the fields, in the file's order.
        types: numpy's type of each field.
        counts: Number of values per point of each field.
        points: Number of points.
        encoding: `ascii`, `binary` or `binary_compressed`.
        start: Offset of the data [bytes].
    """

    names: tuple[str, ...]
    types: tuple[str, ...]
    counts: tuple[int, ...]
    points: int
    encoding: str
    start: int

    @property
    def row_bytes(self) -> int:
        """Return the bytes of one point."""
        return sum(int(kind[2:]) * count for kind, count in zip(self.types, self.counts, strict=True))


def read_pcd_header(path: Path) -> PcdHeader:
    """Read the header of a PCD file.

    Raises:
        ContentMismatch, HeaderBroken: where there is none, or it is not understood.
    """
    name, head = path.name, read_head(path, _DATA)
    end = _DATA.search(head)
    if end is None or re.search(rb"(?m)^FIELDS[ \t]", head[: end.start()]) is None:
        raise ContentMismatch(f"{name} does not begin like a PCD file; export the scan again or rename the file.")
    entries: dict[str, list[str]] = {}
    for line in head[: end.start()].decode("latin-1").splitlines():
        words = line.split("#", 1)[0].split()
        if words:
            entries[words[0]] = words[1:]
    try:
        names = tuple(entries["FIELDS"])
        sizes = [int(word) for word in entries["SIZE"]]
        kinds = entries["TYPE"]
        counts = tuple(int(word) for word in entries.get("COUNT", ["1"] * len(names)))
        points = int(entries["POINTS"][0]) if "POINTS" in entries else _area(entries)
        types = tuple(_TYPES[kind, size] for kind, size in zip(kinds, sizes, strict=True))
        encoding = end.group(1).decode()
        if not len(names) == len(types) == len(counts) or min(counts) < 1 or points < 0:
            raise ValueError("counts differ")
        if encoding not in _ENCODINGS or ("WIDTH" in entries and _area(entries) != points):
            raise ValueError("counts differ")
    except (KeyError, ValueError, IndexError) as error:
        raise HeaderBroken(f"{name}: the PCD header is not understood; export the scan again.") from error
    if not {"x", "y", "z"} <= set(names) or any(counts[names.index(axis)] != 1 for axis in "xyz"):
        raise HeaderBroken(f"{name}: the PCD header names no x, y and z; export positions.")
    header = PcdHeader(names, types, counts, points, encoding, end.end())
    if header.row_bytes > _ROW_BYTES:
        raise HeaderBroken(f"{name}: a point has {header.row_bytes} bytes; export fewer fields.")
    return header


def _area(entries: dict[str, list[str]]) -> int:
    return int(entries["WIDTH"][0]) * int(entries["HEIGHT"][0])


def check_pcd(path: Path, size: int) -> int:
    """Check that a PCD file is long enough for the points that it declares; return their number.

    Raises:
        BadInput: where it is not.
    """
    header = read_pcd_header(path)
    left = size - header.start
    if header.encoding == "binary":
        needed = header.points * header.row_bytes
    elif header.encoding == "ascii":
        needed = header.points * 2 * sum(header.counts) - 1  # a digit and a separator for each number
    else:
        needed = _compressed_bytes(path, header)
    if needed > left:
        raise FileTruncated(f"{path.name} needs at least {needed} bytes of data and holds {left}; copy it again.")
    return header.points


def _compressed_bytes(path: Path, header: PcdHeader) -> int:
    """Return the size of compressed data, after a check of its two counts (LZF expands 3 bytes to 264 at most)."""
    with path.open("rb") as file:
        file.seek(header.start)
        words = file.read(8)
    packed, whole = int.from_bytes(words[:4], "little"), int.from_bytes(words[4:], "little")
    if len(words) < 8 or whole != header.points * header.row_bytes or whole > 88 * packed:
        raise HeaderBroken(f"{path.name}: the sizes of its compressed data do not agree; export the scan again.")
    return 8 + packed


def check_xyz(path: Path, head: bytes) -> None:
    """Check that a file, whose first bytes are `head`, begins with rows of at least three numbers.

    Raises:
        ContentMismatch: where it does not.
    """
    rows: list[str] = []
    if b"\0" not in head:
        with path.open("r", encoding="latin-1") as file:
            rows = list(islice((line for line in file if line.strip() and line[0] not in "#/"), _FIRST_ROWS + 1))
    rows = rows[1:] if rows and len(rows[0].split()) == 1 and rows[0].strip().isdigit() else rows  # their number
    try:
        if not rows or min(len([float(word) for word in split_row(row)]) for row in rows) < 3:
            raise ValueError("short")
    except ValueError as error:
        raise ContentMismatch(
            f"{path.name} does not begin with rows of numbers x y z; export the scan again or rename the file."
        ) from error


def split_row(row: str) -> list[str]:
    """Split a row at blanks, commas and semicolons."""
    return row.replace(",", " ").replace(";", " ").split()
