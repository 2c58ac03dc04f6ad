"""Parse OFF files, and the colours of COFF files, which trimesh ignores."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from .columns import as_bytes


def load_off(path: Path) -> dict[str, Any]:
    """Load positions and faces of an OFF file and, where each row of a COFF has one, the colours of its vertices."""
    from trimesh.exchange.off import load_off as load

    content = path.read_bytes()
    loaded: dict[str, Any] = load(io.BytesIO(content))
    rows = [line.split(b"#", 1)[0].split() for line in content.splitlines()]
    rows = [row for row in rows if row]
    if rows[0][0].upper() == b"COFF":
        first = 2 if len(rows[0]) == 1 else 1  # the counts may follow the word
        colours = read_colours(rows[first : first + len(loaded["vertices"])])
        if colours is not None:
            loaded["vertex_colors"] = colours
    return loaded


def read_colours(rows: list[list[bytes]]) -> np.ndarray | None:
    """Read the colour after the three coordinates of each row, as bytes, shape [n, 3]; None where a row has none.

    Whole numbers are 0 to 255 and others 0 to 1 (Geomview's object file format); a fourth, the opacity, is dropped.
    """
    if not rows or min(len(row) for row in rows) < 6:
        return None
    words = [row[3:6] for row in rows]
    values = np.array(words, dtype=np.float64)
    is_whole = not any(b"." in word or b"e" in word.lower() for row in words for word in row)
    return as_bytes(values.astype(np.int64) if is_whole else values)
