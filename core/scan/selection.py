"""Which part of a clothed scan is the garment, as it is asked for."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from . import refusal

GARMENT_COLOUR_TOLERANCE = 60.0
"""Distance of colours [RGB, 0 to 255] up to which a colour is the garment's: camera noise of 9 a channel stays within
35, skin is 150 from denim. Strong shadows need more."""


@dataclass(frozen=True)
class Selection:
    """Describe which part of a clothed scan is the garment.

    Attributes:
        labels: A file with one label per vertex of the scan, or None for the labels in the scan itself.
        key: The array's name in that file, or None to find it.
        keep: The garment's labels as texts; empty where the labels are 0 and 1, of which 1 is kept.
        colour: The garment's colour as `#rrggbb` instead of labels, or None.
        tolerance: Distance in RGB (0 to 255) up to which a colour is the garment's.
        cloth: Labels of other clothes that the person wears, as texts.
    """

    labels: Path | None = None
    key: str | None = None
    keep: tuple[str, ...] = ()
    colour: str | None = None
    tolerance: float = GARMENT_COLOUR_TOLERANCE
    cloth: tuple[str, ...] = ()


def parse_colour(text: str) -> tuple[int, int, int]:
    """Read `#rrggbb` as three bytes.

    Raises:
        ColourBad: where it is not of that form.
    """
    if not re.fullmatch(r"#?[0-9A-Fa-f]{6}", text):
        raise refusal.ColourBad(f"'{text[:40]}' is no colour; write it as '#465faa'.")
    red, green, blue = (int(text.lstrip("#")[i : i + 2], 16) for i in (0, 2, 4))
    return red, green, blue
