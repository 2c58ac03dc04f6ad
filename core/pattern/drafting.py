"""Draft the five base patterns from body measures, by the rules of a tailor's block.

All five are blocks without darts or zips, for planar placement: front and back stand before and behind the body, and
half sleeves continue them in the same plane, so that a flattened body in T-pose fits between. A draft is made in the
front plane seen from outside: x to the wearer's left, y up. Seams are equal because both sides are the same curve, or
because one corner was solved for (trousers).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import root

from .division import divide_edges
from .garmentcode import save_pattern
from .outline import Outline, Point, Stroke, length, mirror, place_panel, sew_by_label, smooth, unfold
from .pattern import Panel, Pattern

CREASE_FROM_MIDDLE = 0.12
"""Where each leg's crease line stands at first [m]: outside the ankles, so that no panel reaches over the middle."""

_EASED = ("inseam.0", "outseam.1", "outseam.2")
"""Seams of the trousers whose back is fitted to the front."""


@dataclass(frozen=True)
class BodyMeasures:
    """Hold the measures that the drafts need.

    The defaults are those of the built-in female body of 1.70 m, standing in T-pose with her feet at y = 0.

    Attributes:
        bust, waist, hip: Girths [m].
        nape_height: Height of the side neck point, where neck and shoulder meet [m].
        armpit_height, waist_height, hip_height, crotch_height: Heights above the feet [m].
        shoulder_half_width: From the middle to the shoulder's bone end [m].
        neck_half_width: From the middle to the side neck point [m].
    """

    bust: float = 0.92
    waist: float = 0.72
    hip: float = 1.00
    nape_height: float = 1.435
    armpit_height: float = 1.29
    waist_height: float = 1.07
    hip_height: float = 0.82
    crotch_height: float = 0.79
    shoulder_half_width: float = 0.18
    neck_half_width: float = 0.07


def draft_tshirt(measures: BodyMeasures | None = None) -> Pattern:
    """Draft a T-shirt: front, back and four half sleeves with short, slightly drooping sleeves.

    Allowances: bust + 10 cm (a regular T-shirt), armhole 7 cm below the armpit, 1 cm of shoulder drop, neck 2 cm
    wider than the body's at each side and 10 cm deep in front so that it passes the head, hem 2 cm below the hip line.
    The sleeve droops by 12 degrees: between an arm stretched out (0) and one hanging (about 60), nearer to the T-pose.
    """
    m = measures or BodyMeasures()
    half = (m.bust + 0.10) / 4
    neck = (m.neck_half_width + 0.02, 0.0)
    tip = (m.shoulder_half_width + 0.01, -0.04)
    under = (half, m.armpit_height - 0.07 - m.nape_height)
    hem = (half, m.hip_height - 0.02 - m.nape_height)
    panels = []
    for side, depth, hollow in (("front", 0.10, 0.050), ("back", 0.025, 0.042)):
        scye = ((under[0] - hollow, under[1] + 0.004), (tip[0] - 0.012, tip[1] - 0.08))
        outline = Outline(
            hem,
            (
                Stroke(under, label="side.left", notch=0.5),
                Stroke(tip, scye, label=f"scye.{side}.left", notch=0.45),
                Stroke(neck, label="shoulder.left"),
                _neckline(neck, depth),
            ),
        )
        panels.append(place_panel(side, unfold(outline, "hem"), m.nape_height))
        panels += _half_sleeves(side, under, tip, scye, m.nape_height)
    order = ("front", "back")
    panels.sort(key=lambda p: (p.name not in order, p.name))
    return sew_by_label("tshirt", "tshirt", panels)


