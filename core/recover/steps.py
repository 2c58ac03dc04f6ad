"""Define the steps of a recovery, functions `(case, state, clock) -> state` that return an improved state.

A step times its stages by the clock and adds its findings to the state; `methods.py` lists each method's steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..garment.garment import Garment
from ..garment.meshes import Meshes
from ..garment.resampling import resample
from ..geometry.intersections import self_intersections
from ..run.best import choose_best
from ..run.clock import Clock
from ..run.errors import Cancelled, GarmentqError
from ..run.hooks import Hooks
from .case import Case
from .deform.deformer import deform
from .deform.settings import DeformSettings
from .drape.motion import describe_motion, drape_as_scanned, surface_rms
from .drape.pattern_easing import needs_easing
from .drape.stage import DrapeSettings, drape_template, has_hanging_sleeves, redrape
from .fit.bust_darts import add_bust_darts
from .fit.choose_start import choose_start
from .fit.descent import InverseSettings
from .fit.fairness import fair_garment
from .fit.hybrid import fit_pattern
from .fit.inverse import fit_inverse
from .fit.locks import find_locked_coordinates, fit_reference, locks_of
from .fit.rim_corners import prove_corners
from .fit.settings import ShapeSettings
from .grade.completion import complete_target
from .grade.grading import grade_pattern
from .grade.sliding import SlideSettings, slide_seams
from .settings import WAIT
from .state import RecoveryState, made

Step = Callable[[Case, RecoveryState, Clock], RecoveryState]

GRADING_ITERATIONS = 2
"""Number of times that the pattern is graded: the second starts from the mesh of the first on the target and removes
what symmetry and seams left over; a third moved no panel of the patterns tested by more than 1 mm."""


def complete(case: Case, state: RecoveryState, clock: Clock) -> RecoveryState:
    """Complete a target that ends where another garment hides it; return the state unchanged for other targets."""
    if state.target.hidden is None:
        return state
    with clock.stage("template", "completing what another garment hides") as hooks:
        worn = _dress(case, state, hooks)
        target = complete_target(worn, state.target, state.wearer.exposed, hooks)
    if target is state.target:
        return state
    shown = {contour.name for contour in case.scan_target.contours if not contour.hidden}
    guessed = [end.name for end in target.contours if end.name not in shown and not end.hidden]
    return replace(state, target=target).with_notes(
        *(f"The contour '{name}' is hidden; beyond what is seen the garment is its base pattern's." for name in guessed)
    )


def dress(case: Case, state: RecoveryState, clock: Clock) -> RecoveryState:
    """Dress the wearer in the base pattern."""
    with clock.stage("template", "dressing the body in the template") as hooks:
        return replace(state, garment=_dress(case, state, hooks))


def _dress(case: Case, state: RecoveryState, hooks: Hooks) -> Garment:
    """Return the base pattern on the wearer, eased where seams that move by small steps would hang too low."""
    is_eased = not case.has_free_curves and needs_easing(state.base, state.target.category)
    settings = DrapeSettings().eased() if is_eased else DrapeSettings()
    return drape_template(state.base, state.wearer, state.target, settings=settings, hooks=hooks)


def grade(case: Case, state: RecoveryState, clock: Clock) -> RecoveryState:
    """Grade the worn base pattern to the target, slide its seams and shape its curves to the cloth, add bust darts."""
    with clock.stage("grade", "grading the pattern to the scan") as hooks:
        worn, target, body = made(state.garment), state.target, state.body
        for _ in range(GRADING_ITERATIONS):
            grading = grade_pattern(worn, target, body, hooks=hooks)
            worn = grading.garment
        settings = SlideSettings().by_newton(case.has_free_curves) if case.has_far_seams else SlideSettings()
        slid = slide_seams(worn, target, body, state.base, settings=settings, hooks=hooks)
        state = replace(state, garment=slid).with_notes(*grading.warnings)
        if not case.has_free_curves:
            return state
        if not case.settings.keep_cut:
            state = add_bust_darts(state, worn, settings)
        slid = made(state.garment)
        return replace(
            state, garment=fair_garment(slid, state.base, find_locked_coordinates(slid.pattern, state.base, ()))
        )


def drape(case: Case, state: RecoveryState, clock: Clock) -> RecoveryState:
    """Drape the graded pattern on the wearer; in rotation where only that explains the scan."""
    slid, target = made(state.garment), state.target
    with clock.stage("drape", "draping the graded pattern") as hooks:
        settings, count = DrapeSettings(self_contact=has_hanging_sleeves(target, case.body)), case.settings.vertex_count
        garment, found = drape_as_scanned(
            slid, state.wearer, state.fabric, target, vertex_count=count, settings=settings, hooks=hooks
        )
        state = replace(state, garment=garment, graded=garment, drape=found)
        if settings.self_contact:
            state = choose_start(case, state, hooks)
        garment, found = made(state.garment), made(state.drape)
        is_laid = case.has_free_curves and not settings.self_contact
        state = replace(state, laid=resample(slid, slid.nodes, garment) if is_laid else None)
    motion = () if found.rotation is None else (describe_motion(found.rotation),)
    return state.with_notes(*motion, *(() if found.at_rest else (f"the graded drape is {found.advice}",)))


def register(case: Case, state: RecoveryState, clock: Clock) -> RecoveryState:
    """Deform the garment onto the scan, and make the curves of its pattern fair.

    **Deviation** from thesis chapter 4, which starts from the drape: unless the preset is `thesis`, a second start is
    the slid seams' nodes. They have the target's folds but cross where the target does not show them; a drape does not
    cross, but full skirts have other folds, 15 mm off. The start with fewer crossing faces after a trial is taken, of
    equal ones the one nearer to the target: on six garments without crossings both ended equally near within 0.06 mm,
    trousers with 64 and 18 crossing faces at 1.45 and 1.21 mm.
    """
    garment, graded, simulation = made(state.garment), made(state.graded), None
    starts = {"from the drape": garment}
    if state.laid is not None and case.settings.preset != "thesis":
        starts = {"from the target": garment.at(state.laid)} | starts
    settings = DeformSettings.of_preset(case.settings.preset)
    with clock.stage("deform", "deforming the garment onto the scan") as hooks:

        def judge(start: Garment) -> tuple[int, float]:
            """Return the crossing faces after a trial, and its distance from the scan [m], RMS, the worse way."""
            trial = settings.for_trial()
            tried = deform(start, state.target, state.wearer.exposed, settings=trial, hooks=hooks.quiet())
            return len(self_intersections(tried.nodes, start.faces)), surface_rms(start.at(tried.nodes), state.target)

        start = choose_best("registration", starts, judge, hooks)
        detail = deform(start, state.target, state.wearer.exposed, settings=settings, hooks=hooks)
    nodes = garment.nodes
    if state.simulated is not None:  # a fit has changed the pattern since grading
        nodes, simulation = resample(graded, graded.nodes, garment), garment.nodes
    reference = fit_reference(case, state)
    corners = prove_corners(garment, detail.nodes, case.scan_target, reference)
    locked = find_locked_coordinates(garment.pattern, reference, locks_of(case, state))
    fair = fair_garment(garment, reference, locked, corners).at(detail.nodes)
    meshes = Meshes(nodes, detail.nodes, simulation)
    return replace(state, garment=fair, meshes=meshes, corners=corners).with_notes(*detail.warnings)


@dataclass(frozen=True)
class FitShape:
    """Refit the pattern to the registered cloth, by isometry and through the simulator."""

    settings: ShapeSettings = field(default_factory=ShapeSettings)

    def __call__(self, case: Case, state: RecoveryState, clock: Clock) -> RecoveryState:
        """Return the fitted pattern; where the fit fails, the graded one with a note of the reason."""
        with clock.stage("fit", "fitting the pattern through the simulator") as hooks:
            try:
                return fit_pattern(case, state, self.settings, hooks)
            except Cancelled:
                raise
            except (GarmentqError, np.linalg.LinAlgError) as error:
                return state.with_notes(
                    f"the pattern is the graded one, for it could not be fitted through the simulator: {error}"
                )


@dataclass(frozen=True)
class Descend:
    """Descend from the graded pattern through the simulator (the thesis' loop)."""

    settings: InverseSettings = field(default_factory=InverseSettings)

    def __call__(self, case: Case, state: RecoveryState, clock: Clock) -> RecoveryState:
        """Return the state with the pattern and fabric at the end of the descent."""
        with clock.stage("fit", "descending through the simulator") as hooks:
            return fit_inverse(case, state, self.settings, hooks)


def drape_anew(case: Case, state: RecoveryState, clock: Clock) -> RecoveryState:
    """Drape a fitted pattern from its rest placement, in the graded drape's rotation if any; else change nothing."""
    meshes, garment = made(state.meshes), made(state.garment)
    if meshes.simulation is None or case.settings.redrape not in (None, WAIT):
        return state
    with clock.stage("redrape", "dressing the body in the recovered pattern") as hooks:
        rotation = made(state.drape).rotation
        draped, found = redrape(garment, state.wearer, state.fabric, state.target, rotation=rotation, hooks=hooks)
    state = replace(state, meshes=replace(meshes, redraped=draped.nodes), redrape=found)
    return state.with_notes(*(() if found.at_rest else (f"the re-draped mesh is {found.advice}",)))
