"""Find faces of a mesh that intersect each other, and undo the steps that make them intersect."""

from __future__ import annotations

import numpy as np

from ..run.kernels import kernel

MAX_UNDO_ITERATIONS = 12
"""Largest number of iterations that undo crossing steps; an undone node may cross a neighbour that moved on."""

HALVING_ITERATIONS = 3
"""Number of first iterations that halve crossing steps, and of last ones that undo them altogether."""

MAX_RETESTED_SHARE = 0.5
"""Largest share of faces that are tested one by one against the rest; of more all pairs are tested anew."""


def self_intersections(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Find the faces that intersect a face with which they share no vertex.

    Boxes are swept along the mesh's longest axis; two triangles intersect when an edge of one passes through the inside
    of the other. Coplanar overlaps and mere touching do not count.

    Args:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: Vertex indices, shape [face_count, 3].

    Returns:
        Indices of the faces in at least one intersecting pair, ascending.
    """
    pairs = intersecting_pairs(vertices, faces)
    return np.unique(pairs)


def intersecting_pairs(vertices: np.ndarray, faces: np.ndarray, changed: np.ndarray | None = None) -> np.ndarray:
    """List the intersecting pairs of faces that share no vertex, shape [pair_count, 2]; with `changed`, shape
    [face_count], only pairs of which a face is among these."""
    if len(faces) == 0:
        return np.zeros((0, 2), dtype=np.int64)
    vertices = np.asarray(vertices, dtype=np.float64)
    low, high = face_boxes(vertices, faces)
    axis = int(np.argmax(high.max(axis=0) - low.min(axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    axes = [axis, (axis + 1) % 3, (axis + 2) % 3]
    low, high = low[order][:, axes], high[order][:, axes]  # in the order of the sweep, which reads them one by one
    ordered = np.asarray(faces, dtype=np.int64)[order]
    corners = vertices[ordered]
    if changed is None:
        found = order[_sweep(corners, ordered, low, high)]
    else:
        found = order[_sweep_changed(corners, ordered, low, high, changed[order])]
    return np.stack([found.min(axis=1), found.max(axis=1)], axis=1)


class CrossingTracker:
    """Track the intersecting pairs of faces of a mesh whose vertices move: where few moved, only their faces are
    tested against the rest.

    Args:
        faces: Vertex indices, shape [face_count, 3].
    """

    def __init__(self, faces: np.ndarray) -> None:
        self._faces = faces
        self._vertices = np.zeros((0, 3))
        self._pairs = np.zeros((0, 2), dtype=np.int64)

    def find_pairs(self, vertices: np.ndarray) -> np.ndarray:
        """Return the pairs at positions [m], shape [vertex_count, 3], as `intersecting_pairs` does, in another
        order."""
        changed = None
        if len(self._vertices) == len(vertices):
            changed = (vertices != self._vertices).any(axis=1)[self._faces].any(axis=1)
        if changed is None or changed.mean() > MAX_RETESTED_SHARE:
            self._pairs = intersecting_pairs(vertices, self._faces)
        elif changed.any():
            kept = self._pairs[~changed[self._pairs].any(axis=1)]
            self._pairs = np.concatenate([kept, intersecting_pairs(vertices, self._faces, changed)])
        self._vertices = np.array(vertices)
        return self._pairs

    def find_faces(self, vertices: np.ndarray) -> np.ndarray:
        """Return the faces that intersect others at positions [m], as `self_intersections` does."""
        return np.unique(self.find_pairs(vertices))


def face_boxes(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest coordinates of faces [m], shape [face_count, 3] each. Computed corner by
    corner, in a fifth of the time of a reduction over an axis of three."""
    first, second, third = (vertices[faces[:, k]] for k in range(3))
    return np.minimum(np.minimum(first, second), third), np.maximum(np.maximum(first, second), third)


def undo_crossings(
    nodes: np.ndarray, before: np.ndarray, faces: np.ndarray, crossed: np.ndarray, room: np.ndarray | None = None
) -> np.ndarray:
    """Shorten, in place, the moves of the nodes of faces that have crossed in a step; return the faces that cross.

    They are halved, and where that is not enough, clamped to each node's free distance: what was apart remains so, and
    a bundle of layers still moves slowly. With steps undone altogether it would never move again.

    Args:
        nodes: Positions after the step [m], shape [node_count, 3].
        before: Positions before it.
        faces: Shape [face_count, 3].
        crossed: Faces that crossed before.
        room: Distance that each node may move without a crossing [m], shape [node_count]; None: 0.
    """
    tracker = CrossingTracker(faces)
    found = tracker.find_faces(nodes)
    for turn in range(MAX_UNDO_ITERATIONS):
        fresh = np.setdiff1d(found, crossed)
        if not len(fresh):
            break
        back = np.unique(faces[fresh])
        if turn > 3 and np.array_equal(nodes[back], before[back]):
            break  # nothing is left to be undone
        move = nodes[back] - before[back]
        if turn < HALVING_ITERATIONS:
            move *= 0.5
        elif room is None or turn >= MAX_UNDO_ITERATIONS - HALVING_ITERATIONS:
            move *= 0.0
        else:
            move *= np.minimum(1.0, room[back] / np.maximum(np.linalg.norm(move, axis=1), 1e-12))[:, None]
        nodes[back] = before[back] + move
        found = tracker.find_faces(nodes)
    return found


@kernel()
def _sweep(corners: np.ndarray, faces: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Test every pair of overlapping boxes, in ascending order of `low[:, 0]`."""
    pairs = np.zeros((64, 2), np.int64)
    count = 0
    for i in range(low.shape[0]):
        y, z = low[i, 1], low[i, 2]
        x_end, y_end, z_end = high[i]
        for j in range(i + 1, low.shape[0]):
            if low[j, 0] > x_end:
                break
            if (low[j, 1] > y_end) | (y > high[j, 1]) | (low[j, 2] > z_end) | (z > high[j, 2]):
                continue
            if _adjacent(faces[i], faces[j]):
                continue
            if _crosses(corners[i], corners[j]) or _crosses(corners[j], corners[i]):
                pairs, count = _append_pair(pairs, count, i, j), count + 1
    return pairs[:count]


@kernel()
def _sweep_changed(
    corners: np.ndarray, faces: np.ndarray, low: np.ndarray, high: np.ndarray, changed: np.ndarray
) -> np.ndarray:
    """Test the pairs of overlapping boxes of which one is of a changed face; arguments as those of `_sweep`."""
    pairs = np.zeros((64, 2), np.int64)
    count, longest = 0, (high[:, 0] - low[:, 0]).max()
    for i in np.flatnonzero(changed):
        x, y, z = low[i]
        x_end, y_end, z_end = high[i]
        for j in range(np.searchsorted(low[:, 0], x - longest), low.shape[0]):
            if low[j, 0] > x_end:
                break
            if (x > high[j, 0]) | (low[j, 1] > y_end) | (y > high[j, 1]) | (low[j, 2] > z_end) | (z > high[j, 2]):
                continue
            if i == j or (changed[j] and j < i) or _adjacent(faces[i], faces[j]):
                continue
            if _crosses(corners[i], corners[j]) or _crosses(corners[j], corners[i]):
                pairs, count = _append_pair(pairs, count, i, j), count + 1
    return pairs[:count]


@kernel()
def _append_pair(pairs: np.ndarray, count: int, first: int, second: int) -> np.ndarray:
    """Return the pairs, of which `count` are in use, with another one; twice as many rows where all are in use."""
    if count == pairs.shape[0]:
        pairs = np.concatenate((pairs, np.zeros_like(pairs)))
    pairs[count, 0], pairs[count, 1] = first, second
    return pairs


@kernel()
def _adjacent(first: np.ndarray, second: np.ndarray) -> bool:
    """Check whether two faces share a vertex."""
    for p in first:
        for q in second:
            if p == q:
                return True
    return False


@kernel()
def _crosses(first: np.ndarray, second: np.ndarray) -> bool:
    """Check whether an edge of the first triangle passes through the inside of the second."""
    for k in range(3):
        start = first[k]
        end = first[(k + 1) % 3]
        below = _volume(second[0], second[1], second[2], start)
        above = _volume(second[0], second[1], second[2], end)
        if below * above >= 0.0:
            continue
        one = _volume(start, end, second[0], second[1])
        two = _volume(start, end, second[1], second[2])
        three = _volume(start, end, second[2], second[0])
        if (one > 0.0 and two > 0.0 and three > 0.0) or (one < 0.0 and two < 0.0 and three < 0.0):
            return True
    return False


@kernel()
def _volume(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> float:
    """Return six times the signed volume of a tetrahedron."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    wx, wy, wz = d[0] - a[0], d[1] - a[1], d[2] - a[2]
    found: float = ux * (vy * wz - vz * wy) - uy * (vx * wz - vz * wx) + uz * (vx * wy - vy * wx)
    return found
