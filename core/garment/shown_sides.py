"""Find the side of each face of a garment that a scan shows: that of its outside alone shows the inner side of what is
turned over, and nothing of what that covers."""

from __future__ import annotations

import numpy as np

from ..geometry.geometry import face_normals
from ..geometry.surface import TriangleSurface
from ..scan.contours.turned import MAX_TURNED_DISTANCE
from .creases import mark_turned_faces
from .garment import Garment

MIN_COVERING_COSINE = 0.7
"""Cosine between the normal of covered cloth and the direction to what covers it from which this lies over it [1]: half
a right angle, beyond which it lies beside it."""


def find_shown_sides(garment: Garment, surface: TriangleSurface, normals: np.ndarray) -> np.ndarray:
    """Return the side of each face that a scan shows: 1 the outside, -1 the inner side, 0 none, shape [face_count].

    The outside of all, unless most of what is turned over faces the scan's other side than most of the rest: then the
    scan shows its inner side, and nothing of what lies below it.

    Args:
        garment: The garment, its nodes near the scan.
        surface: The scan's surface.
        normals: Its normals, shape [vertex_count, 3].
    """
    nodes, faces = garment.nodes, garment.faces
    turned = mark_turned_faces(garment)
    if not turned.any():
        return np.ones(len(faces), dtype=np.int64)
    centres, outward = nodes[faces].mean(axis=1), face_normals(nodes, faces)[0]
    facing = (outward * surface.closest(centres).interpolate(normals, surface.faces)).sum(axis=1) > 0.0
    if (facing[turned].mean() > 0.5) == (facing[~turned].mean() > 0.5):
        return np.ones(len(faces), dtype=np.int64)
    over = TriangleSurface(nodes, faces[turned]).closest(centres)
    height = ((over.foot - centres) * outward).sum(axis=1)
    covered = (height > MIN_COVERING_COSINE * over.distance) & (over.distance < MAX_TURNED_DISTANCE)
    return np.where(turned, -1, np.where(covered, 0, 1))


def select_shown_faces(faces: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Return the faces of which a side is shown, that side outwards, shape [n, 3]; in order where all show theirs."""
    return np.ascontiguousarray(np.concatenate([faces[sides > 0], faces[sides < 0][:, ::-1]]), dtype=np.int64)
