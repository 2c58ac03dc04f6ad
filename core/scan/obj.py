"""Parse OBJ files: positions, polygons, vertex colours, and where each face takes its texture from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import refusal
from .columns import as_bytes


@dataclass(frozen=True)
class ObjContent:
    """Describe the content of an OBJ file.

    Attributes:
        vertices: Positions, shape [n, 3].
        colours: RGB bytes of the vertices, shape [n, 3], or None.
        corners: Vertices of the polygons' corners in order, shape [c].
        places: Texture coordinate of each corner, -1 for none, shape [c]; [0] where textures are not read.
        sizes: Number of corners of each polygon, shape [p].
        material: Index in `materials` of each polygon, shape [p].
        uv: Texture coordinates from the lower left corner, shape [t, 2].
        materials: Names of the materials in the order of their use, the first empty.
        libraries: Names of the material files.
    """

    vertices: np.ndarray
    colours: np.ndarray | None
    corners: np.ndarray
    places: np.ndarray
    sizes: np.ndarray
    material: np.ndarray
    uv: np.ndarray
    materials: tuple[str, ...]
    libraries: tuple[str, ...]

    def fans(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the polygons as fans: the corners of each triangle, shape [f, 3], and its polygon, shape [f]."""
        counts = self.sizes - 2
        polygon = np.repeat(np.arange(len(self.sizes)), counts)
        first = (np.cumsum(self.sizes) - self.sizes)[polygon]
        second = first + 1 + np.arange(len(polygon)) - (np.cumsum(counts) - counts)[polygon]
        return np.stack([first, second, second + 1], axis=1), polygon


def read_obj(path: Path, textures: bool) -> ObjContent:
    """Read an OBJ file.

    Trimesh's parser is not used: it drops wrong indices silently and splits vertices at texture seams. A negative index
    counts back from the last element, as the format defines; zero or an index of a vertex before the first is refused.

    Args:
        path: The file.
        textures: Whether texture coordinates and materials are read.

    Raises:
        IndicesBroken, Unreadable: where a face or a vertex is broken.
    """
    rows: list[list[float]] = []
    uv: list[list[float]] = []
    corners: list[int] = []
    places: list[int] = []
    sizes: list[int] = []
    material: list[int] = []
    materials, libraries = [""], []
    with path.open("r", encoding="utf-8", errors="replace") as file:
        for line in file:
            if line.startswith(("v ", "v\t")):
                rows.append([float(word) for word in line.split()[1:7]])
            elif line.startswith(("f ", "f\t")):
                words = line.split("#", 1)[0].split()[1:]
                face = _from_zero([int(word.split("/", 1)[0]) for word in words], len(rows))
                if len(face) < 3:
                    raise refusal.IndicesBroken("a face has fewer than three corners")
                if min(face) < 0:
                    raise refusal.IndicesBroken(f"face '{line.strip()[:60]}' refers to a vertex that does not exist")
                corners += face
                if textures:
                    places += _from_zero([int((word + "/").split("/", 2)[1] or 0) for word in words], len(uv))
                sizes.append(len(face))
                material.append(len(materials) - 1)
            elif textures and line.startswith("vt"):
                uv.append([float(word) for word in (*line.split()[1:3], "0")[:2]])
            elif textures and line.startswith("mtllib"):
                libraries.append(line[6:].strip())
            elif textures and line.startswith("usemtl"):
                materials.append(line[6:].strip())
    width = min((len(row) for row in rows), default=3)
    if width < 3:
        raise refusal.Unreadable("a vertex has fewer than three coordinates")
    table = np.array([row[: 6 if width == 6 else 3] for row in rows], np.float64).reshape(len(rows), -1)
    return ObjContent(
        table[:, :3].copy(),
        as_bytes(table[:, 3:6]) if width == 6 else None,
        np.array(corners, np.int64),
        np.array(places, np.int64),
        np.array(sizes, np.int64),
        np.array(material, np.int64),
        np.array(uv, np.float64).reshape(len(uv), 2),
        tuple(materials),
        tuple(libraries),
    )


def _from_zero(indices: list[int], count: int) -> list[int]:
    """Return indices from 0 for ones from 1 or, if negative, back from the last of `count`; below 0 for none."""
    return [index - 1 if index > 0 else count + index if index < 0 else -1 for index in indices]
