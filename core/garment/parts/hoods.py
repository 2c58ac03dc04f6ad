"""Draft hoods on a crew neck (W. Aldrich, Metric Pattern Cutting for Women's Wear; H. Joseph-Armstrong, Patternmaking
for Fashion Design): two side pieces sewn to each other at the centre back, from the nape over the head to the forehead,
or sewn to a strip between them. Their lower edges are as long as the neckline, from the centre back to the centre
front, where the edges of the face opening meet."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..measures import BodyMeasures
from ..outline import Outline, Point, Stroke, cut_stroke, labelled_length, mirror, place_panel
from ..pattern import Panel
from .cut import Bodice, Collar, Cut, Hood, HoodWorn, Neckline, PartsConflict, SleeveHead

HOOD_LABEL = "hood"
"""Label of a hood's panels."""

HEAD_HEIGHT = 0.26
"""Height of the crown above the side neck point [m]: 0.249 to 0.265 of the built-in bodies from 1.55 to 1.90 m, women
and men; heads of adults grow little with the stature."""

HEAD_GIRTH = 0.57
"""Girth of an adult's head [m]: 0.561 on average of women, 0.574 of men, with 3 % of deviation (ANSUR II, 2012)."""

COVERED_GIRTH_SHARE = 0.75
"""Share of the head's girth that a hood covers, from temple to temple around the back [1]."""

HEIGHT_EASE = 0.04
"""Ease above the crown [m], so that a hood does not pull at the neckline when the head is bent."""

DEPTH_EASE = 0.03
"""Ease of each side piece in depth [m]."""

CENTRE_BACK_BULGE = 0.012
"""Distance by which the centre back seam, at the back of the head, is behind its lower end [m]."""

BULGE_SHARE = 0.5
"""Share of a hood's height at which its centre back seam is furthest back [1]."""

CROWN_DEPTH_SHARE = 0.5
"""Share of a hood's depth at which its centre back seam is highest [1]."""

FOREHEAD_DROP = 0.02
"""Height of the forehead's end of that seam below the highest place [m]."""

STRIP_WIDTH = 0.09
"""Width of the strip of a hood of three pieces [m]: 8 to 10 cm are usual."""

QUARTER_TURN_HANDLE = 0.5523
"""Distance of a cubic's handles from the ends of a quarter of an ellipse [semi-axes]."""

PLACED_ASIDE = 0.10
"""Distance at which side pieces are placed beside the middle plane [m]: half the breadth of a head with its ears is
0.085."""

BACKWARD_LEAN = math.radians(90.0)
"""Angle by which the side pieces of a hood that is worn down are placed leaning backwards [rad]: behind the neck, with
the face opening upwards, from where the hood falls on the back."""


def check_hood(cut: Cut) -> None:
    """Check that a cut has a neckline that a hood can be sewn to.

    Raises:
        PartsConflict: where it has none, or it is no crew neck in two halves, or something else is sewn to it.
    """
    if cut.hood is Hood.NONE:
        return
    if cut.bodice in (Bodice.NONE, Bodice.HALTER, Bodice.STRAPLESS):
        raise PartsConflict("a hood is sewn to a neckline on shoulders; choose bodice=boxy, shift or skimming.")
    if cut.collar is not Collar.NONE:
        raise PartsConflict("a hood and a collar are sewn to the same neckline; choose collar=none, or hood=none.")
    if (cut.neckline, cut.back_neckline) != (Neckline.CREW, Neckline.CREW):
        raise PartsConflict("a hood is drafted on a crew neck; choose neckline=crew and back_neckline=crew.")
    if cut.sleeve_head is SleeveHead.RAGLAN:
        raise PartsConflict("a hood is drafted on a neckline in two halves; choose another sleeve_head.")


def sew_hood(cut: Cut, face: str, neck: Point, neckline: tuple[Stroke, ...]) -> tuple[Stroke, ...]:
    """Return half a neckline as an edge that a hood is sewn to, its strip at the centre back.

    Args:
        cut: The garment's.
        face: `front` or `back`.
        neck: The side neck point [m].
        neckline: From there to the middle.
    """
    sewn = tuple(replace(stroke, label=f"hood.{face}.left", contour="") for stroke in neckline)
    if cut.hood is not Hood.THREE or face == "front":
        return sewn
    (stroke,) = sewn
    share = 1.0 - 0.5 * STRIP_WIDTH / labelled_length(Outline(neck, sewn), "hood")
    return cut_stroke(neck, stroke, share, (stroke.label, "hood.strip.left"))


def draw_hood(
    cut: Cut, m: BodyMeasures, neck: Point, necklines: tuple[tuple[Stroke, ...], tuple[Stroke, ...]]
) -> list[Panel]:
    """Draw the pieces of a hood, placed beside the head, or leaning backwards where it is worn down.

    Args:
        cut: The garment's.
        m: The wearer's measures.
        neck: The side neck point [m].
        necklines: From there to the middle, in front and behind.
    """
    lengths = [labelled_length(Outline(neck, line), f"hood.{face}") for face, line in _by_face(necklines)]
    low = [line[-1].end[1] for line in necklines]
    strip = 0.5 * STRIP_WIDTH if cut.hood is Hood.THREE else 0.0
    side = _SidePiece.of((lengths[0], lengths[1]), (low[0], low[1]), strip)
    crown = side.crown
    if strip:
        crown = tuple(replace(stroke, label=f"{stroke.label}.left") for stroke in crown)
    face = Stroke(side.front_end, contour="neck")
    left = Outline(side.front_end, (*side.lower, *crown, face))
    lean = BACKWARD_LEAN if cut.hood_worn is HoodWorn.DOWN else 0.0
    panels = [_place("hood_left", left, m.nape_height, lean), _place("hood_right", mirror(left), m.nape_height, lean)]
    return [*panels, _draw_strip(left, m.nape_height)] if strip else panels


