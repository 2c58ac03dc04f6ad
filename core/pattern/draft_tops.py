"""Draft tops and dresses: front, back and, where there are sleeves, half sleeves in the same plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .measures import BodyMeasures
from .outline import Outline, Point, Stroke, mirror, place_panel, sew_by_label, smooth, unfold
from .pattern import Panel, Pattern


@dataclass(frozen=True)
class SleeveCut:
    """Say how a sleeve is cut.

    Attributes:
        droop: Angle below the horizontal of its upper edge in the draft [rad].
        length: Along the upper edge, from the shoulder's tip [m].
        cuff_half: Half the cuff's circumference [m].
    """

    droop: float
    length: float
    cuff_half: float


SHORT_SLEEVE = SleeveCut(np.deg2rad(12.0), 0.19, 0.175)
"""A T-shirt's: 19 cm along the top and a cuff of 35 cm, 8 cm of ease. 12 degrees lie between an arm stretched out (0)
and one hanging (about 60), nearer to the T-pose."""
ELBOW_SLEEVE = SleeveCut(np.deg2rad(10.0), 0.25, 0.155)
"""A dress's, to just above the elbow; its cuff of 31 cm still passes the elbow bent."""
LONG_SLEEVE = SleeveCut(np.deg2rad(4.0), 0.46, 0.11)
"""To the wrist bone. A long sleeve that drooped more would start its drape beside the stretched-out arm instead of
around it; its cuff of 22 cm passes the hand."""


def draft_tshirt(measures: BodyMeasures | None = None) -> Pattern:
    """Draft a T-shirt: front, back and four half sleeves with short, slightly drooping sleeves.

    Allowances: bust + 10 cm (a regular T-shirt), armhole 7 cm below the armpit, 1 cm of shoulder drop, neck 2 cm
    wider than the body's at each side and 10 cm deep in front so that it passes the head, hem 2 cm below the hip line.
    """
    return _shirt("tshirt", "tshirt", measures or BodyMeasures(), SHORT_SLEEVE)


def draft_long_sleeve_tshirt(measures: BodyMeasures | None = None) -> Pattern:
    """Draft a T-shirt with sleeves to the wrist, its body cut as the T-shirt's."""
    return _shirt("long_sleeve_tshirt", "long_sleeve_tshirt", measures or BodyMeasures(), LONG_SLEEVE)


def _shirt(name: str, category: str, m: BodyMeasures, cut: SleeveCut) -> Pattern:
    half = (m.bust + 0.10) / 4
    under = (half, m.armpit_height - 0.07)
    side = [Stroke((half, under[1] - m.nape_height), label="side.left", notch=0.5)]
    return _sleeved(name, category, m, (half, m.hip_height - 0.02), side, cut)


def draft_sleeved_dress(measures: BodyMeasures | None = None) -> Pattern:
    """Draft a dress with sleeves to the elbow: front, back and four half sleeves.

    Allowances: bust + 8 cm (the arms move), waist + 12 cm and hip + 10 cm (it goes on without a zip), hem flared to
    1.36 m for a free step, armhole 6 cm below the armpit, neck and shoulders as the T-shirt's.
    """
    m = measures or BodyMeasures()
    sides = [
        (0.34, m.crotch_height - 0.29),
        ((m.hip + 0.10) / 4, m.hip_height),
        ((m.waist + 0.12) / 4, m.waist_height),
        ((m.bust + 0.08) / 4, m.armpit_height - 0.06),
    ]
    points = [(x, y - m.nape_height) for x, y in sides]
    strokes = smooth(points, [f"side.{i}.left" for i in range(len(points) - 1)])
    return _sleeved("sleeved_dress", "dress", m, sides[0], strokes, ELBOW_SLEEVE)


