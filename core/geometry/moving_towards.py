"""Move a mesh towards given places as far as it does not pass through itself."""

from __future__ import annotations

import numpy as np

from .intersections import self_intersections

STEP = 5e-4
"""Way of a vertex in one round [m]: layers that meet end less than twice that apart."""

BEYOND = 1.25
"""Share of a round's way at which nothing may cross either: layers that meet keep a tenth of a millimetre between them,
which the single precision of files does not take away."""

ENDED = 1e-5
"""Way that is left to all vertices that may still move where the rounds end [m]."""

ROUNDS = 120
"""Rounds at most: a way of 6 cm, as `untangle` has."""


def move_towards(vertices: np.ndarray, goal: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Move a mesh that does not cross itself towards a goal that may, and return its vertices [m], [vertex_count, 3].

    In each round every vertex goes straight towards its goal by at most `STEP`; the vertices of faces that would cross
    stay where they are for good. So a mesh that was taken out of itself lies where it was, but for where its layers
    meet. (To halve their way instead took twenty times as long and came no nearer on trousers and shorts.)

    What crosses is asked where a round ends. A layer that lies within `STEP` of another all over and is held nowhere
    would change sides unseen.

    Args:
        vertices: Positions [m], shape [vertex_count, 3].
        goal: Where they are to go [m], shape [vertex_count, 3].
        faces: Vertex indices, shape [face_count, 3].
    """
    moved, free = vertices.copy(), np.ones(len(vertices), dtype=bool)
    for _ in range(ROUNDS):
        way = np.where(free[:, None], goal - moved, 0.0)
        length = np.linalg.norm(way, axis=1, keepdims=True)
        if length.max() < ENDED:
            break
        way *= np.minimum(1.0, STEP / np.maximum(length, STEP))
        for share in (BEYOND, 1.0):
            while (held := np.unique(faces[self_intersections(moved + share * way, faces)])).size:
                way[held], free[held] = 0.0, False
        moved = moved + way
    return moved
