"""Shape the trunk at the waist by darts or princess seams. The construction follows W. Aldrich, Metric Pattern Cutting
for Women's Wear, the close-fitting bodice block, and H. Joseph-Armstrong, Patternmaking for Fashion Design, the
princess line: the surplus width at the waist is shared between the side seam and a dart below the bust point, behind
below the shoulder blade. A princess seam extends that dart to the middle of the shoulder, and below the waist, where
there is no seam, to the hem."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import accumulate

from ..outline import Outline, Stroke, cut_stroke, draw_monotone_spline, mirror, reverse_strokes, unfold, unfold_closed
from .cut import Cut, PartsConflict, Shaping, Skirt
from .gathers import BODICE_GATHER_RATIO

MIDDLE_SHARE = 0.46
"""Share of a quarter of the waist between the middle and its dart, in bodice and skirt: they meet at a waist seam."""

PIECE_LABEL_SUFFIXES = ("", ".side", ".side2")
"""Suffixes, between face and side, in the labels of the pieces of a quarter of the waist, from the middle."""

DART_SHARE = 0.6
"""Share of the surplus at the waist that the dart takes; the side seam takes the rest."""

DART_RANGE = (0.015, 0.05)
"""Smallest and largest intake of a dart [m]: a smaller one is not worth a seam, a larger one makes a point."""

APEX_BELOW = (0.045, 0.01)
"""Distance of darts' ends below the underarm point in front and behind [m]: 2.5 cm short of the bust point, and at the
shoulder blade."""

PRINCESS_SEAM_FLARE = 0.05
"""Flare of each princess seam of a dress [m]: its extra width at the hem over that at the hip."""


def share_waist(cut: Cut) -> tuple[float, ...]:
    """Return the shares of a quarter of the waist between its seams and darts, from the middle to the side. Darts,
    princess seams and six gores make two shares; equal gores one per gore."""
    if cut.has_equal_gores:
        wide = 4.0 / cut.panels_around
        first = wide / 2 if cut.panels_around % 4 else wide  # with an odd number on each face one is in the middle
        return (first, *[wide] * round((1.0 - first) / wide))
    if cut.is_shaped_by_seams or cut.skirt is Skirt.GORED:
        return (MIDDLE_SHARE, 1.0 - MIDDLE_SHARE)
    return (1.0,)


def label_pieces(name: str, face: str, count: int) -> list[str]:
    """Return the labels of the pieces of the left half of a face's seam, from the middle to the side."""
    return [f"{name}.{face}{part}.left" for part in PIECE_LABEL_SUFFIXES[:count]]


@dataclass(frozen=True)
class Waistline:
    """Describe half a front or back at the waist, from the middle to the side.

    Attributes:
        middle: Length between the middle and the dart [m].
        dart: The dart's intake [m].
        side: Length between the dart and the side seam [m].
        shares: Of a waist without a dart, between the seams that end there.
    """

    middle: float
    dart: float
    side: float
    shares: tuple[float, ...] = (1.0,)

    @classmethod
    def of(cls, cut: Cut, wide: float, waist: float) -> Waistline:
        """Return the line of a quarter that is `wide` without shaping and `waist` around the waist [m]."""
        if cut.shaping is Shaping.GATHERS:
            return cls(BODICE_GATHER_RATIO * waist, 0.0, 0.0, share_waist(cut))
        if cut.shaping is Shaping.NONE:
            return cls(waist, 0.0, 0.0, share_waist(cut))
        dart = min(max(DART_SHARE * (wide - waist), DART_RANGE[0]), DART_RANGE[1])
        return cls(MIDDLE_SHARE * waist, dart, (1.0 - MIDDLE_SHARE) * waist)

    @property
    def half(self) -> float:
        """Return the whole length, including the dart [m]."""
        return self.middle + self.dart + self.side

    @property
    def centre(self) -> float:
        """Return the distance of the dart's axis from the middle [m]."""
        return self.middle + self.dart / 2

    def strokes(self, face: str, low: float, apex: float) -> tuple[Stroke, ...]:
        """Draw the waist at height `low` from the middle to the side, with a dart up or down to height `apex` [m]."""
        if not self.dart:
            labels = label_pieces("waist", face, len(self.shares))
            ends = zip(accumulate(self.shares), labels, strict=True)
            return tuple(Stroke((self.half * end, low), label=label) for end, label in ends)
        return (
            Stroke((self.middle, low), label=f"waist.{face}.left"),
            Stroke((self.centre, apex), label=f"dart.{face}.left"),
            Stroke((self.middle + self.dart, low), label=f"dart.{face}.left"),
            Stroke((self.half, low), label=f"waist.{face}.side.left"),
        )


