"""Draft skirts that hang from the natural waist.

Straight, pencil and A-line skirts are the basic skirt block of W. Aldrich, Metric Pattern Cutting for Women's Wear,
without its darts: the waist is shaped at the side seams. Circle skirts are sectors of a ring whose inner arc is the
waist; of n panels each has an n-th of the whole angle.
"""

from __future__ import annotations

import math
from itertools import pairwise

from ..measures import BodyMeasures
from ..outline import (
    Outline,
    Point,
    Stroke,
    arc_handles,
    length,
    mirror,
    place_panel,
    smooth,
    unfold,
    unfold_closed,
)
from ..pattern import Panel
from .cut import Bodice, Cut, PartsConflict, Skirt, Waistband

BAND = 0.04
"""Width of a waistband [m]: as stiff as two layers of cloth, and it still follows the waist."""

SWEEP = {Skirt.HALF_CIRCLE: math.pi, Skirt.FULL_CIRCLE: 2 * math.pi}
"""The whole angle of a circle skirt [rad]."""

CIRCLE_LENGTH = 0.50
"""Length of a circle skirt from waist to hem [m]: to above the knee."""


GATHERS = 1.5
"""Width of a gathered skirt's upper edge by that of what it is gathered into: a medium fullness."""


def draw_skirt(cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw the panels of a skirt and of its waistband; below a bodice, of a skirt to be sewn to it.

    Raises:
        PartsConflict: where the skirt has not so many panels, or a gathered one nothing to be gathered into.
    """
    if cut.panels not in (2, 4):
        raise PartsConflict(f"a skirt of {cut.panels} panels is not drafted; choose 2 or 4.")
    waist = half_waist(cut, m) / 2
    if cut.skirt is Skirt.GATHERED and not _is_sewn(cut):
        raise PartsConflict("a gathered skirt needs something to be gathered into; add waistband=band or waist=seam.")
    if cut.skirt in SWEEP:
        panels = _circle(SWEEP[cut.skirt], waist, cut, m.waist_height)
    elif cut.panels == 4:
        panels = _gored(waist, cut, m)
    else:
        panels = _two_panels(waist, cut, m)
    if cut.waistband is Waistband.BAND:
        panels += [_band(side, waist, m.waist_height) for side in ("front", "back")]
    return panels


def half_waist(cut: Cut, m: BodyMeasures) -> float:
    """Return half of the waist's girth [m]: body + 2 cm where the skirt is held there, + 10 cm below a bodice."""
    return (m.waist + (0.02 if cut.bodice is Bodice.NONE else 0.10)) / 2


def _is_sewn(cut: Cut) -> bool:
    """Check whether a skirt's upper edge is sewn to a band or a bodice."""
    return cut.waistband is Waistband.BAND or cut.bodice is not Bodice.NONE


def _silhouette(cut: Cut, waist: float, m: BodyMeasures) -> list[Point]:
    """Return the points of a side seam from the hem to the waist [m].

    Allowances: waist + 2 cm (held there). A-line: hip + 5 cm, hem 1.30 m wide, 54 cm long; of four panels hip + 6 cm,
    hem 1.72 m, 58 cm. Pencil: hip + 4 cm, 50 cm long, the hem 6 cm narrower than the hip line. Straight: the same with
    a hem as wide as the hip line. Gathered: a rectangle of one and a half waists, and at least of a hip + 4 cm.
    """
    hip_line = m.hip_height - m.waist_height
    if cut.skirt is Skirt.GATHERED:
        return [(GATHERS * waist, -0.54), (GATHERS * waist, hip_line), (GATHERS * waist, 0.0)]
    if cut.skirt is Skirt.A_LINE and cut.panels == 4:
        return [(0.37, -0.58), ((m.hip + 0.06) / 4, hip_line), (waist, 0.0)]
    if cut.skirt is Skirt.A_LINE:
        return [(0.325, -0.54), ((m.hip + 0.05) / 4, hip_line), (waist, 0.0)]
    hip = (m.hip + 0.04) / 4
    narrower = 0.015 if cut.skirt is Skirt.PENCIL else 0.0
    return [(hip - narrower, -0.50), (hip, hip_line), (waist, 0.0)]


def _upper(cut: Cut) -> str:
    """Return what the seam of a skirt's upper edge is called by."""
    return "band" if cut.waistband is Waistband.BAND else "waist"


def _waist_line(cut: Cut, waist: float, dip: float, rise: float, face: str) -> Stroke:
    """Draw half a waist from the side to the middle: open and dipping there, or straight and sewn to a band."""
    if _is_sewn(cut):
        return Stroke((0.0, 0.0), label=f"{_upper(cut)}.{face}.left")
    return Stroke((0.0, -dip), ((waist * 0.6, rise - dip), (waist * 0.3, -dip)), contour="waist")


def _two_panels(waist: float, cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw front and back.

    An open waist dips by 12 mm at the middle and an A-line hem by 15 mm, so that both meet the slanted side seams
    nearly at a right angle and the hem hangs level.
    """
    points = _silhouette(cut, waist, m)
    dip = 0.015 if cut.skirt is Skirt.A_LINE else 0.0
    panels = []
    for face in ("front", "back"):
        strokes = smooth(points, ["side.0.left", "side.1.left"])
        strokes.append(_waist_line(cut, waist, 0.012, 0.002, face))
        panels.append(place_panel(face, unfold(Outline(points[0], tuple(strokes)), "hem", dip=dip), m.waist_height))
    return panels


def _gored(waist: float, cut: Cut, m: BodyMeasures) -> list[Panel]:
    """Draw left and right of front and back, sewn at the centre; a third of an A-line panel's flare lies there."""
    points = _silhouette(cut, waist, m)
    hip_line, (wide, low) = points[1][1], points[0]
    centre = (-0.06, low - 0.02) if cut.skirt is Skirt.A_LINE else (0.0, low)
    panels = []
    for face in ("front", "back"):
        top = _waist_line(cut, waist, 0.010, 0.001, face)
        outline = Outline(
            (wide, low),
            (
                *smooth(points, ["side.0.left", "side.1.left"]),
                top,
                Stroke((0.0, hip_line), label=f"centre.{face}.0"),
                Stroke(centre, label=f"centre.{face}.1"),
                Stroke((wide, low), contour="hem"),
            ),
        )
        panels.append(place_panel(f"{face}_left", outline, m.waist_height))
        panels.append(place_panel(f"{face}_right", mirror(outline), m.waist_height))
    return panels


def _circle(sweep: float, waist: float, cut: Cut, height: float) -> list[Panel]:
    """Draw front and back of a circle skirt, each half of the sector; waist and hem are concentric, so it hangs level.

    Raises:
        PartsConflict: where it is to have other panels than two.
    """
    if cut.panels != 2:
        raise PartsConflict("a circle skirt is drafted of 2 panels.")
    half = sweep / 4
    radius = waist / _cubic_arc(half)
    outer = radius + CIRCLE_LENGTH

    def at(distance: float, angle: float) -> Point:
        """Return a point of the sector, whose axis hangs down from the waist's middle."""
        return (distance * math.sin(angle), radius - distance * math.cos(angle))

    cuts = [half * i / 2 for i in range(3)]
    strokes = [
        Stroke(at(outer, b), arc_handles(at(outer, a), at(outer, b), b - a), contour="hem") for a, b in pairwise(cuts)
    ]
    strokes.append(Stroke(at(radius, half), label="side.left"))
    top, handles = at(radius, 0.0), arc_handles(at(radius, half), at(radius, 0.0), -half)
    panels = []
    for face in ("front", "back"):
        sewn = _is_sewn(cut)
        label, contour = (f"{_upper(cut)}.{face}.left", "") if sewn else ("", "waist")
        outline = unfold_closed(Outline(at(outer, 0.0), (*strokes, Stroke(top, handles, label, contour))))
        panels.append(place_panel(face, outline, height))
    return panels


def _cubic_arc(angle: float) -> float:
    """Return the length of the cubic that stands for an arc of radius 1; what is sewn to it has just this length."""
    start, end = (0.0, 0.0), (math.sin(angle), 1.0 - math.cos(angle))
    return length(Outline(start, (Stroke(end, arc_handles(start, end, angle), label="arc"),)), "arc")


def _band(face: str, waist: float, height: float) -> Panel:
    """Draw half a waistband, long enough for waist + 2 cm; of four panels its seam is cut at the centre."""
    outline = Outline(
        (-waist, 0.0),
        (
            Stroke((0.0, 0.0), label=f"band.{face}.right"),
            Stroke((waist, 0.0), label=f"band.{face}.left"),
            Stroke((waist, BAND), label="bandside.left"),
            Stroke((-waist, BAND), contour="waist"),
            Stroke((-waist, 0.0), label="bandside.right"),
        ),
    )
    return place_panel(f"band_{face}", outline, height, label="band")
