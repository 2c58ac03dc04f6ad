"""Draft wrap fronts (H. Joseph-Armstrong, Patternmaking for Fashion Design, surplice): each front reaches from its
shoulder past the centre to the other side seam, the right one over the left one. Both front edges are straight from the
side neck points; where they cross they make a V.

The outer front is sewn into the left side seam below its edge, or ends in the waist seam. The inner one ends in a tie
that is sewn into the right side seam; there the outer one's seam is open for the tie to pass, as that of a wrap dress.
The inner front's lower edge hangs below the outer one: in sewing it is caught in a waist seam, of which the pattern
joins two layers only."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

from ..outline import Outline, Stroke, cut_stroke, mirror
from .cut import Collar, Cut, Front, Hood, Legs, Neckline, PartsConflict, Shaping, SleeveHead
from .yokes import share_at_height

WRAP_LABEL = "wrap"
"""Label of the outer front, which lies over the inner one; also the open contour of what it covers: the lower edge of
the inner front, and the opening for its tie."""

TIE_WIDTH = 0.03
"""Width of the inner front's end in the side seam [m]: that of a tie belt, 2.5 to 4 cm."""

TIE_SEAM = "tie"
"""Beginning of the labels of the part of a side seam where a tie is sewn in."""


def check_wrap(cut: Cut) -> None:
    """Check that a cut has what a wrap front is drafted with.

    Raises:
        PartsConflict: where it has not.
    """
    if cut.front is not Front.WRAP:
        return
    if cut.neckline is not Neckline.V:
        raise PartsConflict("the edges of a wrap front cross in a V; choose neckline=v, or another front.")
    if cut.collar is not Collar.NONE or cut.hood is not Hood.NONE or cut.sleeve_head is SleeveHead.RAGLAN:
        raise PartsConflict(
            "a wrap's edges end at the shoulder seams, without collar, hood or raglan sleeves; choose collar=none, "
            "hood=none and another sleeve_head, or another front."
        )
    if cut.shaping is not Shaping.NONE or cut.legs is not Legs.NONE:
        raise PartsConflict("a wrap front is drafted without shaping and legs; choose shaping=none, or another front.")


def divide_side(side: list[Stroke], waist: float) -> list[Stroke]:
    """Return a side seam, whose first stroke ends at its lower end, divided at both edges of a tie.

    Args:
        side: From the hem or the waist seam to the underarm point.
        waist: Height of the natural waist, where the tie's lower edge is [m].
    """
    heights = [waist, waist + TIE_WIDTH]
    found, start = [side[0]], side[0].end
    for stroke in side[1:]:
        for height in heights:
            if start[1] < height - TIE_WIDTH / 2 and height < stroke.end[1]:
                part, stroke = cut_stroke(start, stroke, share_at_height(start, stroke, height), ("", ""))
                found.append(part)
                start = part.end
        found.append(stroke)
        start = stroke.end
    labelled = found[:1]
    for i, (before, stroke) in enumerate(pairwise(found)):
        middle = (before.end[1] + stroke.end[1]) / 2
        name = f"{TIE_SEAM}.left" if heights[0] < middle < heights[1] else f"side.{i}.left"
        labelled.append(replace(stroke, label=name))
    return labelled


def draw_wrap(side: list[Stroke], upper: list[Stroke], waist: tuple[Stroke, ...]) -> list[tuple[str, Outline]]:
    """Draw the outer and the inner front.

    Args:
        side: The left side seam from `divide_side`.
        upper: Armhole and shoulder seam, from the underarm point to the side neck point.
        waist: The left half of the front's waist seam from the middle to the side; none where the front has a hem.
    """
    corner = side[0].end
    tie = next(i for i, stroke in enumerate(side) if stroke.label.startswith(TIE_SEAM))
    low = side[tie - 1].end
    right = mirror(Outline(corner, (*side[1:], *upper)))
    edge = Stroke(right.start, contour="neck")
    across = (*mirror(Outline((0.0, corner[1]), waist)).strokes, *waist) if waist else (Stroke(corner, contour="hem"),)
    down = tuple(_open_tie(stroke) for stroke in right.strokes)
    outer = Outline(corner, (*side[1:tie], edge, *down, *across))
    tied = next(i for i, stroke in enumerate(right.strokes) if stroke.label.startswith(TIE_SEAM))
    to_tie = Stroke(right.strokes[tied - 1].end, contour="neck")
    below = Stroke(low, contour=WRAP_LABEL)
    inner = Outline(low, (*side[tie:], *upper, to_tie, right.strokes[tied], below))
    return [("front_right", outer), ("front_left", inner)]


def _open_tie(stroke: Stroke) -> Stroke:
    """Return a stroke of the outer front's side seam, open where the inner front's tie passes."""
    return replace(stroke, label="", contour=WRAP_LABEL) if stroke.label.startswith(TIE_SEAM) else stroke
