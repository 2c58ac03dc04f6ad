"""Sizes of paper."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ...run.errors import keep_printable
from .errors import FormatUnknown, SheetTooSmall

PAPERS = {"a4": (210.0, 297.0), "letter": (215.9, 279.4), "a3": (297.0, 420.0), "a0": (841.0, 1189.0)}
"""Width and height [mm]."""

PLOTTER_ROLL_WIDTH_MM = 914.0
"""Usual width of a plotter's roll [mm]: 36 in."""

MIN_ROLL_WIDTH_MM, MAX_ROLL_WIDTH_MM = 200.0, 5000.0
"""Smallest and largest accepted width of a roll [mm]."""


@dataclass(frozen=True)
class Paper:
    """Describe a paper's name, width and height [mm]; a roll has height 0, and is as long as needed."""

    name: str
    width: float
    height: float

    @property
    def is_roll(self) -> bool:
        """Check whether the paper is a roll."""
        return self.height == 0.0


def find_paper(name: str) -> Paper:
    """Find a paper by name: one of `PAPERS`, `roll`, or `roll:WIDTH` in millimetres.

    Raises:
        FormatUnknown: where there is none.
        SheetTooSmall: where a roll is too narrow or too wide.
    """
    lower = name.strip().lower()
    if lower in PAPERS:
        return Paper(lower, *PAPERS[lower])
    roll = re.fullmatch(r"roll(?::(\d{1,5}(?:\.\d{1,3})?))?", lower)
    if not roll:
        known = ", ".join((*PAPERS, "roll", "roll:WIDTH in mm"))
        raise FormatUnknown(f"'{keep_printable(name[:40])}' is no paper; there are {known}.")
    width = float(roll[1]) if roll[1] else PLOTTER_ROLL_WIDTH_MM
    if not MIN_ROLL_WIDTH_MM <= width <= MAX_ROLL_WIDTH_MM:
        raise SheetTooSmall(f"a roll is {MIN_ROLL_WIDTH_MM:.0f} to {MAX_ROLL_WIDTH_MM:.0f} mm wide, not {width:g}.")
    return Paper(lower, width, 0.0)
