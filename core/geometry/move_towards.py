"""Move a mesh towards given places as far as it does not intersect itself."""

from __future__ import annotations

import numpy as np

from .intersections import CrossingTracker

MAX_MOVE_STEP_LENGTH = 5e-4
"""Largest motion of a vertex in one iteration [m]; the distance of layers that meet is then less than twice this."""

CROSSING_LOOKAHEAD_RATIO = 1.25
"""Multiple of an iteration's motion at which nothing may cross either: layers that meet keep 0.1 mm between them, which
the single precision of files preserves."""

MOVE_CONVERGENCE_TOLERANCE = 1e-5
"""Longest remaining motion of vertices that may still move at which the iterations end [m]."""

MAX_MOVE_ITERATIONS = 120
"""Largest number of iterations: a motion of 6 cm, as in `untangle`."""


def move_towards(vertices: np.ndarray, goal: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Move a mesh without intersections towards a goal that may have some; return its vertices [m], [vertex_count, 3].

    In each iteration every vertex moves straight towards its goal by at most `MAX_MOVE_STEP_LENGTH`; the vertices of
    faces that would cross stop for good. So an untangled mesh returns to where it was except where its layers meet.
    (Halving their moves instead took twenty times as long and came no nearer on trousers and shorts.)

    Crossings are tested at the end of an iteration. A layer within `MAX_MOVE_STEP_LENGTH` of another everywhere, and
    without a stopped vertex, would change sides undetected.

    Args:
        vertices: Positions [m], shape [vertex_count, 3].
        goal: Positions to reach [m], shape [vertex_count, 3].
        faces: Vertex indices, shape [face_count, 3].
    """
    moved, free = vertices.copy(), np.ones(len(vertices), dtype=bool)
    ahead = {share: CrossingTracker(faces) for share in (CROSSING_LOOKAHEAD_RATIO, 1.0)}
    for _ in range(MAX_MOVE_ITERATIONS):
        displacement = np.where(free[:, None], goal - moved, 0.0)
        length = np.linalg.norm(displacement, axis=1, keepdims=True)
        if length.max() < MOVE_CONVERGENCE_TOLERANCE:
            break
        displacement *= np.minimum(1.0, MAX_MOVE_STEP_LENGTH / np.maximum(length, MAX_MOVE_STEP_LENGTH))
        for share, tracker in ahead.items():
            while (crossing := np.unique(faces[tracker.find_faces(moved + share * displacement)])).size:
                displacement[crossing], free[crossing] = 0.0, False
        moved = moved + displacement
    return moved
