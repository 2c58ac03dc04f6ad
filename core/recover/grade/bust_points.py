"""Find the two points of the cloth on the bust that no flat panel takes without a dart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .trunk_curvature import TrunkCurvature

REACH = 0.10
"""How far around a point curvature is counted (`TrunkCurvature.gather`) [m]: 0.5 mm of noise takes 0.03 rad off 0.7, 1
mm 0.1 rad where vertices are 4 mm apart."""

POINTED = 0.5
"""Curvature of each point from which it is a dart's [rad], half a radian of cloth that is folded away. Eleven drapes by
another simulator whose fronts have bust darts of 0.6 rad and small waist darts have 0.55 to 0.63, counted so; of twelve
whose fronts have none eleven have 0.41 at most, close T-shirts and dresses that stretch over the bust, and one 0.54."""

BESIDE = (0.02, 0.19)
"""Between which distances from the middle a point lies [m], the second by the bust's girth: 17 cm of 92."""

BELOW, ABOVE = 0.15, 0.02
"""How far below and above the armpit a point may lie [m]; the bust point lies 4 cm below."""

GRID = 0.01
"""Edge of the cubes of which each offers one vertex as a point [m]."""


@dataclass(frozen=True)
class BustPoints:
    """Describe the points of the cloth on the bust in which its curvature is gathered.

    Attributes:
        places: To the wearer's left and right, in the target's axes [m], shape [2, 3].
        angle: Mean curvature of both [rad]: what a dart that ends there folds away, at least.
    """

    places: np.ndarray
    angle: float


def find_bust_points(cloth: TrunkCurvature) -> BustPoints | None:
    """Find the points in which a bodice's front is pointed; None where it is not as much on both sides.

    A dart's end is the point of a cone: its curvature is the dart's angle. Cloth that is stretched over a bust, or
    crumpled, is curved one way there and the other way around it, so that little is left within `REACH`.
    """
    left, up, forwards = cloth.points.T
    height = up - cloth.measures.armpit_height
    outer = BESIDE[1] * cloth.measures.bust
    around = (forwards > 0.0) & (np.abs(left) < outer + REACH) & (height > -BELOW - REACH) & (height < ABOVE + REACH)
    offered = (np.abs(left) > BESIDE[0]) & (np.abs(left) < outer) & (height > -BELOW) & (height < ABOVE)
    best, found = [], []
    for side in (1.0, -1.0):
        tried = cloth.points[around & offered & (side * left > 0.0)]
        if not len(tried):
            return None
        tried = tried[np.unique(np.floor(tried / GRID).astype(np.int64), axis=0, return_index=True)[1]]
        sums = cloth.gather(tried, around, REACH)
        best.append(float(sums.max()))
        found.append(tried[int(np.argmax(sums))])
    if min(best) < POINTED:
        return None
    return BustPoints(np.array(found) @ cloth.axes + cloth.origin, float(np.mean(best)))