def _by_face(necklines: tuple[tuple[Stroke, ...], tuple[Stroke, ...]]) -> zip[tuple[str, tuple[Stroke, ...]]]:
    return zip(("front", "back"), necklines, strict=True)


@dataclass(frozen=True)
class _SidePiece:
    """Describe the left side piece of a hood as seen from the wearer's left, x backwards from the centre back.

    Attributes:
        front_end: Its lower corner at the centre front [m].
        lower: From there to the centre back.
        crown: From there to the forehead.
    """

    front_end: Point
    lower: tuple[Stroke, Stroke]
    crown: tuple[Stroke, ...]

    @classmethod
    def of(cls, lengths: tuple[float, float], low: tuple[float, float], strip: float) -> _SidePiece:
        """Draw the piece.

        Args:
            lengths: Of the front and the back part of its lower edge [m].
            low: Heights of the neckline's middle in front and behind, from the side neck point [m].
            strip: Half the width of the strip at its upper edge [m].
        """
        (front, back), nape = lengths, low[1]
        top, depth = HEAD_HEIGHT + HEIGHT_EASE - strip, _side_depth()
        shoulder = (-strip - back, nape)
        lower = _draw_front_edge(shoulder, front, low[0] - nape)
        half = nape + BULGE_SHARE * (top - nape)
        hind, crown = -strip + CENTRE_BACK_BULGE, -CROWN_DEPTH_SHARE * depth
        rise, reach = top - half, hind - crown
        handle = QUARTER_TURN_HANDLE
        return cls(
            lower[0],
            (lower[1], Stroke((-strip, nape), label="hood.back.left")),
            (
                Stroke((hind, half), ((-strip, nape + 0.4 * (half - nape)), (hind, half - 0.3 * rise)), "hoodcrown.1"),
                Stroke((crown, top), ((hind, half + handle * rise), (crown + handle * reach, top)), "hoodcrown.2"),
                Stroke(
                    (-depth, top - FOREHEAD_DROP),
                    ((crown - 0.4 * (depth + crown), top), (-depth + 0.3 * (depth + crown), top - 0.7 * FOREHEAD_DROP)),
                    "hoodcrown.3",
                ),
            ),
        )


def _side_depth() -> float:
    """Return the depth of a side piece from its centre back seam to the face [m]."""
    return 0.5 * COVERED_GIRTH_SHARE * HEAD_GIRTH + DEPTH_EASE


def _draw_front_edge(shoulder: Point, length: float, rise: float) -> tuple[Point, Stroke]:
    """Draw the lower edge from the centre front to the shoulder seam, level there and falling to the front.

    Args:
        shoulder: Its end [m].
        length: Its length [m].
        rise: Height of its start above its end, negative [m].

    Returns:
        Its start [m], and the stroke.
    """

    from scipy.optimize import brentq

    def draw(width: float) -> tuple[Point, Stroke]:
        (x, y), start = shoulder, (shoulder[0] - width, shoulder[1] + rise)
        handles = ((x - 0.7 * width, y + 0.6 * rise), (x - 0.4 * width, y))
        return start, Stroke(shoulder, handles, "hood.front.left", notch=0.5)

    def excess(width: float) -> float:
        start, stroke = draw(width)
        return labelled_length(Outline(start, (stroke,)), "hood") - length

    return draw(float(brentq(excess, 0.1 * length, length, xtol=1e-12)))


def _place(name: str, outline: Outline, height: float, lean: float) -> Panel:
    """Place a side piece beside the head, its lower edge at the neck, leaning backwards by an angle [rad]."""
    side = -1.0 if name.endswith("right") else 1.0
    up = np.array([0.0, math.cos(lean), -math.sin(lean)])
    across = side * np.array([0.0, -math.sin(lean), -math.cos(lean)])
    rotation = np.column_stack([across, up, [side, 0.0, 0.0]])
    flat = place_panel(name, outline, height, label=HOOD_LABEL)
    return replace(flat, rotation=rotation, translation=np.array([side * PLACED_ASIDE, height, 0.0]))


def _draw_strip(left: Outline, height: float) -> Panel:
    """Draw the strip between the side pieces: as long as their upper edge, its ends at the nape and the forehead."""
    half, nape = 0.5 * STRIP_WIDTH, left.strokes[1].end[1]
    low = nape
    strokes = [Stroke((half, low), label="hood.strip.left")]
    for number in (1, 2, 3):
        label = f"hoodcrown.{number}.left"
        low += labelled_length(left, label)
        strokes.append(Stroke((half, low), label=label))
    half_outline = Outline((0.0, nape), tuple(strokes))
    forehead = Stroke((-half, low), contour="neck")
    outline = Outline((0.0, nape), (*strokes, forehead, *mirror(half_outline).strokes))
    return place_panel("hood_centre_back", outline, height, label=HOOD_LABEL)
