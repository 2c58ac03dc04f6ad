"""Map each texel of a texture to a place in a face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.connectivity import HalfEdges

TEXEL_CHUNK_SIZE = 4_000_000
"""Number of pairs of texel and face that are tested together: 0.5 GB at most."""

TEXEL_BARYCENTRIC_TOLERANCE = 1e-9
"""Largest negative barycentric coordinate [1] of a texel in a face, without sign: a texel on an edge is in one face."""


@dataclass(frozen=True)
class Texels:
    """Describe the texels of a square texture that show cloth, or the ground beside its border.

    Attributes:
        row: Row from the top, shape [n].
        column: Column from the left, shape [n].
        face: Face, shape [n].
        barycentric: Place of the texel's centre in the face, shape [n, 3]; below 0 beside the border.
        inside: True on cloth, False beside its border, shape [n].
    """

    row: np.ndarray
    column: np.ndarray
    face: np.ndarray
    barycentric: np.ndarray
    inside: np.ndarray


def find_texels(flat: np.ndarray, faces: np.ndarray, size: int, border_width: float) -> Texels:
    """Find the texels whose centres are in a face, and those outside near the border, in the extended border face.

    The centre of texel (row, column) is u = (column + 1/2) / size, v = 1 - (row + 1/2) / size.

    Args:
        flat: Coordinates within 0..1, shape [n, 2]; no two faces overlap, and all run counter-clockwise.
        faces: Indices into `flat`, shape [m, 3].
        size: Texels of a side.
        border_width: Distance from the border up to which texels are found [texel].

    Returns:
        The texels, row after row.
    """
    place = np.stack([flat[:, 0] * size - 0.5, (1.0 - flat[:, 1]) * size - 0.5], axis=1)  # (column, row)
    owner = np.full(size * size, -1, dtype=np.int64)
    corners = place[faces]
    low, high = np.ceil(corners.min(axis=1) - 1e-9), np.floor(corners.max(axis=1) + 1e-9)
    for boxes, cell in _cells(low, high, size):
        weights = _barycentric_coordinates(corners[boxes], cell)
        contained = (weights >= -TEXEL_BARYCENTRIC_TOLERANCE).all(axis=1)
        owner[cell[contained, 1].astype(np.int64) * size + cell[contained, 0].astype(np.int64)] = boxes[contained]
    inside = owner >= 0
    best_distance = np.full(size * size, np.inf)
    half = HalfEdges.of(faces, len(flat))
    border = np.flatnonzero(half.twin < 0)
    tail, head = place[half.tail[border]], place[half.head[border]]
    low, high = np.minimum(tail, head) - border_width, np.maximum(tail, head) + border_width
    for boxes, cell in _cells(np.ceil(low), np.floor(high), size):
        index = cell[:, 1].astype(np.int64) * size + cell[:, 0].astype(np.int64)
        distance = _distance(cell, tail[boxes], head[boxes])
        kept = ~inside[index] & (distance <= border_width)
        index, distance, boxes = index[kept], distance[kept], boxes[kept]
        order = np.lexsort((boxes, distance))[::-1]  # the nearest is written last
        order = order[distance[order] < best_distance[index[order]]]
        best_distance[index[order]] = distance[order]
        owner[index[order]] = border[boxes[order]] // 3
    found = np.flatnonzero(owner >= 0)
    row, column = found // size, found % size
    weights = _barycentric_coordinates(corners[owner[found]], np.stack([column, row], axis=1).astype(np.float64))
    return Texels(row, column, owner[found], weights, inside[found])


def _cells(low: np.ndarray, high: np.ndarray, size: int):  # type: ignore[no-untyped-def]
    """Yield, in chunks of boxes, the box and the (column, row) of each whole cell in them."""
    low, high = np.clip(low, 0, size - 1), np.clip(high, 0, size - 1)
    width = (high - low + 1).astype(np.int64)
    counts = np.where((width > 0).all(axis=1), width.prod(axis=1), 0)
    part = np.cumsum(counts) // TEXEL_CHUNK_SIZE
    for number in np.unique(part):
        boxes = np.flatnonzero(part == number)
        index = np.repeat(boxes, counts[boxes])
        first = np.repeat(np.cumsum(counts[boxes]) - counts[boxes], counts[boxes])
        step = np.arange(len(index)) - first
        wide = width[index, 0]
        yield index, low[index] + np.stack([step % wide, step // wide], axis=1)


def _barycentric_coordinates(corners: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return barycentric coordinates of points, shape [n, 2], each in a triangle of its own, shape [n, 3, 2]."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    whole = _cross(b - a, c - a)
    second, third = _cross(point - a, c - a) / whole, _cross(b - a, point - a) / whole
    return np.stack([1.0 - second - third, second, third], axis=1)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _distance(point: np.ndarray, tail: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Return the distance of points to segments, shape [n]."""
    along = head - tail
    share = np.einsum("ij,ij->i", point - tail, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-30)
    return np.asarray(np.linalg.norm(point - tail - np.clip(share, 0.0, 1.0)[:, None] * along, axis=1))
