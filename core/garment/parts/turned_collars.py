"""Draft collars that turn over: a stand, sewn to a crew neck, and a fall, sewn to it along the crease about which it
turns (W. Aldrich, Metric Pattern Cutting for Women's Wear; H. Joseph-Armstrong, Patternmaking for Fashion Design).
The fall is one panel from one front edge over the centre back to the other; the stand's ends are sewn to each other
at the centre front where the garment is not opened there. Where the crease is a straight line on both
panels, stand and fall are cut in one piece, which is folded there; where it is not, it is a seam. The lapels of a
jacket are panels of their own beyond a straight roll line, and are cut in one piece with the fronts."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..creases import CREASE_LABEL
from ..outline import (
    Outline,
    Point,
    Stroke,
    arc_handles,
    cut_stroke,
    halve,
    labelled_length,
    mirror,
    place_panel,
    stroke_points,
    to_point,
    unfold_closed,
)
from ..pattern import Panel
from .cut import Collar, Cut, Front, PartsConflict
from .fronts import cut_front

ROLL_LINE_SEGMENT_COUNT = 256
"""Number of segments of a neckline on which the roll line is intersected: half a millimetre each."""

BREAK_DEPTH = 0.30
"""Depth of the break point, where a lapel begins to turn, below the side neck point [m]: a little below the bust line,
as in a jacket of two buttons."""

ROLL_INWARD = 0.02
"""Distance from the side neck point to the roll line, along the shoulder line continued towards the neck [m]: that of
the stand's height less 5 mm (H. Joseph-Armstrong, notched lapel)."""

LAPEL_BOW = 0.04
"""Height of a lapel's outer edge over its chord [chords]: 1 cm."""


@dataclass(frozen=True)
class CollarMeasures:
    """Describe the measures of a turned collar.

    Attributes:
        stand: Height of the stand at the centre back [m].
        front_stand: Height of a straight stand at its front end [m]; 0 where it ends on the roll line of a lapel.
        fall: Width of the fall at the centre back [m]; it covers the neckline's seam.
        end: Length of the fall's front edge, or of its part beside a lapel that is not sewn to it [m].
        slant: Angle of that edge from the right angle to the crease, towards the front [rad].
        rise: Rise of the stand's front end over its back [m]; it makes the crease shorter than the neckline.
        drop: Drop of the fall's crease at its front end below the back [m]; it makes the outer edge longer.
        gorge: Length of the seam of fall and lapel [m]; 0 without a lapel.
        lapel: Length of a lapel's upper edge beyond the gorge seam [m].
    """

    stand: float
    front_stand: float
    fall: float
    end: float
    slant: float = 0.0
    rise: float = 0.0
    drop: float = 0.0
    gorge: float = 0.0
    lapel: float = 0.0


TURNED_COLLARS: dict[Collar, CollarMeasures] = {
    Collar.SHIRT: CollarMeasures(0.03, 0.03, 0.045, 0.07, slant=0.35, rise=0.015, drop=0.03),
    Collar.CONVERTIBLE: CollarMeasures(0.03, 0.02, 0.05, 0.07, slant=0.45),
    Collar.POLO: CollarMeasures(0.03, 0.03, 0.045, 0.06, slant=0.25),
    Collar.NOTCHED: CollarMeasures(0.025, 0.0, 0.045, 0.035, slant=-0.7, drop=0.03, gorge=0.035, lapel=0.035),
    Collar.SHAWL: CollarMeasures(0.025, 0.0, 0.045, 0.0, drop=0.03, gorge=0.06),
}
"""Measures of each collar. A shirt's has a stand of 3 cm, raised by 1.5 cm in front, a fall of 4.5 cm and points of 7
cm (Aldrich, shirt collar with a stand). A convertible one is a strip of 8 cm, narrowed to a stand of 2 cm at the centre
front (Aldrich, convertible collar). A polo shirt's is a knitted strip of 7.5 cm with slanted ends. A jacket's has a
stand of 2.5 cm, a fall of 4.5 cm, and a notch of 3.5 cm at both edges (Aldrich, classic tailored collar); a shawl
collar has none."""

LAPELLED_COLLARS = (Collar.NOTCHED, Collar.SHAWL)
"""Collars that end in lapels."""


