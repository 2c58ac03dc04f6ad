"""Find where an armhole meets the shoulder seam: the cloth has a point of negative curvature there, a panel has not."""

from __future__ import annotations

import numpy as np

from .trunk_curvature import TrunkCurvature

SHOULDER_CURVATURE_RADIUS = 0.04
"""Radius around a place within which curvature is counted [m], with the weights of the bust points: no neighbouring
point of a seam is as near. Nor may a rim be, for half of the curvature would be missing there: beside the neck of a
V-necked scan with 4 mm edges the sum is below `MAX_HOLLOW_CURVATURE` in one of two draws of 0.2 mm of noise, 2 to 8 mm
from the rim; the ends of armholes are 54 mm and more from it."""

MAX_HOLLOW_CURVATURE = -0.12
"""Curvature of each place below which it is a shoulder point [rad]. At the ends of the armholes of eleven sleeved
drapes by another simulator and one of our own it is -0.70 to -0.13, except for two sides with -0.08 and -0.10."""

MAX_RIVAL_CURVATURE_SHARE = 0.45
"""Largest share of a shoulder point's curvature that another place may have, `SHOULDER_CURVATURE_RADIUS` or more away.
Seven of those twelve have 0.09 to 0.36 on both sides; others, unsleeved ones, a noisy scan have another as hollow."""

MAX_SHOULDER_INWARD_OFFSET, MAX_SHOULDER_OUTWARD_OFFSET = 0.12, 0.15
"""Largest distances of a place inside and outside of the shoulder joint [m]: for halters and for dropped shoulders."""

MAX_SHOULDER_DEPTH_OFFSET, MAX_SHOULDER_DROP = 0.08, 0.10
"""Largest distances of a place before or behind, and below, the shoulder joint [m]."""


def find_shoulder_points(cloth: TrunkCurvature) -> tuple[np.ndarray, np.ndarray] | None:
    """Find the hollow points of the cloth on both shoulders, in the trunk's axes [m], left and right.

    Sleeve, front and back meet there in one point; their angles add up to more than 2 pi where the sleeve turns down.
    In smooth cloth nothing else shows the width of the shoulders: strain is small wherever the armhole is.

    Args:
        cloth: The curvature around the trunk.

    Returns:
        A point each, shape [3]; None where one side has none, others are as hollow, or a rim is near.
    """
    found = [_find_point(cloth, side) for side in (0, 1)]
    left, right = found
    return None if left is None or right is None else (left, right)


def _find_point(cloth: TrunkCurvature, side: int) -> np.ndarray | None:
    """Return the hollow point of the left (0) or right (1) shoulder; None if it is not unique, or at a rim."""
    outwards = (1.0, -1.0)[side]
    offset = cloth.points - cloth.shoulders[side]
    is_near = np.linalg.norm(offset, axis=1) < MAX_SHOULDER_INWARD_OFFSET + MAX_SHOULDER_OUTWARD_OFFSET
    across, up, forwards = offset.T
    offered = (
        is_near
        & (outwards * across > -MAX_SHOULDER_INWARD_OFFSET)
        & (outwards * across < MAX_SHOULDER_OUTWARD_OFFSET)
        & (np.abs(forwards) < MAX_SHOULDER_DEPTH_OFFSET)
    )
    offered &= (up > -MAX_SHOULDER_DROP) & cloth.faces_up
    if not offered.any():
        return None
    sums = cloth.gather(cloth.points[offered], is_near, SHOULDER_CURVATURE_RADIUS)
    least = int(np.argmin(sums))
    place = cloth.points[offered][least]
    others = sums[np.linalg.norm(cloth.points[offered] - place, axis=1) >= SHOULDER_CURVATURE_RADIUS]
    if sums[least] > MAX_HOLLOW_CURVATURE or others.min(initial=0.0) < MAX_RIVAL_CURVATURE_SHARE * sums[least]:
        return None
    rim = cloth.points[cloth.on_rim]
    is_whole = np.linalg.norm(rim - place, axis=1).min(initial=np.inf) >= SHOULDER_CURVATURE_RADIUS
    return np.asarray(place) if is_whole else None
