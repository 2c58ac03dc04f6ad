"""Move a mesh towards given places as far as it does not pass through itself."""

from __future__ import annotations

import numpy as np

from .intersections import self_intersections

MAX_MOVE_STEP_LENGTH = 5e-4
"""Largest motion of a vertex in one iteration [m]: layers that meet end less than twice that apart."""

CROSSING_LOOKAHEAD_RATIO = 1.25
"""Multiple of an iteration's motion at which nothing may cross either: layers that meet keep a tenth of a millimetre
between them, which the single precision of files does not take away."""

MOVE_CONVERGENCE_TOLERANCE = 1e-5
"""Longest motion that is left to vertices which may still move, below which the iterations end [m]."""

MAX_MOVE_ITERATIONS = 120
"""Largest number of iterations: a motion of 6 cm, as `untangle` has."""


def move_towards(vertices: np.ndarray, goal: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Move a mesh that does not cross itself towards a goal that may, and return its vertices [m], [vertex_count, 3].

    In each round every vertex goes straight towards its goal by at most `MAX_MOVE_STEP_LENGTH`; the vertices of faces
    that would cross stay where they are for good. So a mesh that was taken out of itself lies where it was, but for
    where its layers meet. (To halve their way instead took twenty times as long and came no nearer on trousers and
    shorts.)

    What crosses is asked where a round ends. A layer that lies within `MAX_MOVE_STEP_LENGTH` of another all over and is
    held nowhere would change sides unseen.

    Args:
        vertices: Positions [m], shape [vertex_count, 3].
        goal: Where they are to go [m], shape [vertex_count, 3].
        faces: Vertex indices, shape [face_count, 3].
    """
    moved, free = vertices.copy(), np.ones(len(vertices), dtype=bool)
    for _ in range(MAX_MOVE_ITERATIONS):
        way = np.where(free[:, None], goal - moved, 0.0)
        length = np.linalg.norm(way, axis=1, keepdims=True)
        if length.max() < MOVE_CONVERGENCE_TOLERANCE:
            break
        way *= np.minimum(1.0, MAX_MOVE_STEP_LENGTH / np.maximum(length, MAX_MOVE_STEP_LENGTH))
        for share in (CROSSING_LOOKAHEAD_RATIO, 1.0):
            while (held := np.unique(faces[self_intersections(moved + share * way, faces)])).size:
                way[held], free[held] = 0.0, False
        moved = moved + way
    return moved
