"""Draft garments with legs: trousers, shorts and a jumpsuit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq, root

from .draft_tops import ELBOW_SLEEVE, half_sleeves, neckline, to_point
from .measures import BodyMeasures
from .outline import Outline, Point, Stroke, length, mirror, place_panel, sew_by_label, smooth
from .pattern import Panel, Pattern

CREASE_FROM_MIDDLE = 0.12
"""Where each leg's crease line stands at first [m]: outside the ankles, so that no panel reaches over the middle."""

_EASED = ("inseam.0", "outseam.1", "outseam.2")
"""Seams of the trousers whose back is fitted to the front."""

LegEnd = tuple[float, float]
"""Height above the feet of a cut across the leg, and half the mean of front and back width there [m]."""


def draft_trousers(measures: BodyMeasures | None = None) -> Pattern:
    """Draft straight trousers: front and back of each leg.

    Allowances: they sit 6 cm below the natural waist, where the girth is about waist + 6 cm; hip + 6 cm, the front
    1 cm narrower and the back 1 cm wider than a quarter, measured a third of the rise above the crotch; crotch 1.5 cm
    below the body's; forks of hip / 16 - 1 cm (front) and hip / 8 - 2 cm (back), the seat's depth; knee 45 cm and hem
    40 cm around. The back fork is lowered and the back's side corners moved until inseams and outseams are equal.
    """
    return _legs("trousers", measures or BodyMeasures(), ((0.47, 0.1125), (0.08, 0.10)))


def draft_shorts(measures: BodyMeasures | None = None) -> Pattern:
    """Draft shorts to the middle of the thigh: front and back of each leg.

    Allowances as the trousers'; inseam 19 cm, legs 59 cm around, 4 cm more than the thigh there.
    """
    m = measures or BodyMeasures()
    return _legs("shorts", m, ((m.crotch_height - 0.205, 0.1475),))


def _legs(name: str, m: BodyMeasures, ends: tuple[LegEnd, ...]) -> Pattern:
    """Draw front and back legs that are cut at some heights, the last of which is the opening."""
    base = m.waist_height
    crotch = m.crotch_height - 0.015 - base
    top = -0.06
    hip = crotch + (top - crotch) / 3
    level = (crotch, hip, top)
    fork = m.hip / 16 - 0.01
    front = _leg(m, level, ends, side_shift=-0.01, fork=fork, rise=0.0, fork_drop=0.0, lift=(0.0, 0.0))

    def back(drop: float, hip_lift: float, side_lift: float) -> Outline:
        fork = m.hip / 8 - 0.02
        lift = (hip_lift, side_lift)
        return _leg(m, level, ends, side_shift=0.01, fork=fork, rise=0.02, fork_drop=drop, lift=lift)

    def excess(moves: np.ndarray) -> np.ndarray:
        drawn = back(*moves)
        return np.array([length(drawn, name) - length(front, name) for name in _EASED])

    solved = root(excess, np.zeros(len(_EASED)), tol=1e-9)
    panels = []
    for side, outline in (("front", front), ("back", back(*solved.x))):
        crease = (
            sum(
                p.end[0]
                for p in outline.strokes
                if p.label == f"inseam.{len(ends) - 1}.left" or p.contour == "leg.left"
            )
            / 2
        )
        named = replace(outline, strokes=tuple(_on_side(s, side) for s in outline.strokes))
        for leg, drawn in (("left", named), ("right", mirror(named))):
            across = CREASE_FROM_MIDDLE - crease if leg == "left" else crease - CREASE_FROM_MIDDLE
            panels.append(place_panel(f"{side}_{leg}", drawn, base, label="leg", across=across))
    return sew_by_label(name, name, panels)