def check_turned_collar(cut: Cut) -> None:
    """Check that a front with lapels opens.

    Raises:
        PartsConflict: where it does not.
    """
    if cut.collar in LAPELLED_COLLARS and cut.front not in (Front.BUTTONS, Front.OPEN):
        raise PartsConflict(f"a {cut.collar} collar ends in lapels; choose front=buttons or front=open.")


def sew_lapel(neck: Point, neckline: tuple[Stroke, ...]) -> tuple[Stroke, ...]:
    """Return half a front neckline, an edge that a stand is sewn to, cut off along the roll line of a lapel.

    The roll line is straight from the break point at the centre front to `ROLL_INWARD` beside the side neck point. The
    stand is sewn to the neckline up to it.

    Args:
        neck: The side neck point [m].
        neckline: From there to the middle; one stroke.
    """
    low, high = (0.0, neck[1] - BREAK_DEPTH), (neck[0] - ROLL_INWARD, neck[1])
    line = stroke_points(neck, neckline[0], ROLL_LINE_SEGMENT_COUNT)
    along = np.array(high) - low
    beside = along[0] * (line[:, 1] - low[1]) - along[1] * (line[:, 0] - low[0])
    crossing = int(np.argmax(beside > 0.0))
    share = (crossing - beside[crossing] / (beside[crossing] - beside[crossing - 1])) / ROLL_LINE_SEGMENT_COUNT
    sewn, _ = cut_stroke(neck, neckline[0], share, (neckline[0].label, ""))
    return (sewn, Stroke(low, label=f"{CREASE_LABEL}lapel.left"))


def turned_collar(
    cut: Cut, neck: Point, necklines: tuple[tuple[Stroke, ...], tuple[Stroke, ...]], height: float
) -> list[Panel]:
    """Draw stand, fall and lapels of a collar.

    Args:
        cut: The garment's.
        neck: The side neck point [m].
        necklines: From there to the middle, in front and behind; in front to the break point of a lapel.
        height: Of the draft's origin [m].
    """
    measures = TURNED_COLLARS[cut.collar]
    front, back = (labelled_length(Outline(neck, line), "collar") for line in necklines)
    upper = neck[1] + measures.stand
    behind = (
        Stroke((back, neck[1]), label="collar.back.left"),
        Stroke((back, upper), label="collarside.left"),
        Stroke((0.0, upper), label=f"{CREASE_LABEL}collar.back.left"),
    )
    drawn = unfold_closed(Outline((0.0, neck[1]), behind))
    panels = [place_panel("collar_back", drawn, height, label="collar")]
    half = _draw_front_stand(measures, front, neck[1])
    if cut.collar in LAPELLED_COLLARS:
        pieces = [("collar_front_left", half), ("collar_front_right", mirror(half))]
    elif cut.front is Front.NONE:
        left = halve(unfold_closed(half), Stroke((0.0, 0.0), label="collarend"))
        pieces = [("collar_front_left", left), ("collar_front_right", mirror(left))]
    else:
        pieces = cut_front(cut, "collar_front", unfold_closed(half))
    grains = {"collar_front_left": 2.0 * measures.rise / front, "collar_front_right": -2.0 * measures.rise / front}
    panels += [place_panel(part, outline, height, grains[part], "collar") for part, outline in pieces]
    rolled = labelled_length(half, CREASE_LABEL)
    fall = place_panel("collar_back", _draw_fall(measures, rolled, back, upper), height, label="collar")
    panels.append(replace(fall, name="collar_fall"))
    if cut.collar in LAPELLED_COLLARS:
        lapel = _draw_lapel(measures, necklines[0][0].end, necklines[0][1].end)
        lapels = (("lapel_left", lapel), ("lapel_right", mirror(lapel)))
        panels += [place_panel(part, outline, height, label="lapel") for part, outline in lapels]
    return panels


