"""Count where cloth passes through itself, apart from where the given body leaves it no room."""

from __future__ import annotations

import numpy as np

from ..body.exposed import ExposedSurface
from ..geometry.intersections import self_intersections

MAX_PINCH_DISTANCE = 5e-3
"""Largest distance from skin that lies inside another part of the body at which cloth counts as pinched there [m]: two
sheets with their clearances from the skin and from each other need as much."""


def count_crossings(nodes: np.ndarray, faces: np.ndarray, skin: ExposedSurface | None) -> dict[str, float | None]:
    """Count faces that pass through others, and those of them that parts of the body that run into each other pinch.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        faces: Shape [face_count, 3].
        skin: The wearer's exposed skin, or None.

    Returns:
        `self_intersecting_faces`: all of them; `crossing_faces`: those that nothing pinches; `pinched_faces`: the rest.
    """
    crossed = self_intersections(nodes, faces)
    pinched = 0
    swallowed = None if skin is None else skin.swallowed
    if len(crossed) and swallowed is not None:
        pinched = int((swallowed.distance(nodes[faces[crossed]].mean(axis=1)) < MAX_PINCH_DISTANCE).sum())
    return {
        "self_intersecting_faces": float(len(crossed)),
        "crossing_faces": float(len(crossed) - pinched),
        "pinched_faces": float(pinched),
    }
