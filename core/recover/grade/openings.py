"""Name the openings of a garment beside its contours: an open or closed front, a placket, vents."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from ...garment.parts.cut import Cut, Front, PartsConflict, Vent
from ...garment.parts.vents import check_vent
from ...run.finding import Finding, FindingKind
from ...scan.contours.slits import Slit, SlitName
from ...scan.contours.target import Target
from .neck_finish import NeckFinish
from .neck_shape import NeckShape


class FrontOpening(StrEnum):
    """Describe how a front opens: down to the hem and worn open or closed, or from the neck by a placket."""

    OPEN = "front.open"
    CLOSED = "front.closed"
    PLACKET = "placket"


FRONT_OPENINGS = {
    Front.OPEN: FrontOpening.OPEN,
    Front.ZIP: FrontOpening.CLOSED,
    Front.BUTTONS: FrontOpening.CLOSED,
    Front.PLACKET: FrontOpening.PLACKET,
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
    target: Target, shape: NeckShape | None, finishes: Sequence[NeckFinish], slits: Sequence[Slit]
) -> tuple[Opening, ...]:
    """Find the openings of a scan, its front's first, the likeliest before others.

    Args:
        target: The scan.
        shape: Of its neck; None where it has none.
        finishes: What may be sewn to it, with their misfits.
        slits: In its contours.
    """
    weights: dict[FrontOpening, float] = {}
    shares = np.exp([-0.5 * one.misfit**2 for one in finishes])
    for one, share in zip(finishes, shares / max(shares.sum(), 1e-12), strict=True):
        name = FRONT_OPENINGS.get(one.front)
        if name is not None:
            weights[name] = weights.get(name, 0.0) + float(share)
    found = [
        Opening(name, _measure_front(target, shape, name), probability)
        for name, probability in sorted(weights.items(), key=lambda pair: -pair[1])
    ]
    return (*found, *(Opening(one.name, one.extent) for one in slits if one.name is not SlitName.PLACKET))


def _measure_front(target: Target, shape: NeckShape | None, name: FrontOpening) -> float | None:
    """Return the length of the opening of a front [m]; None where the scan does not show it."""
    if name is FrontOpening.PLACKET:
        return None if shape is None or shape.slit == 0.0 else shape.slit
    edges = [contour.length for contour in target.contours if contour.name.startswith("front.")]
    return float(np.mean(edges)) if edges and name is FrontOpening.OPEN else None


def open_vents(cut: Cut, slits: Sequence[Slit], fixed: bool) -> Cut:
    """Return a cut with the vents that a scan shows, at both sides or at the back, where it can have them.

    Args:
        cut: The cut.
        slits: In the scan's contours.
        fixed: Whether the user chose its vents.
    """
    names = {one.name for one in slits}
    vent = Vent.BACK if SlitName.BACK_VENT in names else Vent.NONE
    if {SlitName.LEFT_VENT, SlitName.RIGHT_VENT} <= names:
        vent = Vent.SIDES
    if fixed or vent is Vent.NONE or not cut.has_place_for("vent"):
        return cut
    vented = replace(cut, vent=vent)
    try:
        check_vent(vented)
    except PartsConflict:
        return cut
    return vented