def draw_princess(
    face: str, line: Waistline, side: list[Stroke], upper: list[Stroke], apex: float, sewn: bool
) -> list[tuple[str, Outline]]:
    """Draw the middle panel and both side panels of a front or back. The gap between both edges of a princess seam is
    the dart's intake at the waist, and 0 at the apex and at the hip; towards the hem the panels overlap by
    `PRINCESS_SEAM_FLARE`. Both edges mirror each other below the apex, so they are equal in length, and are one curve
    above it.

    Args:
        face: `front` or `back`.
        line: The waist.
        side: The side seam from its lower end, which is the end of the first stroke, to the underarm.
        upper: From there over the shoulder to the middle.
        apex: Height of the bust point or shoulder blade [m].
        sewn: Whether the lower end is a waist seam, and not a hem.

    Returns:
        Name and outline of each.

    Raises:
        PartsConflict: where there is no shoulder seam for it to begin at.
    """
    shoulder = next((i for i, stroke in enumerate(upper) if stroke.label.startswith("shoulder")), None)
    if shoulder is None:
        raise PartsConflict("a princess seam begins at the shoulder seam; choose another sleeve_head or shaping=darts.")
    seam = f"princess.{face}"
    heights = [stroke.end[1] for stroke in side[:-1]]
    gaps = {0: -PRINCESS_SEAM_FLARE if len(heights) > 2 else 0.0, len(heights) - 1: line.dart}
    spine = [(gaps.get(i, 0.0) / 2, y) for i, y in enumerate(heights)] + [(0.0, apex)]
    labels = [f"{seam}.{i}.left" for i in range(len(heights))]
    bows = [
        draw_monotone_spline(
            [(line.centre + sign * gap, y) for gap, y in [*spine, (0.0, apex + 0.1)]], [*labels, "beyond"]
        )[:-1]
        for sign in (-1.0, 1.0)
    ]
    start = upper[shoulder - 1].end
    outer, inner = cut_stroke(start, replace(upper[shoulder], notch=None), 0.5, ("shoulder.side.left", "shoulder.left"))
    top, tip = outer.end, (line.centre, apex)
    rise = (top[1] - apex) / 3
    climb = Stroke(top, ((tip[0], tip[1] + rise), (top[0], top[1] - rise)), label=f"{seam}.top.left")
    low = heights[0]
    centre_start = (line.centre - spine[0][0], low)
    middle = (*bows[0], climb, inner, *upper[shoulder + 1 :])
    back_down = reverse_strokes(Outline((line.centre + spine[0][0], low), (*bows[1], climb)))
    around = (*side[1:], *upper[:shoulder], outer, *back_down)
    corner = side[0].end
    if sewn:
        whole = unfold_closed(Outline((0.0, low), (Stroke(centre_start, label=f"waist.{face}.left"), *middle)))
        bottom = Stroke(corner, label=f"waist.{face}.side.left")
    else:
        whole = unfold(Outline(centre_start, middle), "hem")
        bottom = Stroke(corner, contour="hem")
    beside = Outline((line.centre + spine[0][0], low), (bottom, *around))
    return [(face, whole), (f"{face}_side_left", beside), (f"{face}_side_right", mirror(beside))]
