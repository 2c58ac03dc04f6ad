"""Choose what a recovery starts from where its graded drape crosses itself: that, or the pattern dressed from flat."""

from __future__ import annotations

from ...cloth import Drape
from ...garment import Garment
from ...geometry import self_intersections
from ...run.hooks import Hooks
from ...scan.contours import name_contours
from ..case import Case
from ..deform import DeformSettings, deform
from ..drape import redrape
from ..drape.motion import miss

CLEAR = 0.8
"""Share of the other's distance from the scan that the drape from flat has at most, both deformed onto it: it was 0.3
and 0.7 where a sleeve hung crumpled in front of its arm, and 0.95 where five faces crossed in an armpit."""


def uncross(case: Case, garment: Garment, drape: Drape, hooks: Hooks) -> tuple[Garment, Drape]:
    """Return a graded drape, or where it crosses itself the pattern dressed from flat if that comes nearer to the scan.

    A scan in which a sleeve has grown together with the trunk gives a start in which the two lie in each other, and on
    the way out of that a sleeve can end beside its arm. Dressed from flat it is on the arm, if in other folds than the
    scan's. Which is nearer shows when both are deformed onto the scan.

    Args:
        case: The garment to recover.
        garment: The graded pattern as it was draped from the scan, kept apart from itself.
        drape: The equilibrium of that.
        hooks: Progress and cancellation.
    """
    if not len(self_intersections(garment.nodes, garment.faces)):
        return garment, drape
    nodes, again = redrape(garment, case.wearer, case.fabric, case.target, rotation=drape.rotation, hooks=hooks)
    flat = garment.at(nodes, name_contours(nodes, garment.faces, case.body)[0])
    first, second = (_distance(case, one, hooks) for one in (garment, flat))
    return (flat, again) if second < CLEAR * first else (garment, drape)


def _distance(case: Case, garment: Garment, hooks: Hooks) -> float:
    """Return how far a drape is from the scan when it is deformed onto it [m], RMS, the worse way."""
    settings = DeformSettings.of_preset(case.settings.preset)
    detail = deform(garment, case.target, case.wearer.exposed, settings=settings, hooks=hooks)
    return miss(garment.at(detail.nodes), case.target)