def _leg(
    m: BodyMeasures,
    level: tuple[float, float, float],
    ends: tuple[LegEnd, ...],
    *,
    side_shift: float,
    fork: float,
    rise: float,
    fork_drop: float,
    lift: tuple[float, float],
) -> Outline:
    """Draw one left leg panel around its crease line, which halves the distance from fork to side.

    `level` are the heights of crotch, hip line and waist from the natural waist [m].
    """
    crotch, hip, top = level
    side = (m.hip + 0.06) / 4 + side_shift
    waist = (m.waist + 0.06) / 4 + side_shift / 2
    crease = (side - fork) / 2
    slant = 1.4 * rise + 0.01
    cuts = [(height - m.waist_height, half + side_shift / 2) for height, half in ends]
    tip = (-fork, crotch - fork_drop)
    centre = (slant, top + rise)
    seat = (0.0, hip)
    first = (crease - cuts[0][1], cuts[0][0])
    strokes = [
        Stroke(seat, label="crotch.0"),
        Stroke(tip, ((0.0, hip + 0.62 * (crotch - hip)), (-0.45 * fork, tip[1] + 0.002)), label="crotch.1"),
        Stroke(first, _slack(tip, first, 0.10, 0.30), label="inseam.0.left"),
    ]
    strokes += [Stroke((crease - half, y), label=f"inseam.{i}.left") for i, (y, half) in enumerate(cuts[1:], start=1)]
    strokes.append(Stroke((crease + cuts[-1][1], cuts[-1][0]), contour="leg.left"))
    strokes += [Stroke((crease + half, y), label="outseam.0.left") for y, half in cuts[-2::-1]]
    thigh = [(crease + cuts[0][1], cuts[0][0]), (side, hip + lift[0]), (slant + waist, top + lift[1])]
    strokes += smooth(thigh, ["outseam.1.left", "outseam.2.left"])
    strokes.append(Stroke(centre, contour="waist"))
    return Outline(centre, tuple(strokes))


def draft_jumpsuit(measures: BodyMeasures | None = None) -> Pattern:
    """Draft a sleeveless jumpsuit in one piece: front and back of each half, from the shoulder to the ankle.

    Allowances: bust + 6 cm, waist + 16 cm and hip + 12 cm (it is stepped into through the neck, and bent in), crotch
    4 cm below the body's, so that the trunk can bend; knee 47 cm and hem 42 cm around, neckline 12 cm deep in front and
    4 cm behind. Side seams are one curve; the back's fork is lowered until the inseams are equal.
    """
    m = measures or BodyMeasures()
    panels = _suit_panels(m, _bare_bodice(m))
    return sew_by_label("jumpsuit", "jumpsuit", panels)


def draft_sleeved_jumpsuit(measures: BodyMeasures | None = None) -> Pattern:
    """Draft a jumpsuit with sleeves to the elbow: front and back of each half, four half sleeves.

    Waist, hip and legs as the sleeveless jumpsuit's; bust + 8 cm, armhole, neck, shoulders and sleeves as those of the
    dress with sleeves.
    """
    m = measures or BodyMeasures()
    bodice = _sleeved_bodice(m)
    panels = _suit_panels(m, bodice)
    for side, (_, under, scye, _) in bodice.items():
        tip = (m.shoulder_half_width + 0.01, -0.04)
        panels += half_sleeves(side, under, tip, scye.handles, m.nape_height, ELBOW_SLEEVE)
    return sew_by_label("sleeved_jumpsuit", "jumpsuit", panels)


Bodice = tuple[Point, Point, Stroke, float]
"""Side neck point, underarm point, the armhole from there to the shoulder's tip, and the depth of the neckline [m]."""


def _bare_bodice(m: BodyMeasures) -> dict[str, Bodice]:
    """Give the upper ends of a sleeveless jumpsuit's front and back."""
    neck, tip = (m.neck_half_width + 0.025, -0.005), (m.shoulder_half_width - 0.02, -0.034)
    under = ((m.bust + 0.06) / 4, m.armpit_height - 0.03 - m.nape_height)
    bodice = {}
    for side, depth, hollow in (("front", 0.12, 0.058), ("back", 0.04, 0.050)):
        scye = ((under[0] - hollow, under[1] + 0.004), (tip[0] - 0.016, tip[1] - 0.09))
        bodice[side] = (neck, under, Stroke(tip, scye, contour="armhole.left"), depth)
    return bodice


