"""Choose the start of a recovery whose graded drape crosses itself: that drape, or the pattern dressed from flat."""

from __future__ import annotations

from dataclasses import replace

from ...garment.garment import Garment
from ...geometry.intersections import self_intersections
from ...run.best import choose_best
from ...run.hooks import Hooks
from ..case import Case
from ..deform.deformer import deform
from ..deform.settings import DeformSettings
from ..drape.motion import surface_rms
from ..drape.stage import redrape
from ..state import RecoveryState, made

MAX_FLAT_START_SHARE = 0.8
"""Largest ratio of distances from the scan, after deformation, at which the drape from flat replaces the graded one:
0.3 and 0.7 where a sleeve hung crumpled in front of its arm, 0.95 where five faces crossed in an armpit."""


def choose_start(case: Case, state: RecoveryState, hooks: Hooks) -> RecoveryState:
    """Keep a graded drape; where it crosses itself take the pattern dressed from flat if that is nearer to the scan.

    In a scan with a sleeve merged with the trunk the two start inside each other, and on the way out a sleeve can end
    beside its arm. Dressed from flat it is on the arm, though in other folds. Both are compared after deformation.

    Args:
        case: The garment to recover.
        state: The graded pattern draped from the scan with self-contact, and its equilibrium.
        hooks: Progress and cancellation.
    """
    garment, drape, target = made(state.graded), made(state.drape), state.target
    if not len(self_intersections(garment.nodes, garment.faces)):
        return state
    flat, again = redrape(garment, state.wearer, state.fabric, target, rotation=drape.rotation, hooks=hooks)
    settings = DeformSettings.of_preset(case.settings.preset)

    def reach(start: Garment) -> float:
        """Return the distance of a start from the scan after its deformation [m], RMS, the worse way."""
        detail = deform(start, target, state.wearer.exposed, settings=settings, hooks=hooks)
        distance = surface_rms(start.at(detail.nodes), target)
        return MAX_FLAT_START_SHARE * distance if start is garment else distance

    taken = choose_best("start of the deformation", {"graded drape": garment, "dressed from flat": flat}, reach, hooks)
    return replace(state, garment=taken, graded=taken, drape=drape if taken is garment else again)