def _half_sleeves(side: str, under: Point, tip: Point, scye: tuple[Point, ...], height: float) -> list[Panel]:
    """Draw the left half sleeve of one side in the body's plane and mirror it for the right.

    The cap is the armhole's own curve. 19 cm along the top and a cuff of 2 x 17.5 cm: a short sleeve with 8 cm of ease.
    """
    droop = np.deg2rad(12.0)
    along = np.array([np.cos(droop), -np.sin(droop)])
    top = np.array(tip) + 0.19 * along
    low = top + 0.175 * np.array([along[1], -along[0]])
    outline = Outline(
        tip,
        (
            Stroke(under, scye[::-1], label=f"scye.{side}.left", notch=0.55),
            Stroke(_point(low), label="undersleeve.left"),
            Stroke(_point(top), label="", contour="cuff.left"),
            Stroke(tip, label="oversleeve.left"),
        ),
    )
    # The warp runs along the arm; a grainline is a line, so its angle is given within a quarter turn of +y.
    grain = np.pi / 2 - droop
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
            _neckline(neck, depths[side]),
        ]
        panels.append(place_panel(side, unfold(Outline(points[0], tuple(strokes)), "hem"), m.nape_height))
    return sew_by_label(name, category, panels)


def draft_skirt(measures: BodyMeasures | None = None) -> Pattern:
    """Draft an A-line skirt of two panels from the natural waist to above the knee.

    Allowances: waist + 2 cm (held there), hip + 5 cm, hem 1.30 m wide. Waist and hem dip by 12 and 15 mm at the
    middle, so that both meet the slanted side seams nearly at a right angle and the hem hangs level. Control points at
    every quarter of waist and hem, so that grading can open it to a full circle.
    """
    m = measures or BodyMeasures()
    waist, hip = (m.waist + 0.02) / 4, (m.hip + 0.05) / 4
    points = [(0.325, -0.54), (hip, m.hip_height - m.waist_height), (waist, 0.0)]
    strokes = smooth(points, ["side.0.left", "side.1.left"])
    strokes.append(Stroke((0.0, -0.012), ((waist * 0.6, -0.010), (waist * 0.3, -0.012)), contour="waist"))
    outline = unfold(Outline(points[0], tuple(strokes)), "hem", dip=0.015)
    panels = [place_panel(side, outline, m.waist_height) for side in ("front", "back")]
    return divide_edges(divide_edges(sew_by_label("skirt", "skirt", panels), {"hem"}, 4), {"waist"}, 2)


def draft_trousers(measures: BodyMeasures | None = None) -> Pattern:
    """Draft straight trousers: front and back of each leg.

    Allowances: they sit 6 cm below the natural waist, where the girth is about waist + 6 cm; hip + 6 cm, the front
    1 cm narrower and the back 1 cm wider than a quarter, measured a third of the rise above the crotch; crotch 1.5 cm
    below the body's; forks of hip / 16 - 1 cm (front) and hip / 8 - 2 cm (back), the seat's depth; knee 45 cm and hem
    40 cm around. The back fork is lowered and the back's side corners moved until inseams and outseams are equal.
    """
    m = measures or BodyMeasures()
    base = m.waist_height
    crotch = m.crotch_height - 0.015 - base
    top = -0.06
    hip = crotch + (top - crotch) / 3
    front = _leg(
        m, crotch, hip, top, side_shift=-0.01, fork=m.hip / 16 - 0.01, rise=0.0, fork_drop=0.0, lift=(0.0, 0.0)
    )

    def back(drop: float, hip_lift: float, side_lift: float) -> Outline:
        fork = m.hip / 8 - 0.02
        lift = (hip_lift, side_lift)
        return _leg(m, crotch, hip, top, side_shift=0.01, fork=fork, rise=0.02, fork_drop=drop, lift=lift)

    def excess(moves: np.ndarray) -> np.ndarray:
        drawn = back(*moves)
        return np.array([length(drawn, name) - length(front, name) for name in _EASED])

    solved = root(excess, np.zeros(len(_EASED)), tol=1e-9)
    panels = []
    for side, outline in (("front", front), ("back", back(*solved.x))):
        crease = sum(p.end[0] for p in outline.strokes if p.label == "inseam.1.left" or p.contour == "leg.left") / 2
        named = replace(outline, strokes=tuple(_on_side(s, side) for s in outline.strokes))
        for leg, drawn in (("left", named), ("right", mirror(named))):
            across = CREASE_FROM_MIDDLE - crease if leg == "left" else crease - CREASE_FROM_MIDDLE
            panels.append(place_panel(f"{side}_{leg}", drawn, base, label="leg", across=across))
    return sew_by_label("trousers", "trousers", panels)


