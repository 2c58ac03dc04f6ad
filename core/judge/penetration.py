"""Measure how deep cloth is in the given body, apart from what that leaves no room."""

from __future__ import annotations

import numpy as np

from ..body.exposed import ExposedSurface, pinched_depth


def measure_penetration(nodes: np.ndarray, faces: np.ndarray, skin: ExposedSurface | None) -> dict[str, float | None]:
    """Measure the depth of a garment in a body, and of what parts of the body that run into each other pinch.

    Args:
        nodes: Positions [m], shape [n, 3].
        faces: Shape [m, 3].
        skin: The wearer's exposed skin, or None.

    Returns:
        `body_penetration_mm`: the greatest way out of what has one; `pinched_mm`: the greatest depth of the rest below
        the nearer of the parts, which have to yield as much. None where there is no skin, the second also where nothing
        is pinched.
    """
    if skin is None:
        return {"body_penetration_mm": None, "pinched_mm": None}
    depth = pinched_depth(nodes, faces, skin)
    return {"body_penetration_mm": 1e3 * depth.free, "pinched_mm": 1e3 * depth.pinched if depth.pinched else None}
