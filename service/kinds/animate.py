"""The kind `animate`: a stored result moves with its wearer."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from sqlalchemy.orm import Session

from ..jobs import Claim
from ..models import JobRow
from .animate_request import MOTION, AnimateRequest
from .dress import GARMENT_FILES, GARMENTS
from .dress_request import RESULT
from .kind import Kind, Outcome, RunContext
from .rows import add_metrics, add_pattern, describe_body, show_garment, summarise

if TYPE_CHECKING:
    from ...core.reuse.animate.animate_garment import AnimatedGarment
    from ...core.reuse.animate.settings import AnimateSettings
    from ...core.run.hooks import Hooks
    from ..settings import ServiceSettings

MOTION_CHECKER = "garmentq.service.checking:check_motion"
"""Function that reads a motion's file first, in a limited process."""


class Animate(Kind):
    """Move a stored result with its wearer."""

    name = "animate"
    request = AnimateRequest
    stages = ("check", "animate", "measure")
    reads = MappingProxyType({RESULT: GARMENTS})

    def checker(self, settings: ServiceSettings) -> str:
        """Return the reader of motions."""
        return MOTION_CHECKER

    def choose_input(self, request: AnimateRequest, name: str) -> tuple[str, ...]:
        """Return the file of the garment on its wearer, without meshes, pictures and reports."""
        return GARMENT_FILES

    def run(self, request: AnimateRequest, work: RunContext, hooks: Hooks) -> AnimatedGarment:
        """Move the garment and write the files."""
        from ...core.body.motion.read import load_motion
        from ...core.body.motion.recording import Recording
        from ...core.body.motion.shipped import find_shipped_motion
        from ...core.deliver.export.animation import add_omission_warnings, write_animation_result
        from ...core.reuse.animate.animate_garment import animate_garment
        from ...core.reuse.wear.worn import load_worn
        from ...core.run.clock import Clock
        from ...core.run.records import read_record

        worn, clock = load_worn(work.inputs[RESULT]), Clock(hooks)
        if isinstance(request.motion, str):
            path = find_shipped_motion(request.motion)
            assert path is not None
            name, recording = request.motion, load_motion(path)
        else:
            name, recording = request.motion.name, read_record(Recording, work.files / MOTION)
        moved = add_omission_warnings(animate_garment(worn, recording, name, _choose(request), clock))
        write_animation_result(moved, work.out)
        return moved

    def store(self, session: Session, claim: Claim, result: AnimatedGarment) -> Outcome:
        """Add the rows of pattern, fabric, body and metrics."""
        worn = result.animation.worn
        session.add(describe_body(claim.job, worn.body))
        add_pattern(session, claim.job, worn.pattern, worn.fabric, (worn.category, worn.template))
        add_metrics(session, claim.job, result.report.metrics)
        return Outcome(summarise(result.report))

    def show(self, session: Session, row: JobRow) -> dict[str, Any]:
        """Return garment, template, fabric and body by name."""
        return show_garment(session, row.id)


def _choose(request: AnimateRequest) -> AnimateSettings:
    from ...core.cloth.motion_step import StepSettings
    from ...core.reuse.animate.settings import AnimateSettings

    step = StepSettings() if request.damping is None else StepSettings(damping=request.damping)
    return AnimateSettings(
        fps=request.fps, begin=request.begin, end=request.end, step=step, keep_motion=request.keep_motion
    )
