"""Draft sleeves in halves that lie in the plane of front and back, their cap the armhole's own curve.

A half sleeve is the front or back of a T-shirt's sleeve laid beside the bodice (the flat block without cap height of
W. Aldrich, Metric Pattern Cutting for Women's Wear, for jersey and easy-fitting garments).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..outline import Outline, Point, Stroke, mirror, place_panel, to_point
from ..pattern import Panel
from .cut import Sleeve


@dataclass(frozen=True)
class SleeveCut:
    """Describe how a sleeve is cut.

    Attributes:
        droop: Angle below the horizontal of its upper edge in the draft [rad].
        length: Along the upper edge, from the shoulder's tip [m].
        cuff_half: Half the cuff's circumference [m].
    """

    droop: float
    length: float
    cuff_half: float


SLEEVES = {
    Sleeve.CAP: SleeveCut(np.deg2rad(8.0), 0.115, 0.17),
    Sleeve.SHORT: SleeveCut(np.deg2rad(12.0), 0.19, 0.175),
    Sleeve.ELBOW: SleeveCut(np.deg2rad(10.0), 0.25, 0.155),
    Sleeve.LONG: SleeveCut(np.deg2rad(4.0), 0.46, 0.11),
}
"""The cut of each sleeve. A cap covers the shoulder's end and closes just below the arm. A short one is a T-shirt's: 19
cm along the top and a cuff of 35 cm, 8 cm of ease; 12 degrees lie between an arm stretched out (0) and one hanging
(about 60), nearer to the T-pose. To the elbow: a dress's, whose cuff of 31 cm still passes the elbow bent. Long: to the
wrist bone; it would start its drape beside the stretched-out arm instead of around it if it drooped more, and its cuff
of 22 cm passes the hand."""


def half_sleeves(
    side: str, under: Point, tip: Point, scye: tuple[Point, ...], height: float, cut: SleeveCut
) -> list[Panel]:
    """Draw the left half sleeve of one side in the body's plane and mirror it; the cap is the armhole's own curve."""
    along = np.array([np.cos(cut.droop), -np.sin(cut.droop)])
    top = np.array(tip) + cut.length * along
    low = top + cut.cuff_half * np.array([along[1], -along[0]])
    outline = Outline(
        tip,
        (
            Stroke(under, scye[::-1], label=f"scye.{side}.left", notch=0.55),
            Stroke(to_point(low), label="undersleeve.left"),
            Stroke(to_point(top), label="", contour="cuff.left"),
            Stroke(tip, label="oversleeve.left"),
        ),
    )
    # The warp runs along the arm; a grainline is a line, so its angle is given within a quarter turn of +y.
    grain = np.pi / 2 - cut.droop
    left = place_panel(f"sleeve_{side}_left", outline, height, grain if side == "front" else -grain, "sleeve")
    right = place_panel(f"sleeve_{side}_right", mirror(outline), height, -grain if side == "front" else grain, "sleeve")
    return [left, right]
