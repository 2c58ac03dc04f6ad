"""Measure how deep cloth is in the given body, separately where the body leaves it no room."""

from __future__ import annotations

import numpy as np

from ..body.exposed import ExposedSurface, pinched_depth


def measure_penetration(nodes: np.ndarray, faces: np.ndarray, skin: ExposedSurface | None) -> dict[str, float | None]:
    """Measure the depth of a garment in a body, and of cloth that intersecting parts of the body pinch.

    Args:
        nodes: Positions [m], shape [n, 3].
        faces: Shape [m, 3].
        skin: The wearer's exposed skin, or None.

    Returns:
        `body_penetration_mm`: the greatest way out, of points not pinched; `pinched_mm`: the greatest depth of the
            others below the nearer part, which has to yield as much. None without skin, the second also if none is
            pinched.
    """
    if skin is None:
        return {"body_penetration_mm": None, "pinched_mm": None}
    depth = pinched_depth(nodes, faces, skin)
    return {"body_penetration_mm": 1e3 * depth.free, "pinched_mm": 1e3 * depth.pinched if depth.pinched else None}
