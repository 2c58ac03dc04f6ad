"""Check a polish: it may add neither flipped nor crossing faces."""

from __future__ import annotations

import numpy as np

from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import face_normals
from ...geometry.intersections import self_intersections
from .target_repair import PreparedTarget

MAX_REVERT_ITERATIONS = 4
"""Largest number of iterations that revert faulty places to before the polish; then the whole polish is refused."""

REVERT_RING_COUNT = 4
"""Number of face rings over which a reverted place fades out, in the first iteration; it doubles in each next one."""


def accept_polish(
    finer: np.ndarray, before: np.ndarray, faces: np.ndarray, target: PreparedTarget
) -> tuple[np.ndarray, bool]:
    """Keep a polish where it adds no faults.

    Around faces that flip or cross after the polish only, the nodes fade back to where they were. If flips or crossings
    still outnumber the former ones after four rounds, nothing of the polish is kept.

    Args:
        finer: Polished nodes [m], shape [node_count, 3].
        before: Nodes before the polish [m], shape [node_count, 3].
        faces: Shape [face_count, 3].
        target: Its normals define which faces are flipped.

    Returns:
        The nodes, and whether any of the polish is in them.
    """
    if not np.isfinite(finer).all():
        return before, False
    was_flipped, was_crossing = find_flipped_faces(before, faces, target), find_crossing_faces(before, faces)
    back = np.zeros(len(before))
    x = finer
    for turn in range(MAX_REVERT_ITERATIONS):
        now_flipped, now_crossing = find_flipped_faces(x, faces, target), find_crossing_faces(x, faces)
        if now_flipped.sum() <= was_flipped.sum() and now_crossing.sum() <= was_crossing.sum():
            return x, True
        wrong = (now_flipped & ~was_flipped) | (now_crossing & ~was_crossing)
        back = np.maximum(back, falloff_weights(wrong, faces, len(before), REVERT_RING_COUNT * 2**turn))
        x = finer + back[:, None] * (before - finer)
    return before, False


def find_flipped_faces(nodes: np.ndarray, faces: np.ndarray, target: PreparedTarget) -> np.ndarray:
    """Return which faces point against the target at the point closest to their centre, shape [face_count]."""
    found = target.surface.closest(nodes[faces].mean(axis=1))
    cosine = (face_normals(nodes, faces)[0] * found.interpolate(target.normals, target.surface.faces)).sum(1)
    cosine *= target.sides
    return np.zeros(len(faces), dtype=bool) if target.unsigned else cosine < 0


def find_crossing_faces(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return which faces intersect a non-adjacent face, shape [face_count]."""
    wrong = np.zeros(len(faces), dtype=bool)
    wrong[self_intersections(nodes, faces)] = True
    return wrong


def falloff_weights(wrong: np.ndarray, faces: np.ndarray, count: int, rings: int) -> np.ndarray:
    """Return weights, 1 at the nodes of wrong faces and their first ring, falling linearly to 0 over `rings`."""
    reach = np.zeros(count)
    reach[faces[wrong]] = 1.0
    edges = HalfEdges.of(faces, count).edges
    level = reach.copy()
    for ring in range(rings):
        grown = reach.copy()
        np.maximum.at(grown, edges[:, 0], reach[edges[:, 1]])
        np.maximum.at(grown, edges[:, 1], reach[edges[:, 0]])
        level = np.maximum(level, grown * (1 - max(ring, 0) / rings))
        reach = grown
    return level
