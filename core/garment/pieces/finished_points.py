"""The points at which the trade measures a finished garment, and how each is taken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np


class FinishedPoint(StrEnum):
    """List the points of the trade."""

    CHEST = "chest"
    WAIST = "waist"
    HIP = "hip"
    HEM = "hem"
    LENGTH = "length"
    SHOULDER = "shoulder"
    SLEEVE = "sleeve"
    BICEP = "bicep"
    CUFF = "cuff"
    NECK = "neck"
    RISE = "rise"
    THIGH = "thigh"
    INSEAM = "inseam"
    OUTSEAM = "outseam"


HOW_TAKEN = {
    FinishedPoint.CHEST: "around, 2.5 cm below the armhole",
    FinishedPoint.WAIST: "around the waist edge, else where it is narrowest below the chest",
    FinishedPoint.HIP: "around, 20 cm below the waist; of trousers 7.5 cm above the crotch",
    FinishedPoint.HEM: "around the lower edge; of trousers, of one leg",
    FinishedPoint.LENGTH: "back, from the side neck point straight down to the hem; of skirts from the waist",
    FinishedPoint.SHOULDER: "shoulder seam, from the neckline to the armhole",
    FinishedPoint.SLEEVE: "from the end of the shoulder seam along the sleeve to the cuff",
    FinishedPoint.BICEP: "around, 2.5 cm below the armhole, square to the sleeve",
    FinishedPoint.CUFF: "around the edge of a sleeve",
    FinishedPoint.NECK: "around the neckline, with a collar along its seam",
    FinishedPoint.RISE: "front, along the crotch seam from the waist edge to the inseam",
    FinishedPoint.THIGH: "around one leg, 2.5 cm below the crotch",
    FinishedPoint.INSEAM: "inseam, from the crotch to the hem",
    FinishedPoint.OUTSEAM: "side seam, from the waist edge to the hem",
}
"""How each point is taken, flat and sewn, without seam allowance."""

Line = tuple[str, np.ndarray]
"""Name of a panel, and a polyline in its flat coordinates [m], shape [n, 2]."""

Measured = tuple[float, tuple[Line, ...]]
"""A length [m], and where it was measured."""


@dataclass(frozen=True)
class FinishedMeasure:
    """Describe a measure of the finished garment.

    Attributes:
        point: Where it is taken.
        value: Its length, of a girth the whole way round [m].
        lines: Where it is taken: names of panels with polylines in their flat coordinates [m], shape [n, 2] each.
    """

    point: FinishedPoint
    value: float
    lines: tuple[Line, ...]

    @property
    def how(self) -> str:
        """Return how it is taken."""
        return HOW_TAKEN[self.point]


MEASURES_PER_LINE = 4
"""Number of finished measures on one line of a title."""


def list_finished(measures: Sequence[FinishedMeasure]) -> list[str]:
    """Return the lines of a title with finished measures: `finished [cm]: chest 102.0, waist 102.0`."""
    texts = [f"{one.point} {100.0 * one.value:.1f}" for one in measures]
    rows = [texts[i : i + MEASURES_PER_LINE] for i in range(0, len(texts), MEASURES_PER_LINE)]
    return [f"{'finished [cm]: ' if not number else ''}{', '.join(row)}" for number, row in enumerate(rows)]
