"""Repair a person's mesh without dropping parts of it, and map the file's points to the result."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.connectivity import HalfEdges
from .repair import MERGE_DISTANCE_SHARE, RepairedMesh, boundary_pieces, mend_surface


@dataclass(frozen=True)
class MendedMesh:
    """Describe repaired points, and perhaps faces, in the file's unit.

    Attributes:
        points: Positions, shape [n, 3].
        faces: Triangles, consistent and outward, shape [f, 3]; of a cloud none, shape [0, 3].
        origin: Index in the file of each point, shape [n].
        place: Index here of the point that represents each point of the file, or -1, shape [file_count].
        notes: What was repaired, one sentence each.
    """

    points: np.ndarray
    faces: np.ndarray
    origin: np.ndarray
    place: np.ndarray
    notes: tuple[str, ...] = ()


def group_points(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Group positions that float32 cannot distinguish.

    Returns:
        First of each group, ascending, shape [g], and the group of each point, shape [n].
    """
    step = MERGE_DISTANCE_SHARE * float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
    keys = np.round((points - points.min(axis=0)) / step).astype(np.int64)  # at most 24 bits each
    _, flat = np.unique(keys[:, 0] << 24 | keys[:, 1], return_inverse=True)
    _, first, group = np.unique(flat.reshape(-1) << 24 | keys[:, 2], return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.zeros(len(first), np.int64)
    rank[order] = np.arange(len(first))
    return first[order], rank[group.reshape(-1)]


def invert_origin(origin: np.ndarray, count: int) -> np.ndarray:
    """Return the first index at which `origin` has each of the values below `count`, or -1, shape [count]."""
    found = np.full(count, -1)
    found[origin[::-1]] = np.arange(len(origin))[::-1]
    return found


def merge_points(points: np.ndarray, finite: np.ndarray) -> MendedMesh:
    """Merge points of a cloud at the same position, and drop those without a position."""
    rows = np.flatnonzero(finite)
    first, group = group_points(points[rows])
    place = np.full(len(points), -1)
    place[rows] = group
    merged = len(rows) - len(first)
    notes = (f"Merged {merged} duplicate point{'s' if merged != 1 else ''}.",) if merged else ()
    return MendedMesh(points[rows[first]], np.zeros((0, 3), np.int64), rows[first], place, notes)


def mend_mesh(points: np.ndarray, faces: np.ndarray) -> MendedMesh:
    """Merge duplicates, drop invalid faces and points in no face, orient each piece outward; small pieces stay."""
    used = np.zeros(len(points), bool)
    used[faces] = True
    rows = np.flatnonzero(used)
    first, group = group_points(points[rows])
    index = np.full(len(points), -1)
    index[rows] = group
    merged = len(rows) - len(first)
    surface = RepairedMesh(points[rows[first]], index[faces], np.arange(len(first)))
    surface = mend_surface(surface)
    faces, number = _turn_pieces(surface.vertices, surface.faces)
    numbers = np.r_[invert_origin(surface.origin, len(first)), -1]
    notes = (f"Merged {merged} duplicate {'vertices' if merged > 1 else 'vertex'}.",) if merged else ()
    turned = (f"Turned {number} piece{'s' if number != 1 else ''} outward.",) if number else ()
    return MendedMesh(
        surface.vertices, faces, rows[first][surface.origin], numbers[index], (*notes, *surface.repairs, *turned)
    )


def _turn_pieces(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, int]:
    """Turn pieces with a negative volume once their openings are closed; return the faces and how many turned."""
    if not len(faces):
        return faces, 0
    edges = HalfEdges.of(faces)
    number, piece = edges.face_pieces
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    volume = np.bincount(piece, np.einsum("ij,ij->i", a, np.cross(b, c)), number)
    rim, opening, means, _ = boundary_pieces(vertices, edges)
    if len(rim):
        owner = np.zeros(len(vertices), np.int64)
        owner[faces.ravel()] = np.repeat(piece, 3)
        lids = np.einsum("ij,ij->i", vertices[rim[:, 1]], np.cross(vertices[rim[:, 0]], means[opening]))
        volume += np.bincount(owner[rim[:, 0]], lids, number)
    wrong = volume < 0.0
    faces = faces.copy()
    faces[wrong[piece]] = faces[wrong[piece]][:, ::-1]
    return faces, int(wrong.sum())
