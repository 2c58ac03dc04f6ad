"""Read the binary PLY files that `core.deliver.export` writes: doubles and colours of each vertex, triangles."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

MAX_PLY_HEADER_BYTES = 4096
"""Largest header of such a file [bytes]; ours are below 500."""

_PROPERTY = re.compile(rb"property (double|uchar) (\w+)\n")
_COLOURS = ("red", "green", "blue")


class PlyBad(ValueError):
    """The content is not a PLY that `write_ply` wrote."""


@dataclass(frozen=True)
class PlyMesh:
    """Describe one mesh.

    Attributes:
        vertices: Positions [m], float64, shape [n, 3].
        faces: Vertex indices, int32, shape [m, 3]; of a cloud none.
        values: Further numbers of each vertex by name, float64, shape [n] each.
        colours: RGB bytes, shape [n, 3], or None.
    """

    vertices: np.ndarray
    faces: np.ndarray
    values: dict[str, np.ndarray]
    colours: np.ndarray | None


def read_ply(content: bytes) -> PlyMesh:
    """Read a mesh.

    Raises:
        PlyBad: where the content is something else, or incomplete.
    """
    head, mark, _ = content[:MAX_PLY_HEADER_BYTES].partition(b"end_header\n")
    vertices, faces = head.partition(b"element face ")[::2]
    count, face_count = re.search(rb"element vertex (\d+)\n", vertices), re.match(rb"(\d+)\n", faces)
    kinds = {name.decode(): "<f8" if kind == b"double" else "u1" for kind, name in _PROPERTY.findall(vertices)}
    if not mark or not head.startswith(b"ply\nformat binary_little_endian") or count is None or face_count is None:
        raise PlyBad("not a PLY of ours")
    row, corner = np.dtype(list(kinds.items())), np.dtype([("count", "u1"), ("corners", "<i4", (3,))])
    begin = len(head) + len(mark)
    middle = begin + row.itemsize * int(count[1])
    if not {"x", "y", "z"} <= kinds.keys() or len(content) != middle + corner.itemsize * int(face_count[1]):
        raise PlyBad("the file is cut off")
    rows = np.frombuffer(content[begin:middle], row)
    corners = np.frombuffer(content[middle:], corner)["corners"]
    found = np.stack([rows[axis] for axis in "xyz"], axis=1)
    values = {name: rows[name] for name, kind in kinds.items() if kind == "<f8" and name not in ("x", "y", "z")}
    has_colours = set(_COLOURS) <= kinds.keys()
    return PlyMesh(found, corners, values, np.stack([rows[c] for c in _COLOURS], axis=1) if has_colours else None)
