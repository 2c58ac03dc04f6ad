"""Describe a raw scan: a whole person's mesh or cloud, cleaned of everything else, not labelled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class RawScan:
    """Describe a raw scan in metres, y up.

    Attributes:
        points: Positions [m], float64, shape [n, 3].
        faces: Triangles between the points, outward, shape [f, 3]; of a cloud none, shape [0, 3].
        normals: Unit normals, shape [n, 3]: of a mesh outward; of a cloud from the file or estimated from neighbours,
            perhaps inward (`is_oriented`). None where they are not estimated yet.
        is_oriented: Whether `normals` are known to point outward.
        colours: RGB in 0..1, shape [n, 3], or None.
        labels: Label of each point, numbers or texts, shape [n], from the file or one beside it, or None.
        origin: Index in the file of each point, int64, shape [n]; of merged points the first.
        place: Index here of the point that represents each point of the file, -1 if dropped, int64, shape [file_count].
        name: The file's stem.
        sha256: Hash of the file's bytes (hex); empty for one made in memory.
        units: Unit of the file: a name of `UNITS`, or `unknown` where the height was assumed or given.
        scale: Metres in one unit of the file.
        up_axis: Axis of the file that became y, with its sign: `y`, `z`, `-y`, `-z`, `x`, `-x`.
        pieces: Number of separate pieces of a person's size, all kept: 2 where two people stand apart.
        notes: What was guessed, removed or repaired, one short sentence each.
    """

    points: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None
    is_oriented: bool
    colours: np.ndarray | None
    labels: np.ndarray | None
    origin: np.ndarray
    place: np.ndarray
    name: str = "scan"
    sha256: str = ""
    units: str = "m"
    scale: float = 1.0
    up_axis: str = "y"
    pieces: int = 1
    notes: tuple[str, ...] = ()

    @property
    def is_cloud(self) -> bool:
        """Return whether there are only points."""
        return len(self.faces) == 0
