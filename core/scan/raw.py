"""A whole person as the scanner gave it: a mesh or a cloud, cleaned of what is no person, nothing told apart yet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class RawScan:
    """A raw scan in metres, y up.

    Attributes:
        points: Positions [m], float64, shape [n, 3].
        faces: Triangles between the points, outward, shape [f, 3]; of a cloud none, shape [0, 3].
        normals: Unit normals, shape [n, 3]: of a mesh outward; of a cloud as the file has them or from neighbours, and
            then perhaps inward, `is_oriented` tells. None where there are none yet.
        is_oriented: Whether `normals` are known to point outward.
        colours: RGB in 0..1, shape [n, 3], or None.
        labels: Label of each point, numbers or texts, shape [n], where the file or one beside it has them, or None.
        origin: Index in the file of each point, int64, shape [n]; several file points may have been merged into one,
            `place` says which.
        place: For each point of the file the point here that stands for it, or -1 where it was dropped, int64, shape
            [file_count].
        name: The file's stem.
        sha256: Hash of the file's bytes (hex); empty for one made in memory.
        units: Unit of the file: a name of `UNITS`, or `unknown` where the height was assumed.
        up_axis: Axis of the file that became y, with its sign: `y`, `z`, `-y`, `-z`, `x`, `-x`.
        pieces: Separate pieces of a person's size beside each other, all kept: 2 where two people stand apart.
        notes: What was guessed, removed or mended, one short sentence each.
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
    up_axis: str = "y"
    pieces: int = 1
    notes: tuple[str, ...] = ()

    @property
    def is_cloud(self) -> bool:
        """Return whether there are only points."""
        return len(self.faces) == 0
