"""Count where cloth crosses itself, separately where the given body leaves it no room."""

from __future__ import annotations

import numpy as np

from ..body.exposed import ExposedSurface
from ..geometry.intersections import self_intersections

MAX_PINCH_DISTANCE = 5e-3
"""Largest distance from skin inside another part of the body at which cloth counts as pinched [m]: the room that two
sheets need with their clearances from the skin and from each other."""


def count_crossings(nodes: np.ndarray, faces: np.ndarray, skin: ExposedSurface | None) -> dict[str, float | None]:
    """Count faces that cross others, and those of them that intersecting parts of the body pinch.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        faces: Shape [face_count, 3].
        skin: The wearer's exposed skin, or None.

    Returns:
        `self_intersecting_faces`: all of them; `crossing_faces`: those not pinched; `pinched_faces`: the rest.
    """
    crossed = self_intersections(nodes, faces)
    pinched = 0
    hidden_skin = None if skin is None else skin.hidden_skin
    if len(crossed) and hidden_skin is not None:
        pinched = int((hidden_skin.distance(nodes[faces[crossed]].mean(axis=1)) < MAX_PINCH_DISTANCE).sum())
    return {
        "self_intersecting_faces": float(len(crossed)),
        "crossing_faces": float(len(crossed) - pinched),
        "pinched_faces": float(pinched),
    }