def _sleeved(name: str, category: str, m: BodyMeasures, corner: Point, side: list[Stroke], cut: SleeveCut) -> Pattern:
    """Draw front, back and sleeves around the side seam from the hem's corner [m above the feet] to the armhole."""
    neck = (m.neck_half_width + 0.02, 0.0)
    tip = (m.shoulder_half_width + 0.01, -0.04)
    under = side[-1].end
    hem = (corner[0], corner[1] - m.nape_height)
    panels = []
    for face, depth, hollow in (("front", 0.10, 0.050), ("back", 0.025, 0.042)):
        scye = ((under[0] - hollow, under[1] + 0.004), (tip[0] - 0.012, tip[1] - 0.08))
        outline = Outline(
            hem,
            (
                *side,
                Stroke(tip, scye, label=f"scye.{face}.left", notch=0.45),
                Stroke(neck, label="shoulder.left"),
                neckline(neck, depth),
            ),
        )
        panels.append(place_panel(face, unfold(outline, "hem"), m.nape_height))
        panels += half_sleeves(face, under, tip, scye, m.nape_height, cut)
    order = ("front", "back")
    panels.sort(key=lambda p: (p.name not in order, p.name))
    return sew_by_label(name, category, panels)


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


def draft_tank(measures: BodyMeasures | None = None) -> Pattern:
    """Draft a tank top: front and back with 5.5 cm straps.

    Allowances: bust + 4 cm (close, as ribbed tanks are), waist + 12 cm and hip + 2 cm (it skims without darts),
    armhole 3 cm below the armpit, hem 5 cm above the hip line, neckline 14 cm deep in front and 8 cm behind.
    """
    m = measures or BodyMeasures()
    sides = (
        ((m.hip + 0.02) / 4, m.hip_height + 0.05),
        ((m.waist + 0.12) / 4, m.waist_height),
        ((m.bust + 0.04) / 4, m.armpit_height - 0.03),
    )
    neck = (m.neck_half_width + 0.025, -0.005)
    strap = (neck[0] + 0.052, -0.023)
    return _sleeveless("tank", "tank", m, sides, neck, strap, {"front": 0.14, "back": 0.08})


def draft_dress(measures: BodyMeasures | None = None) -> Pattern:
    """Draft a sleeveless dress: front and back in one piece from shoulder to knee.

    Allowances: bust + 5 cm, waist + 10 cm and hip + 8 cm (a shift dress that goes on without a zip), hem flared to
    1.36 m for a free step, armhole 3 cm below the armpit, neckline 11 cm deep in front and 4 cm behind.
    """
    m = measures or BodyMeasures()
    sides = (
        (0.34, m.crotch_height - 0.29),
        ((m.hip + 0.08) / 4, m.hip_height),
        ((m.waist + 0.10) / 4, m.waist_height),
        ((m.bust + 0.05) / 4, m.armpit_height - 0.03),
    )
    neck = (m.neck_half_width + 0.025, -0.005)
    tip = (m.shoulder_half_width - 0.02, -0.034)
    return _sleeveless("dress", "dress", m, sides, neck, tip, {"front": 0.11, "back": 0.04})


def _sleeveless(
    name: str,
    category: str,
    m: BodyMeasures,
    sides: tuple[Point, ...],
    neck: Point,
    tip: Point,
    depths: dict[str, float],
) -> Pattern:
    """Draw front and back with shared side and shoulder seams; the front's armhole is hollowed 8 mm deeper."""
    points = [(x, y - m.nape_height) for x, y in sides]
    under = points[-1]
    panels = []
    for side, hollow in (("front", 0.058), ("back", 0.050)):
        scye = ((under[0] - hollow, under[1] + 0.004), (tip[0] - 0.016, tip[1] - 0.09))
        strokes = smooth(points, [f"side.{i}.left" for i in range(len(points) - 1)])
        strokes += [
            Stroke(tip, scye, contour="armhole.left"),
            Stroke(neck, label="shoulder.left"),
            neckline(neck, depths[side]),
        ]
        panels.append(place_panel(side, unfold(Outline(points[0], tuple(strokes)), "hem"), m.nape_height))
    return sew_by_label(name, category, panels)


def neckline(neck: Point, depth: float) -> Stroke:
    """Draw half a neckline: off the shoulder at a right angle, level at the middle."""
    low = neck[1] - depth
    return Stroke(
        (0.0, low), ((neck[0] - 0.1 * neck[0], neck[1] - 0.55 * depth), (0.55 * neck[0], low)), contour="neck"
    )


def to_point(array: np.ndarray) -> Point:
    """Give a point [m] as plain numbers."""
    return (float(array[0]), float(array[1]))
