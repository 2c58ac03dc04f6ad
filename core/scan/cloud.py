"""Parse point clouds: PCD in its three encodings, and rows of numbers (XYZ)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from . import refusal
from .cloud_header import PcdHeader, read_pcd_header
from .columns import are_whole, as_bytes, find_labels

_BLANKS = str.maketrans(",;", "  ")
XYZ_COLUMN_COUNTS = (3, 4, 6, 7, 9, 10)
"""Accepted numbers of values in a row of an XYZ file: position, then optionally an intensity, a colour and a normal."""
UNIT_SLACK = 0.05
"""Deviation [1] of a length from 1 up to which three numbers are a normal; rounding to two digits leaves 0.01."""


def parse_pcd(path: Path) -> dict[str, np.ndarray]:
    """Parse a PCD file into `vertices`, `faces` (none), and where it has them `normals`, `colours` and `labels`.

    Points without a position (NaN, in organised clouds) are kept; the caller drops them.
    """
    header = read_pcd_header(path)
    with path.open("rb") as file:
        file.seek(header.start)
        if header.encoding == "ascii":
            columns = _read_ascii(header, file.read().decode("latin-1"))
        elif header.encoding == "binary":
            columns = _read_rows(header, file.read(header.points * header.row_bytes))
        else:
            columns = _read_compressed(header, file.read())
    return _sort_columns(columns, header.points)


def _read_ascii(header: PcdHeader, text: str) -> dict[str, np.ndarray]:
    width = sum(header.counts)
    table = np.loadtxt(text.splitlines(), dtype=np.float64, comments=None, ndmin=2)
    if table.shape != (header.points, width):
        shape = " x ".join(str(side) for side in table.shape)
        raise refusal.CountsDiffer(f"{header.points} x {width} numbers are declared, and {shape} are held")
    first = np.cumsum((0, *header.counts))
    return {
        name: table[:, start].astype(kind) if kind[1] == "f" else table[:, start].astype(np.int64).astype(kind)
        for name, kind, start in zip(header.names, header.types, first[:-1].tolist(), strict=True)
        if name != "_"
    }


def _read_rows(header: PcdHeader, content: bytes) -> dict[str, np.ndarray]:
    pairs = zip(header.types, header.counts, strict=True)
    kind = np.dtype([(f"{i}", kind, (count,)) for i, (kind, count) in enumerate(pairs)])
    rows = np.frombuffer(content, dtype=kind, count=header.points)
    return {name: rows[f"{i}"][:, 0] for i, name in enumerate(header.names) if name != "_"}


def _read_compressed(header: PcdHeader, content: bytes) -> dict[str, np.ndarray]:
    """Read LZF-compressed data, which are stored field by field."""
    packed, whole = int.from_bytes(content[:4], "little"), int.from_bytes(content[4:8], "little")
    data = unpack_lzf(content[8 : 8 + packed], whole)
    columns, start = {}, 0
    for name, kind, count in zip(header.names, header.types, header.counts, strict=True):
        values = np.frombuffer(data, dtype=kind, count=header.points * count, offset=start)
        start += values.nbytes
        if name != "_":
            columns[name] = values.reshape(header.points, count)[:, 0]
    return columns


def unpack_lzf(packed: bytes, size: int) -> bytes:
    """Decompress LZF data of `size` bytes.

    A byte below 32 is followed by one more literal than its value; else its upper three bits are a length (7: the next
    byte is added), and the lower five with the byte after it the distance back (M. Lehmann's format).

    Raises:
        Unreadable: where the stream is broken.
    """
    out = bytearray()
    at, end = 0, len(packed)
    try:
        while at < end:
            control = packed[at]
            at += 1
            if control < 32:
                out += packed[at : at + control + 1]
                if at + control + 1 > end:
                    raise IndexError("cut")
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += packed[at]
                at += 1
            start = len(out) - ((control & 31) << 8) - packed[at] - 1
            at += 1
            length += 2
            if start < 0 or len(out) > size:
                raise IndexError("beyond")
            if start + length <= len(out):
                out += out[start : start + length]
            else:
                piece = out[start:]
                out += (piece * (length // len(piece) + 1))[:length]
    except IndexError as error:
        raise refusal.Unreadable("its compressed data are broken") from error
    if len(out) != size:
        raise refusal.Unreadable("its compressed data are broken")
    return bytes(out)


def _sort_columns(columns: dict[str, np.ndarray], count: int) -> dict[str, np.ndarray]:
    """Return positions, normals, colours and labels by the usual names of PCL's fields."""
    arrays = {
        "vertices": np.stack([columns[axis].astype(np.float64) for axis in "xyz"], axis=1),
        "faces": np.zeros((0, 3), np.int64),
    }
    normal = ("normal_x", "normal_y", "normal_z")
    if set(normal) <= set(columns):
        arrays["normals"] = np.stack([columns[name].astype(np.float64) for name in normal], axis=1)
    packed = columns.get("rgb", columns.get("rgba"))
    if packed is not None and packed.dtype.itemsize == 4:
        word = np.ascontiguousarray(packed).view("<u4")  # 0xAARRGGBB, also where the field is declared as a float
        arrays["colours"] = np.stack([word >> 16 & 255, word >> 8 & 255, word & 255], axis=1).astype(np.uint8)
    elif {"r", "g", "b"} <= set(columns):
        arrays["colours"] = np.stack([np.clip(columns[name], 0, 255) for name in "rgb"], axis=1).astype(np.uint8)
    labels = find_labels(columns, count)
    if labels is not None:
        arrays["labels"] = labels
    return arrays


def parse_xyz(path: Path) -> dict[str, np.ndarray]:
    """Parse rows of numbers: x y z, then optionally a colour (0 to 255, or 0 to 1), a normal, or both in either order.

    Three numbers are a normal where more than nine rows in ten have the length 1, else a colour. In rows of 4, 7 or 10
    numbers one is an intensity, before, between or after these, which is dropped: the first without which the rest are
    colours and normals, or else the fourth. A first row of one number is the count.
    """
    with path.open("r", encoding="latin-1") as file:
        text = file.read()
    lines = [line for line in text.splitlines() if line.strip() and line[0] not in "#/"]
    if lines and len(lines[0].split()) == 1:
        lines = lines[1:]
    if not lines:
        raise refusal.MeshEmpty("it holds no points")
    table = np.loadtxt((line.translate(_BLANKS) for line in lines), dtype=np.float64, comments=None, ndmin=2)
    width = table.shape[1]
    if width not in XYZ_COLUMN_COUNTS:
        raise refusal.Unreadable(f"its rows have {width} numbers, which is none of {XYZ_COLUMN_COUNTS}")
    arrays = {"vertices": table[:, :3].copy(), "faces": np.zeros((0, 3), np.int64)}
    splits = [_split_threes(table[:, 3:])]
    if width in (4, 7, 10):
        splits = [_split_threes(np.delete(table, k, axis=1)[:, 3:]) for k in range(3, width, 3)]
    fitting = (split for split in splits if all(_are_normals(block) or _are_colours(block) for block in split))
    for block in next(fitting, splits[0]):
        name = "normals" if _are_normals(block) and "normals" not in arrays else "colours"
        arrays[name] = block.copy() if name == "normals" else as_bytes(block)
    return arrays


def _split_threes(columns: np.ndarray) -> list[np.ndarray]:
    return [columns[:, k : k + 3] for k in range(0, columns.shape[1], 3)]


def _are_colours(block: np.ndarray) -> bool:
    """Check whether numbers are whole and 0 to 255, or 0 to 1."""
    known = block[np.isfinite(block)]
    if not len(known) or known.min() < 0:
        return False
    return bool(known.max() <= 1 or (known.max() <= 255 and are_whole(known)))


def _are_normals(block: np.ndarray) -> bool:
    finite = block[np.isfinite(block).all(axis=1)]
    length = np.linalg.norm(finite, axis=1)
    return len(finite) > 0 and float((np.abs(length - 1.0) < UNIT_SLACK).mean()) > 0.9
