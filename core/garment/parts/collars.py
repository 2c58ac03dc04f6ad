"""Draft collars: a stand of even width around a crew neck. A band collar is a straight strip as long as the neckline
(W. Aldrich, Metric Pattern Cutting for Women's Wear, standing straight collar); it is cut in halves, sewn above the
shoulder seams."""

from __future__ import annotations

from dataclasses import replace

from ..outline import Outline, Point, Stroke, labelled_length, place_panel, unfold_closed
from ..pattern import Panel
from .cut import Cut, Neckline, PartsConflict, SleeveHead
from .fronts import cut_front

COLLAR_STAND_WIDTH = 0.035
"""Width of a collar stand [m]: it fits below the jaw."""


def sew_collar(cut: Cut, face: str, neckline: tuple[Stroke, ...]) -> tuple[Stroke, ...]:
    """Return half a neckline as an edge that a stand is sewn to.

    Raises:
        PartsConflict: where the neckline is no crew neck, since a strip fits neither a corner nor a line far from the
            neck; or where raglan sleeves end in it.
    """
    if (cut.neckline, cut.back_neckline) != (Neckline.CREW, Neckline.CREW):
        raise PartsConflict("a collar stand is drafted on a crew neck; choose neckline=crew and back_neckline=crew.")
    if cut.sleeve_head is SleeveHead.RAGLAN:
        raise PartsConflict("a collar stand is drafted on a neckline in two halves; choose another sleeve_head.")
    return tuple(replace(stroke, label=f"collar.{face}.left", contour="") for stroke in neckline)


def collar_stand(
    cut: Cut, neck: Point, necklines: tuple[tuple[Stroke, ...], tuple[Stroke, ...]], height: float
) -> list[Panel]:
    """Draw front and back of a stand.

    Args:
        cut: The garment's.
        neck: The side neck point [m].
        necklines: From there to the middle, in front and behind.
        height: Of the draft's origin [m].
    """
    panels = []
    for face, line in zip(("front", "back"), necklines, strict=True):
        half = labelled_length(Outline(neck, line), "collar")
        y = neck[1]
        strokes = (
            Stroke((half, y), label=f"collar.{face}.left"),
            Stroke((half, y + COLLAR_STAND_WIDTH), label="collarside.left"),
            Stroke((0.0, y + COLLAR_STAND_WIDTH), contour="neck"),
        )
        outline, name = unfold_closed(Outline((0.0, y), strokes)), f"collar_{face}"
        pieces = cut_front(cut, name, outline) if face == "front" else [(name, outline)]
        panels += [place_panel(part, drawn, height, label="collar") for part, drawn in pieces]
    return panels