def _sleeved_bodice(m: BodyMeasures) -> dict[str, Bodice]:
    """Give the upper ends of a sleeved jumpsuit's front and back: those of the dress with sleeves."""
    neck, tip = (m.neck_half_width + 0.02, 0.0), (m.shoulder_half_width + 0.01, -0.04)
    under = ((m.bust + 0.08) / 4, m.armpit_height - 0.06 - m.nape_height)
    bodice = {}
    for side, depth, hollow in (("front", 0.10, 0.050), ("back", 0.025, 0.042)):
        scye = ((under[0] - hollow, under[1] + 0.004), (tip[0] - 0.012, tip[1] - 0.08))
        bodice[side] = (neck, under, Stroke(tip, scye, label=f"scye.{side}.left", notch=0.45), depth)
    return bodice


def _suit_panels(m: BodyMeasures, bodice: dict[str, Bodice]) -> list[Panel]:
    """Draw front and back of each half; the back's fork is lowered until the inseams are equal."""
    front = _half_suit(m, "front", m.hip / 16 - 0.01, 0.0, bodice["front"])
    wanted = length(front, "inseam.0")

    def back(drop: float) -> Outline:
        return _half_suit(m, "back", m.hip / 8 - 0.025, drop, bodice["back"])

    drop = brentq(lambda moved: length(back(moved), "inseam.0") - wanted, -0.05, 0.15, xtol=1e-12)
    panels = []
    for side, outline in (("front", front), ("back", back(drop))):
        panels.append(place_panel(f"{side}_left", outline, m.nape_height))
        panels.append(place_panel(f"{side}_right", mirror(outline), m.nape_height))
    return panels


def _half_suit(m: BodyMeasures, side: str, fork: float, fork_drop: float, bodice: Bodice) -> Outline:
    """Draw the left half of a jumpsuit's front or back around the leg's middle, 13 cm from the body's."""
    base = m.nape_height
    neck, under, armhole, depth = bodice
    hip, waist, crotch = m.hip_height + 0.04 - base, m.waist_height - base, m.crotch_height - 0.04 - base
    fork_tip = (-fork, crotch - fork_drop)
    knee, ankle = 0.47 - base, 0.08 - base
    sides = [
        (0.245, ankle),
        (0.25, knee),
        ((m.hip + 0.12) / 4, m.hip_height - base),
        ((m.waist + 0.16) / 4, waist),
        under,
    ]
    throat = neckline(neck, depth)
    strokes = (
        Stroke((0.0, waist), label=f"centre.{side}.0"),
        Stroke((0.0, hip), label=f"centre.{side}.1"),
        Stroke(
            fork_tip,
            ((0.0, hip + 0.62 * (crotch - hip)), (-0.45 * fork, fork_tip[1] + 0.002)),
            label=f"crotch.{side}",
        ),
        Stroke((0.015, knee), _slack(fork_tip, (0.015, knee), 0.10, 0.30), label="inseam.0.left"),
        Stroke((0.035, ankle), label="inseam.1.left"),
        Stroke(sides[0], contour="leg.left"),
        *smooth(sides, [f"side.{i}.left" for i in range(len(sides) - 1)]),
        armhole,
        Stroke(neck, label="shoulder.left"),
        throat,
    )
    return Outline(throat.end, strokes)


def _slack(start: Point, end: Point, at_start: float, at_end: float) -> tuple[Point, ...]:
    """Give handles of an inseam that leaves the fork flat and arrives along the leg's line."""
    a, b = np.array(start), np.array(end)
    gap = b - a
    return (
        to_point(a + np.array([0.55, 0.0]) * gap * 0.5 + np.array([0.0, at_start]) * gap),
        to_point(b - np.array([0.0, at_end]) * gap),
    )


def _on_side(stroke: Stroke, side: str) -> Stroke:
    """Tell front and back crotch seams apart: front sews to front."""
    if not stroke.label.startswith("crotch"):
        return stroke
    return replace(stroke, label=stroke.label.replace("crotch", f"crotch.{side}"))
