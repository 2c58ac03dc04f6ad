"""Heights of a wearer's waist, hips and knees on a pattern, and how much longer it becomes down to there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..measures import BodyMeasures
from ..orientation import place_points
from ..parts.legs import KNEE_HEIGHT_SHARE
from ..pattern import Pattern
from .bodice_points import FacePoints, PointRef, find_bodice_points
from .growth import Growth
from .raglan_points import find_raglan_halves, measure_neck_depth

MIN_LEVEL_SPACING = 1e-3
"""Smallest distance of two heights at which lengths grow [m]: they are in order also on unusual bodies."""


@dataclass(frozen=True)
class Levels:
    """Describe heights on a pattern as it is placed [m], from the upper end down.

    Attributes:
        top: Where lengths are measured from: the side neck points, or else the highest point.
        tip, underarm: Of the shoulders' tips and the underarm points; None where there is no bodice.
        waist, hip, knee: Of the wearer's.
    """

    top: float
    tip: float | None
    underarm: float | None
    waist: float
    hip: float
    knee: float

    @classmethod
    def of(cls, pattern: Pattern, base: BodyMeasures) -> Levels:
        """Return the heights for a wearer, whose side neck points are at the pattern's; below the waist alone, whose
        waist is where the panels are placed."""
        faces = find_bodice_points(pattern)
        knee = KNEE_HEIGHT_SHARE * base.crotch_height
        if not faces:
            top = max(float(place_points(panel, panel.points)[:, 1].max()) for panel in pattern.panels)
            return cls(top, None, None, base.waist_height, base.hip_height, knee)
        tip, underarm = (mean_height(pattern, faces, name) for name in ("tips", "underarms"))
        top = mean_height(pattern, faces, "necks") if any(face.necks for face in faces) else tip
        if raglans := find_raglan_halves(pattern):
            top = tip + float(np.mean([measure_neck_depth(pattern, half) for half in raglans]))
        off = top - base.nape_height
        return cls(top, tip, underarm, base.waist_height + off, base.hip_height + off, knee + off)

    def find_shares(self, height: float) -> dict[str, float]:
        """Return the shares of the growth of lengths down to a height [m], by the names of `Growth`."""
        shares = {}
        if self.tip is not None and self.underarm is not None:
            above, below = _share(height, self.tip, self.underarm), _share(height, self.underarm, self.waist)
            shares = {"armhole_depth": above - below, "back_length": below}
        hip, knee = _share(height, self.waist, self.hip), _share(height, self.hip, self.knee)
        shares |= {"hip_depth": hip - knee, "knee_depth": knee}
        return {name: share for name, share in shares.items() if share}

    def find_girth_shares(self, height: float) -> dict[str, float]:
        """Return the shares of the growth of bust, waist and hips in that of a girth at a height [m]."""
        if self.underarm is None:
            below = _share(height, self.waist, self.hip)
            return {"waist": 1.0 - below, "hip": below}
        above, below = _share(height, self.underarm, self.waist), _share(height, self.waist, self.hip)
        return {"bust": 1.0 - above, "waist": above - below, "hip": below}

    def find_growth(self, growth: Growth, height: float) -> float:
        """Return by how much a pattern grows from its upper end down to a height [m], beside the stature [m]."""
        return sum(share * float(getattr(growth, name)) for name, share in self.find_shares(height).items())

    def interpolate_growth(self, growth: Growth, heights: np.ndarray) -> np.ndarray:
        """Return by how much a pattern grows down to some heights [m], shape [n]: linear between the named ones."""
        known = [self.top, self.tip, self.underarm, self.waist, self.hip, self.knee]
        knots = sorted(height for height in known if height is not None)
        found: np.ndarray = np.interp(heights, knots, [self.find_growth(growth, height) for height in knots])
        return found


def mean_height(pattern: Pattern, faces: tuple[FacePoints, ...], name: str) -> float:
    """Return the mean height of the points of both faces in one of their dictionaries, as they are placed [m]."""
    points: list[PointRef] = [ref for face in faces for ref in getattr(face, name).values()]
    panels = [(pattern.panel(panel), i) for panel, i in points]
    return float(np.mean([place_points(panel, panel.points[i])[1] for panel, i in panels]))


def _share(height: float, above: float, below: float) -> float:
    """Return how far a height is from one above to one below, from 0 to 1."""
    return float(np.clip((above - height) / max(above - below, MIN_LEVEL_SPACING), 0.0, 1.0))
