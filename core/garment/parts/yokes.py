"""Divide the upper end of a bodice's front or back by a yoke (W. Aldrich, Metric Pattern Cutting for Women's Wear)."""

from __future__ import annotations

import numpy as np

from ..outline import Outline, Point, Stroke, cut_stroke, mirror, stroke_points, unfold_closed
from .cut import Cut, Legs, PartsConflict, Shaping, SleeveHead

YOKE_SHARE = 0.6
"""Share of an armhole below its yoke: the yoke ends 8 to 9 cm below the shoulder, as on shirts behind and on western
shirts in front."""

MIN_YOKE_NECK_DISTANCE = 0.02
"""Smallest height between a yoke's seam and the lowest point of its neckline [m]: a narrower piece cannot be sewn."""

STROKE_SEGMENT_COUNT = 256
"""Number of pieces of a stroke among which the one that crosses a height is found, with linear interpolation in it."""


def divide_armhole(
    cut: Cut, face: str, underarm: Point, armhole: Stroke, neckline: tuple[Stroke, ...]
) -> tuple[Stroke, Stroke]:
    """Return an armhole cut where the yoke of a front or back meets it. Where the neckline would end within
    `MIN_YOKE_NECK_DISTANCE` of the yoke's seam, the seam is moved down to that distance below it.

    Args:
        cut: The garment's.
        face: `front` or `back`.
        underarm: Underarm point, from which the armhole is drawn [m].
        armhole: From there to the shoulder's tip.
        neckline: From the side neck point to the middle.

    Raises:
        PartsConflict: where there is no armhole for a yoke to end at.
    """
    if cut.sleeve_head is SleeveHead.RAGLAN:
        raise PartsConflict("a bodice's yoke ends at an armhole, which a raglan sleeve has not; choose one of them.")
    if cut.shaping is Shaping.PRINCESS or cut.legs is not Legs.NONE:
        raise PartsConflict("a bodice's yoke is not drafted across princess seams or above legs; choose yoke=none.")
    labels = ("", "") if armhole.contour else (f"scye.{face}.left", f"scye.{face}.yoke.left")
    divided, deep = cut_stroke(underarm, armhole, YOKE_SHARE, labels), neckline[-1].end[1]
    if abs(deep - divided[0].end[1]) >= MIN_YOKE_NECK_DISTANCE:
        return divided
    return cut_stroke(underarm, armhole, share_at_height(underarm, armhole, deep - MIN_YOKE_NECK_DISTANCE), labels)


def cut_yoke(face: str, upper: list[Stroke]) -> tuple[list[Stroke], list[tuple[str, Outline]]]:
    """Cut the upper end of a front or back along a level line from the armhole.

    Args:
        face: `front` or `back`.
        upper: Its strokes from the underarm point to the middle; the first ends where the armhole is divided.

    Returns:
        The strokes of the part below, and the yoke's panels by name: one, or two beside a neckline that reaches below
            the line.

    Raises:
        PartsConflict: where a collar would be sewn to both sides of the line.
    """
    lower, rest = upper[0], upper[1:]
    (x, y), deep, label = lower.end, rest[-1].end[1], f"yoke.{face}.left"
    seam = Stroke((x, y), label=label)
    if deep > y:
        whole = unfold_closed(Outline((0.0, y), (seam, *rest)))
        return [lower, Stroke((0.0, y), label=label)], [(f"{face}_yoke", whole)]
    above, below = _divide(rest, y)
    if above[-1].label:
        raise PartsConflict("a collar is sewn to a neckline in one piece; choose yoke=back, or collar=none.")
    left = Outline(above[-1].end, (seam, *above))
    pieces = [(f"{face}_yoke_left", left), (f"{face}_yoke_right", mirror(left))]
    return [lower, Stroke(left.start, label=label), *below], pieces


def _divide(strokes: list[Stroke], height: float) -> tuple[list[Stroke], list[Stroke]]:
    """Return strokes up to where their line falls to a height [m], and from there on."""
    crossing = next(i for i, stroke in enumerate(strokes) if i > 0 and stroke.end[1] < height)
    start, stroke = strokes[crossing - 1].end, strokes[crossing]
    above, below = cut_stroke(start, stroke, share_at_height(start, stroke, height), (stroke.label, stroke.label))
    level = Stroke((above.end[0], height), above.handles, above.label, above.contour)
    return [*strokes[:crossing], level], [below, *strokes[crossing + 1 :]]


def share_at_height(start: Point, stroke: Stroke, height: float) -> float:
    """Return the share of its length at which a stroke first crosses a height [m]."""
    over = stroke_points(start, stroke, STROKE_SEGMENT_COUNT)[:, 1] - height  # uniform in arc length
    after = int(np.argmax(over * over[0] <= 0.0))
    return float(after - over[after] / (over[after] - over[after - 1])) / STROKE_SEGMENT_COUNT