def _draw_front_stand(measures: CollarMeasures, length: float, low: float) -> Outline:
    """Draw the left front of a stand from its front end; its lower edge has the neckline's length [m]. Where it rises,
    the edges are arcs about one centre; where not, its crease is a level line, to which it narrows."""
    upper, narrower = low + measures.stand, measures.stand - measures.front_stand
    collar, crease = "collar.front.left", f"{CREASE_LABEL}collar.front.left"
    if not measures.rise:
        width = math.sqrt(length**2 - narrower**2)
        strokes = (
            Stroke((width, low), label=collar),
            Stroke((width, upper), label="collarside.left"),
            Stroke((0.0, upper), label=crease),
        )
        return Outline((0.0, low + narrower), strokes)
    turn = 2.0 * measures.rise / length
    lower = _draw_arc((0.0, low), 0.0, length, turn, collar)
    x, y = lower.end
    corner = (x - measures.stand * math.sin(turn), y + measures.stand * math.cos(turn))
    back = Stroke((0.0, upper), arc_handles(corner, (0.0, upper), -turn), crease)
    return Outline((0.0, low), (lower, Stroke(corner, label="collarside.left"), back))


def _draw_fall(measures: CollarMeasures, front: float, back: float, low: float) -> Outline:
    """Draw a fall above its crease at height `low`, whose parts before and behind the shoulder seams have the lengths
    `front` and `back` on each side [m]. A crease that drops is an arc."""
    whole = front + back
    turn = -2.0 * measures.drop / whole
    behind = _draw_arc((0.0, low), 0.0, back, turn * back / whole, f"{CREASE_LABEL}collar.back.left")
    before = _draw_arc(behind.end, turn * back / whole, front, turn * front / whole, f"{CREASE_LABEL}collar.front.left")
    along, across = np.array([math.cos(turn), math.sin(turn)]), np.array([-math.sin(turn), math.cos(turn)])
    corner = np.array(before.end)
    strokes = [behind, before]
    if measures.gorge:
        strokes.append(Stroke(to_point(corner + measures.gorge * across), label="gorge.left"))
    tip = np.array(strokes[-1].end)
    if measures.end:
        tip = tip + measures.end * (math.cos(measures.slant) * across + math.sin(measures.slant) * along)
        strokes.append(Stroke(to_point(tip), contour="neck"))
    middle = (0.0, low + measures.fall)
    handles = (to_point(corner + measures.fall * across - whole / 3.0 * along), (whole / 3.0, middle[1]))
    return unfold_closed(Outline((0.0, low), (*strokes, Stroke(middle, handles, contour="neck"))))


def _draw_lapel(measures: CollarMeasures, top: Point, low: Point) -> Outline:
    """Draw the left lapel beyond its roll line, from the break point `low` to the end of the stand, `top` [m]. Its
    upper edge, at a right angle to the roll line, is sewn to the fall along the gorge."""
    roll = np.array(top) - low
    across = np.array([-roll[1], roll[0]]) / np.linalg.norm(roll)
    strokes = [
        Stroke(top, label=f"{CREASE_LABEL}lapel.left"),
        Stroke(to_point(top + measures.gorge * across), label="gorge.left"),
    ]
    if measures.lapel:
        strokes.append(Stroke(to_point(top + (measures.gorge + measures.lapel) * across), contour="neck"))
    tip = np.array(strokes[-1].end)
    edge = low - tip
    bow = 4.0 / 3.0 * LAPEL_BOW * np.array([edge[1], -edge[0]])
    handles = (to_point(tip + edge / 3.0 + bow), to_point(tip + 2.0 * edge / 3.0 + bow))
    return Outline(low, (*strokes, Stroke(low, handles, contour="neck")))


def _draw_arc(start: Point, heading: float, length: float, turn: float, label: str) -> Stroke:
    """Draw an arc of a length [m] that begins in a direction and turns by an angle [rad]: a line where that is 0."""
    if not turn:
        return Stroke((start[0] + length * math.cos(heading), start[1] + length * math.sin(heading)), label=label)
    chord = length * math.sin(turn / 2.0) / (turn / 2.0) * np.exp(1j * (heading + turn / 2.0))
    end = (start[0] + float(chord.real), start[1] + float(chord.imag))
    drawn = Stroke(end, arc_handles(start, end, turn), label)
    share = length / labelled_length(Outline(start, (drawn,)), label)
    end = (start[0] + share * float(chord.real), start[1] + share * float(chord.imag))
    return Stroke(end, arc_handles(start, end, turn), label)
