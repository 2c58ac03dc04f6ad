"""Find the two points of the cloth on the bust that no flat panel takes without a dart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .trunk_curvature import TrunkCurvature

BUST_CURVATURE_RADIUS = 0.10
"""Radius around a point within which curvature is counted (`TrunkCurvature.gather`) [m]: 0.5 mm of noise reduces 0.7
rad by 0.03, 1 mm by 0.1 where vertices are 4 mm apart."""

MIN_BUST_CURVATURE = 0.5
"""Curvature of each point from which a dart ends there [rad]. Eleven drapes by another simulator whose fronts have bust
darts of 0.6 rad and small waist darts have 0.55 to 0.63; of twelve whose fronts have none eleven have at most 0.41,
close T-shirts and dresses that stretch over the bust, and one 0.54."""

BUST_POINT_OFFSET_RANGE = (0.02, 0.19)
"""Smallest distance of a bust point from the middle [m], and the largest as a share of the bust girth, 17 cm of 92."""

MAX_DEPTH_BELOW_ARMPIT, MAX_HEIGHT_ABOVE_ARMPIT = 0.15, 0.02
"""Largest distances of a bust point below and above the armpit [m]; usually it is 4 cm below."""

BUST_POINT_GRID_SIZE = 0.01
"""Edge length of the cubes that give one vertex each as a candidate [m]."""


@dataclass(frozen=True)
class BustPoints:
    """Describe the points on the bust in which the cloth's curvature is concentrated.

    Attributes:
        places: To the wearer's left and right, in the target's axes [m], shape [2, 3].
        angle: Mean curvature of both [rad], a lower bound of the angle of a dart that ends there.
    """

    places: np.ndarray
    angle: float


def find_bust_points(cloth: TrunkCurvature) -> BustPoints | None:
    """Find the points in which a bodice's front is pointed; None where it is not so on both sides.

    A dart's end is the tip of a cone: its curvature is the dart's angle. Cloth stretched over a bust, or crumpled, has
    curvature of opposite sign around it, so that little is left within `BUST_CURVATURE_RADIUS`.
    """
    left, up, forwards = cloth.points.T
    height = up - cloth.measures.armpit_height
    outer = BUST_POINT_OFFSET_RANGE[1] * cloth.measures.bust
    around = (
        (forwards > 0.0)
        & (np.abs(left) < outer + BUST_CURVATURE_RADIUS)
        & (height > -MAX_DEPTH_BELOW_ARMPIT - BUST_CURVATURE_RADIUS)
        & (height < MAX_HEIGHT_ABOVE_ARMPIT + BUST_CURVATURE_RADIUS)
    )
    offered = (
        (np.abs(left) > BUST_POINT_OFFSET_RANGE[0])
        & (np.abs(left) < outer)
        & (height > -MAX_DEPTH_BELOW_ARMPIT)
        & (height < MAX_HEIGHT_ABOVE_ARMPIT)
    )
    best, found = [], []
    for side in (1.0, -1.0):
        tried = cloth.points[around & offered & (side * left > 0.0)]
        if not len(tried):
            return None
        tried = tried[np.unique(np.floor(tried / BUST_POINT_GRID_SIZE).astype(np.int64), axis=0, return_index=True)[1]]
        sums = cloth.gather(tried, around, BUST_CURVATURE_RADIUS)
        best.append(float(sums.max()))
        found.append(tried[int(np.argmax(sums))])
    if min(best) < MIN_BUST_CURVATURE:
        return None
    return BustPoints(np.array(found) @ cloth.axes + cloth.origin, float(np.mean(best)))
