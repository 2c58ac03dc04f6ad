"""Draft collars: strips of even width around a crew neck. A band collar is a straight strip as long as the neckline
(W. Aldrich, Metric Pattern Cutting for Women's Wear, standing straight collar); a neck rib and a turtleneck are knitted
strips, shorter than it as other ribs (H. Joseph-Armstrong, Patternmaking for Fashion Design, knits). Each is cut in
halves, sewn above the shoulder seams."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..outline import Outline, Point, Stroke, labelled_length, place_panel, unfold_closed
from ..pattern import Panel
from .cut import Collar, Cut, Neckline, PartsConflict, SleeveHead
from .fronts import cut_front
from .ribs import RIB_RATIO

COLLAR_STAND_WIDTH = 0.035
"""Width of a collar stand [m]: it fits below the jaw."""

NECK_RIB_WIDTH = 0.02
"""Width of the rib of a T-shirt's or sweatshirt's neck, as worn [m]."""

TURTLENECK_WIDTH = 0.09
"""Height of a turtleneck as worn [m]: once up the neck, folded down on itself. It is cut twice as high."""


@dataclass(frozen=True)
class StripCollar:
    """Describe a collar that is a straight strip: the word of its panels, its width [m], and the ratio of its length to
    the neckline's."""

    name: str
    width: float
    ratio: float = 1.0


STRIP_COLLARS = {
    Collar.STAND: StripCollar("collar", COLLAR_STAND_WIDTH),
    Collar.RIB: StripCollar("collar_rib", NECK_RIB_WIDTH, RIB_RATIO),
    Collar.TURTLENECK: StripCollar("turtleneck", TURTLENECK_WIDTH, RIB_RATIO),
}
"""Collars that are straight strips."""


def sew_collar(cut: Cut, face: str, neckline: tuple[Stroke, ...]) -> tuple[Stroke, ...]:
    """Return half a neckline as an edge that a strip is sewn to.

    Raises:
        PartsConflict: where the neckline is no crew neck, since a strip fits neither a corner nor a line far from the
            neck; or where raglan sleeves end in it.
    """
    if (cut.neckline, cut.back_neckline) != (Neckline.CREW, Neckline.CREW):
        raise PartsConflict(
            f"collar={cut.collar} is drafted on a crew neck; choose neckline=crew and back_neckline=crew."
        )
    if cut.sleeve_head is SleeveHead.RAGLAN:
        raise PartsConflict(f"collar={cut.collar} is drafted on a neckline in two halves; choose another sleeve_head.")
    return tuple(replace(stroke, label=f"collar.{face}.left", contour="") for stroke in neckline)


def strip_collar(
    cut: Cut, neck: Point, necklines: tuple[tuple[Stroke, ...], tuple[Stroke, ...]], height: float
) -> list[Panel]:
    """Draw front and back of a collar that is a straight strip.

    Args:
        cut: The garment's; its collar is one of `STRIP_COLLARS`.
        neck: The side neck point [m].
        necklines: From there to the middle, in front and behind.
        height: Of the draft's origin [m].
    """
    strip = STRIP_COLLARS[cut.collar]
    panels = []
    for face, line in zip(("front", "back"), necklines, strict=True):
        half = strip.ratio * labelled_length(Outline(neck, line), "collar")
        y = neck[1]
        strokes = (
            Stroke((half, y), label=f"collar.{face}.left"),
            Stroke((half, y + strip.width), label="collarside.left"),
            Stroke((0.0, y + strip.width), contour="neck"),
        )
        outline, name = unfold_closed(Outline((0.0, y), strokes)), f"{strip.name}_{face}"
        pieces = cut_front(cut, name, outline) if face == "front" else [(name, outline)]
        panels += [place_panel(part, drawn, height, label="collar") for part, drawn in pieces]
    return panels
