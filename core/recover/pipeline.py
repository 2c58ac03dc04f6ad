"""Run a recovery from its files to the measured result."""

from __future__ import annotations

from dataclasses import replace

from ..run.checkpoints import load, save
from ..run.clock import Clock
from ..run.hooks import SILENT_HOOKS, Hooks
from ..run.report import Metrics
from .case import Case
from .delivery import deliver
from .methods import METHODS, STEP_CHECKPOINTS
from .recovery import Recovery, Request
from .start import choose_base, read_case
from .state import RecoveryState
from .steps import Step, drape_anew


def recover(request: Request, hooks: Hooks = SILENT_HOOKS) -> Recovery:
    """Recover pattern, fabric and meshes of one scanned garment.

    Args:
        request: The files and settings.
        hooks: Progress, cancellation and checkpoints.

    Raises:
        BadInput: where a file or a setting cannot be used; the code says why.
        Cancelled: as soon as the hooks say so.
    """
    clock = Clock(hooks)
    case = read_case(request, clock)
    state = choose_base(case)
    case = replace(case, scan_target=state.target)  # the base pattern says whether its collar covers the scan's neck
    state = run_steps(METHODS[request.settings.method], case, state, clock)
    return deliver(case, state, clock)


def finish(case: Case, state: RecoveryState, known: Metrics, hooks: Hooks = SILENT_HOOKS) -> Recovery:
    """Return an `UnfinishedRecovery`, of which case, state and metrics are given, as if it had waited for its re-drape.

    A run that was interrupted after the drape resumes there.
    """
    clock, inputs = Clock(hooks), (state.base.points, case.settings.vertex_count)
    case = replace(case, request=replace(case.request, settings=replace(case.settings, redrape=None)))
    state = load(hooks, "redrape", RecoveryState, *inputs) or run_steps((drape_anew,), case, state, clock)
    save(hooks, "redrape", state, *inputs)
    return deliver(case, state, clock, known)


def run_steps(steps: tuple[Step, ...], case: Case, state: RecoveryState, clock: Clock) -> RecoveryState:
    """Run the steps in order, after the last one whose state an earlier run of the job saved."""
    first, inputs = 0, (state.base.points, case.settings.vertex_count)
    for number, step in enumerate(steps):
        kept = load(clock.hooks, STEP_CHECKPOINTS[step], RecoveryState, *inputs) if step in STEP_CHECKPOINTS else None
        if kept is not None:
            first, state = number + 1, kept
    for step in steps[first:]:
        state = step(case, state, clock)
        state = state.with_findings(*clock.take_findings())
        if step in STEP_CHECKPOINTS:
            save(clock.hooks, STEP_CHECKPOINTS[step], state, *inputs)
    return state
