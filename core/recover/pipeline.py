"""Run a recovery from its files to the measured result."""

from __future__ import annotations

from collections.abc import Mapping
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
    state = run_steps(METHODS[request.settings.method], case, state, clock)
    return deliver(case, state, clock)


def finish(case: Case, state: RecoveryState, known: Metrics, hooks: Hooks = SILENT_HOOKS) -> Recovery:
    """Return a recovery with its re-drape, the same as if it had waited for it.

    Args:
        case: The inputs, and
        state: the state: `unfinished` of the recovery without the re-drape.
        known: Its metrics.
        hooks: Progress, cancellation and checkpoints.
    """
    clock = Clock(hooks)
    case = replace(case, request=replace(case.request, settings=replace(case.settings, redrape=None)))
    state = run_steps((drape_anew,), case, state, clock, {drape_anew: "redrape"})
    return deliver(case, state, clock, known)


def run_steps(
    steps: tuple[Step, ...],
    case: Case,
    state: RecoveryState,
    clock: Clock,
    checkpoints: Mapping[Step, str] = STEP_CHECKPOINTS,
) -> RecoveryState:
    """Run the steps in order, after the last one whose state an earlier run of the job saved."""
    first, inputs = 0, (state.base.points, case.settings.vertex_count)
    for number, step in enumerate(steps):
        kept = load(clock.hooks, checkpoints[step], RecoveryState, *inputs) if step in checkpoints else None
        if kept is not None:
            first, state = number + 1, kept
    for step in steps[first:]:
        state = step(case, state, clock)
        state = state.with_findings(*clock.take_findings())
        if step in checkpoints:
            save(clock.hooks, checkpoints[step], state, *inputs)
    return state
