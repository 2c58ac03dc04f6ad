"""Register a garment a second time, with the pattern that was fitted to its first registration."""

from __future__ import annotations

from ...garment.garment import Garment
from ...garment.resampling import resample
from ...run.best import choose_best
from ...run.hooks import Hooks
from ..case import Case
from ..deform.deformer import deform
from ..deform.settings import DeformSettings
from ..drape.motion import surface_rms
from ..state import RecoveryState

MAX_SECOND_DISTANCE_RATIO = 1.1
"""Largest ratio of the second registration's distance to the first's at which the second is taken. Of four garments two
had 1.0, trousers 1.2, shorts 1.7; from the first registration shorts had 1.0, trousers 1.8."""


def register_again(start: Garment, case: Case, state: RecoveryState, hooks: Hooks) -> Garment:
    """Return a garment already on the scan, registered again; its contours are named."""
    settings = DeformSettings.of_preset(case.settings.preset).for_folds()
    return start.at(deform(start, state.target, state.wearer.exposed, settings=settings, hooks=hooks.quiet()).nodes)


def choose_nearer_registration(
    first: Garment, second: Garment, case: Case, state: RecoveryState, hooks: Hooks
) -> Garment:
    """Return the second registration, or its mesh registered from the first where that is nearer to the scan.

    Args:
        first: The first registration.
        second: A mesh of a pattern of the same panels, registered from where the pattern was fitted.
        case: The scan.
        state: The target, and the wearer as an obstacle.
        hooks: Cancellation.
    """
    if surface_rms(second, state.target) <= MAX_SECOND_DISTANCE_RATIO * surface_rms(first, state.target):
        return second
    other = register_again(second.at(resample(first, first.nodes, second)), case, state, hooks)
    starts = {"from the fitted pattern": second, "from the first": other}
    return choose_best("second registration", starts, lambda one: surface_rms(one, state.target), hooks)