def _leg(
    m: BodyMeasures,
    crotch: float,
    hip: float,
    top: float,
    *,
    side_shift: float,
    fork: float,
    rise: float,
    fork_drop: float,
    lift: tuple[float, float],
) -> Outline:
    """Draw one left leg panel around its crease line, which halves the distance from fork to side."""
    side = (m.hip + 0.06) / 4 + side_shift
    waist = (m.waist + 0.06) / 4 + side_shift / 2
    crease = (side - fork) / 2
    slant = 1.4 * rise + 0.01
    ankle, knee = 0.08 - m.waist_height, 0.47 - m.waist_height
    hem_half, knee_half = 0.10 + side_shift / 2, 0.1125 + side_shift / 2
    tip = (-fork, crotch - fork_drop)
    centre = (slant, top + rise)
    seat = (0.0, hip)
    strokes = [
        Stroke(seat, label="crotch.0"),
        Stroke(tip, ((0.0, hip + 0.62 * (crotch - hip)), (-0.45 * fork, tip[1] + 0.002)), label="crotch.1"),
        Stroke((crease - knee_half, knee), _slack(tip, (crease - knee_half, knee), 0.10, 0.30), label="inseam.0.left"),
        Stroke((crease - hem_half, ankle), label="inseam.1.left"),
        Stroke((crease + hem_half, ankle), contour="leg.left"),
        Stroke((crease + knee_half, knee), label="outseam.0.left"),
    ]
    thigh = [(crease + knee_half, knee), (side, hip + lift[0]), (slant + waist, top + lift[1])]
    strokes += smooth(thigh, ["outseam.1.left", "outseam.2.left"])
    strokes.append(Stroke(centre, contour="waist"))
    return Outline(centre, tuple(strokes))


def _slack(start: Point, end: Point, at_start: float, at_end: float) -> tuple[Point, ...]:
    """Give handles of an inseam that leaves the fork flat and arrives along the leg's line."""
    a, b = np.array(start), np.array(end)
    gap = b - a
    return (
        _point(a + np.array([0.55, 0.0]) * gap * 0.5 + np.array([0.0, at_start]) * gap),
        _point(b - np.array([0.0, at_end]) * gap),
    )


def _on_side(stroke: Stroke, side: str) -> Stroke:
    """Tell front and back crotch seams apart: front sews to front."""
    if not stroke.label.startswith("crotch"):
        return stroke
    return replace(stroke, label=stroke.label.replace("crotch", f"crotch.{side}"))


def _neckline(neck: Point, depth: float) -> Stroke:
    """Draw half a neckline: off the shoulder at a right angle, level at the middle."""
    low = neck[1] - depth
    return Stroke(
        (0.0, low), ((neck[0] - 0.1 * neck[0], neck[1] - 0.55 * depth), (0.55 * neck[0], low)), contour="neck"
    )


def _point(array: np.ndarray) -> Point:
    return (float(array[0]), float(array[1]))


DRAFTS: dict[str, Callable[[], Pattern]] = {
    "tshirt": draft_tshirt,
    "tank": draft_tank,
    "dress": draft_dress,
    "trousers": draft_trousers,
    "skirt": draft_skirt,
}
"""The draft of each template by name."""


def write_library(folder: Path) -> None:
    """Draft every template and write its pattern file: `python -m garmentq.core.pattern.drafting`."""
    for name, draft in DRAFTS.items():
        save_pattern(draft(), folder / f"{name}.json")


if __name__ == "__main__":
    write_library(Path(__file__).parent / "library")
