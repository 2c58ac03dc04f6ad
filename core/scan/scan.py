"""The checked surface that everything after the file works on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Scan:
    """Hold one checked triangle mesh in metres, y up, faces outward and counter-clockwise.

    Attributes:
        vertices: Positions [m], float64, shape [vertex_count, 3].
        faces: Vertex indices, int64, shape [face_count, 3].
        name: The file's stem, for people.
        sha256: Hash of the file's bytes (hex); empty for a mesh made in memory.
        units: Unit of the file, `m`, `cm` or `mm`.
        up_axis: Axis of the file that became y, `y` or `z`.
        colours: RGB in 0..1, shape [vertex_count, 3], or None.
        labels: Integer label of each vertex, shape [vertex_count], or None.
        unseen: True at vertices where the scanner saw nothing beyond, of a garment cut out of a dressed person's scan,
            shape [vertex_count]; None: unknown.
        repairs: What was mended, one short sentence each.
    """

    vertices: np.ndarray
    faces: np.ndarray
    name: str = "mesh"
    sha256: str = ""
    units: str = "m"
    up_axis: str = "y"
    colours: np.ndarray | None = None
    labels: np.ndarray | None = None
    repairs: tuple[str, ...] = ()
    unseen: np.ndarray | None = None
