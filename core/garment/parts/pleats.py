"""Draft a pleated skirt on a hip yoke. Unpressed pleats (H. Joseph-Armstrong, Patternmaking for Fashion Design, pleats;
W. Aldrich, Metric Pattern Cutting for Women's Wear, pleated skirts): the cloth is folded between two marks that are
sewn onto each other at the upper edge, and hangs free below. Each pleat adds twice its depth to the visible width."""

from __future__ import annotations

from ..outline import Outline, Stroke, place_panel, unfold
from ..pattern import Panel

QUARTER_PLEAT_COUNT = 3
"""Number of pleats per quarter of the skirt: 7 to 8 cm of cloth are visible between two at the hip bones."""

PLEAT_DEPTH = 0.03
"""Depth of a pleat [m]: twice the depth is folded away, less than the visible 7 cm, so that folds do not overlap."""

PLEATED_PART_LENGTH = 0.45
"""Length of the pleated part [m]: that of a gathered skirt below its yoke."""

HIP_YOKE_SEAM = "hipyoke"
"""Label of the seam between yoke and pleats."""


def shown_widths(quarter: float) -> tuple[float, ...]:
    """Return the visible widths, from the middle to the side [m]: half of one at both ends.

    Args:
        quarter: Length of a quarter of the yoke's lower edge [m].
    """
    whole = quarter / QUARTER_PLEAT_COUNT
    return (whole / 2, *([whole] * (QUARTER_PLEAT_COUNT - 1)), whole / 2)


def yoke_strokes(face: str, quarter: float, height: float) -> tuple[Stroke, ...]:
    """Draw half of the lower edge of a yoke from the middle to the side, divided where pleats meet it.

    Args:
        face: `front` or `back`.
        quarter: Its length [m].
        height: In the draft's axes [m].
    """
    strokes, at = [], 0.0
    for number, width in enumerate(shown_widths(quarter)):
        at += width
        strokes.append(Stroke((at, height), label=f"{HIP_YOKE_SEAM}.{face}.{number}.left"))
    return tuple(strokes)


def draw_pleats(quarter: float, height: float) -> list[Panel]:
    """Draw front and back of the pleated part.

    Args:
        quarter: Length of a quarter of the yoke's lower edge [m].
        height: Of that edge above the feet [m].
    """
    panels = []
    for face in ("front", "back"):
        wide = quarter + 2 * PLEAT_DEPTH * QUARTER_PLEAT_COUNT
        strokes, at = [Stroke((wide, 0.0), label="side.left")], wide
        widths = shown_widths(quarter)
        for number in range(QUARTER_PLEAT_COUNT, -1, -1):
            at -= widths[number]
            end = 0.0 if number == 0 else at
            strokes.append(Stroke((end, 0.0), label=f"{HIP_YOKE_SEAM}.{face}.{number}.left"))
            for _ in range(2 if number else 0):
                at -= PLEAT_DEPTH
                strokes.append(Stroke((at, 0.0), label=f"pleat.{face}.{number}.left"))
        panels.append(place_panel(face, unfold(Outline((wide, -PLEATED_PART_LENGTH), tuple(strokes)), "hem"), height))
    return panels
