"""Name the openings of a garment beside its contours: an open, closed or wrapped front, a placket, vents, cuffs."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from ...garment.parts.cut import Cuff, Cut, Front, PartsConflict, Vent
from ...garment.parts.draft import draft_cut
from ...run.finding import Finding, FindingKind
from ...scan.contours.slits import Slit, SlitName
from ...scan.contours.target import Target
from .lap import Lap
from .neck_finish import NeckFinish
from .neck_shape import NeckShape


class FrontOpening(StrEnum):
    """Describe how a front opens: down to the hem and worn open or closed, from the neck by a placket, or as one front
    that is wrapped over the other."""

    OPEN = "front.open"
    CLOSED = "front.closed"
    PLACKET = "placket"
    WRAP = "wrap"


FRONT_OPENINGS = {
    Front.OPEN: FrontOpening.OPEN,
    Front.ZIP: FrontOpening.CLOSED,
    Front.BUTTONS: FrontOpening.CLOSED,
    Front.PLACKET: FrontOpening.PLACKET,
    Front.WRAP: FrontOpening.WRAP,
}
"""The opening of each front that a scan can show."""


@dataclass(frozen=True)
class Opening:
    """Describe an opening.

    Attributes:
        name: A `FrontOpening` or a `SlitName`.
        extent: Its length [m]; None where the scan does not show it.
        probability: That it is there; None of a slit that the scan shows, which may also be torn.
    """

    name: str
    extent: float | None = None
    probability: float | None = None

    def describe(self) -> Finding:
        """Return the opening as a finding."""
        evidence: dict[str, str | float] = {"name": str(self.name)}
        if self.extent is not None:
            evidence["extent_mm"] = round(1e3 * self.extent, 1)
        if self.probability is not None:
            evidence["probability"] = round(self.probability, 3)
        return Finding(FindingKind.OPENING, evidence=evidence)


def find_openings(
    target: Target,
    shape: NeckShape | None,
    finishes: Sequence[NeckFinish],
    slits: Sequence[Slit],
    lap: Lap | None = None,
) -> tuple[Opening, ...]:
    """Find the openings of a scan, its front's first, the likeliest before others.

    Args:
        target: The scan.
        shape: Of its neck; None where it has none.
        finishes: What may be sewn to it, with their misfits.
        slits: In its contours.
        lap: Of its front; None where nothing tells of one.
    """
    weights: dict[FrontOpening, float] = {}
    shares = np.exp([-0.5 * one.misfit**2 for one in finishes])
    for one, share in zip(finishes, shares / max(shares.sum(), 1e-12), strict=True):
        name = FRONT_OPENINGS.get(one.front)
        if name is FrontOpening.WRAP:
            weights[name] = one.probability
        elif name is not None:
            weights[name] = weights.get(name, 0.0) + float(share)
    found = [
        Opening(name, _measure_front(target, shape, name, lap), probability)
        for name, probability in sorted(weights.items(), key=lambda pair: -pair[1])
    ]
    return (*found, *(Opening(one.name, one.extent) for one in slits if one.name is not SlitName.PLACKET))


def _measure_front(target: Target, shape: NeckShape | None, name: FrontOpening, lap: Lap | None) -> float | None:
    """Return the length of the opening of a front [m]; None where the scan does not show it."""
    if name is FrontOpening.WRAP:
        return None if lap is None else lap.extent
    if name is FrontOpening.PLACKET:
        return None if shape is None or shape.slit == 0.0 else shape.slit
    edges = [contour.length for contour in target.contours if contour.name.startswith("front.")]
    return float(np.mean(edges)) if edges and name is FrontOpening.OPEN else None


def open_slits(cut: Cut, slits: Sequence[Slit], fixed: Collection[str]) -> Cut:
    """Return a cut with the vents that a scan shows, at both sides or at the back, and with shirt cuffs where it shows
    slits above both cuffs, where the cut can have them.

    Args:
        cut: The cut.
        slits: In the scan's contours.
        fixed: Parts that the user chose.
    """
    names = {one.name for one in slits}
    vent = Vent.BACK if SlitName.BACK_VENT in names else Vent.NONE
    if {SlitName.LEFT_VENT, SlitName.RIGHT_VENT} <= names:
        vent = Vent.SIDES
    if "vent" not in fixed and vent is not Vent.NONE and cut.has_place_for("vent"):
        cut = _change_where_drafted(cut, replace(cut, vent=vent))
    if "cuff" not in fixed and {SlitName.LEFT_CUFF, SlitName.RIGHT_CUFF} <= names and cut.cuff is Cuff.NONE:
        cut = _change_where_drafted(cut, replace(cut, cuff=Cuff.SHIRT))
    return cut


def _change_where_drafted(cut: Cut, changed: Cut) -> Cut:
    """Return the changed cut, or the cut where its parts cannot be sewn to each other."""
    try:
        draft_cut(changed)
    except PartsConflict:
        return cut
    return changed
