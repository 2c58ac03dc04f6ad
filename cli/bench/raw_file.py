"""Read and write a raw scan's PLY file as arrays, without merging or rotation, for the states of a pack."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .packs import PackBad


@dataclass(frozen=True)
class RawFile:
    """Describe the contents of a raw scan's file, in its own unit and axes.

    Attributes:
        points: Positions, float64, shape [n, 3].
        faces: Triangles, shape [m, 3]; for a cloud empty, shape [0, 3].
        normals: Shape [n, 3], or None.
        colours: RGB, uint8, shape [n, 3], or None.
    """

    points: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None = None
    colours: np.ndarray | None = None

    def take(self, kept: np.ndarray) -> RawFile:
        """Return the file with only some points, given by index, and the faces between them."""
        place = np.full(len(self.points), -1, dtype=np.int64)
        place[kept] = np.arange(len(kept))
        faces = place[self.faces]
        return RawFile(
            self.points[kept],
            faces[(faces >= 0).all(axis=1)].reshape(-1, 3),
            None if self.normals is None else self.normals[kept],
            None if self.colours is None else self.colours[kept],
        )


def read_raw_file(path: Path) -> RawFile:
    """Read a mesh or a cloud.

    Raises:
        PackBad: if it is neither.
    """
    import trimesh

    try:
        found: Any = trimesh.load(path, process=False)
        points = np.array(found.vertices, dtype=np.float64)
        faces = np.array(getattr(found, "faces", ()), dtype=np.int64)
        raw = found.metadata["_ply_raw"]["vertex"]["data"]  # trimesh drops a mesh's normals otherwise
        names = raw.dtype.names
        normals = np.stack([raw[name] for name in ("nx", "ny", "nz")], axis=1) if "nx" in names else None
        colours = np.stack([raw[name] for name in ("red", "green", "blue")], axis=1) if "red" in names else None
    except Exception as error:  # trimesh raises whatever its reader raised
        raise PackBad(f"the scan '{path}' cannot be read as a mesh or a cloud.") from error
    return RawFile(
        points,
        faces.reshape(-1, 3),
        None if normals is None else np.asarray(normals, dtype=np.float64),
        None if colours is None else np.asarray(colours, dtype=np.uint8),
    )


def write_raw_file(raw: RawFile, path: Path) -> Path:
    """Write a mesh or a cloud as binary PLY: float positions and normals, bytes for colours."""
    kinds = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
    columns = list(raw.points.T)
    if raw.normals is not None:
        kinds += [("nx", "<f4"), ("ny", "<f4"), ("nz", "<f4")]
        columns += list(raw.normals.T)
    if raw.colours is not None:
        kinds += [("red", "u1"), ("green", "u1"), ("blue", "u1")]
        columns += list(raw.colours.T)
    rows = np.zeros(len(raw.points), dtype=kinds)
    for (name, _), values in zip(kinds, columns, strict=True):
        rows[name] = values
    words = {"<f4": "float", "u1": "uchar"}
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}"]
    header += [f"property {words[kind]} {name}" for name, kind in kinds]
    content = rows.tobytes()
    if len(raw.faces):
        header += [f"element face {len(raw.faces)}", "property list uchar int vertex_indices"]
        corners = np.zeros(len(raw.faces), dtype=[("count", "u1"), ("corners", "<i4", (3,))])
        corners["count"], corners["corners"] = 3, raw.faces
        content += corners.tobytes()
    path.write_bytes("\n".join([*header, "end_header\n"]).encode("ascii") + content)
    return path
