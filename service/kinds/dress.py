"""The kinds `dress` and `refit`: a stored result on another body, its pattern unchanged or made to measure."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from sqlalchemy.orm import Session

from ..jobs import Claim
from ..lanes import Lane
from ..models import JobRow
from .dress_request import BODY, RESULT, UNDER, DressRequest
from .kind import Kind, Outcome, RunContext
from .request import FileRef
from .rows import add_metrics, add_pattern, add_pieces, describe_body, show_garment, summarise

if TYPE_CHECKING:
    from ...core.body.body import Body
    from ...core.cloth.fabric import Fabric
    from ...core.reuse.wear.dressing import DressedGarment
    from ...core.reuse.wear.worn import WornGarment
    from ...core.run.clock import Clock
    from ...core.run.hooks import Hooks
    from ..settings import ServiceSettings


GARMENTS = ("recover", "dress", "refit", "edit")
"""Kinds of job whose result is a worn garment."""

GARMENT_FILES = ("worn.npz",)
"""File of such a result that is read: `core.reuse.wear.WORN`, named here so that it need not be imported."""

BODY_CHECKER = "garmentq.service.checking:check_body"
"""Function that reads a body's file first, in a limited process."""


class Dress(Kind):
    """Dress a body in a stored result."""

    name = "dress"
    request = DressRequest
    stages: ClassVar[tuple[str, ...]] = ("check", "body", "drape", "measure")
    lane = Lane.INTERACTIVE
    reads = MappingProxyType({RESULT: GARMENTS})
    reads_too = MappingProxyType({UNDER: GARMENTS})
    persons = "outfit"

    def checker(self, settings: ServiceSettings) -> str:
        """Return the reader of bodies."""
        return BODY_CHECKER

    def choose_input(self, request: DressRequest, name: str) -> tuple[str, ...]:
        """Return the file of the garment on its wearer, without meshes, pictures and reports."""
        return GARMENT_FILES

    def run(self, request: DressRequest, work: RunContext, hooks: Hooks) -> DressedGarment:
        """Dress the body and write the files."""
        from ...core.cloth.fabrics import get_fabric
        from ...core.deliver.export.dressed import write_dressed
        from ...core.reuse.wear.bodies import BodyFile, find_wearer
        from ...core.reuse.wear.dress_over import dress_over
        from ...core.reuse.wear.worn import load_worn
        from ...core.run.clock import Clock
        from ...core.run.records import read_record

        worn, clock = load_worn(work.inputs[RESULT]), Clock(hooks)
        body_file = read_record(BodyFile, work.files / BODY) if isinstance(request.body, FileRef) else request.body
        with clock.stage("body", "finding the body's joints") as stage_hooks:
            body = find_wearer(body_file, worn.body, request.pose, stage_hooks)
        fabric = None if request.fabric is None else get_fabric(request.fabric)
        if UNDER in work.inputs:
            dressed = dress_over(worn, load_worn(work.inputs[UNDER]), body, fabric, clock)
        else:
            dressed = self.wear(worn, body, fabric, clock)
        write_dressed(dressed, work.out)
        return dressed

    def wear(self, worn: WornGarment, body: Body, fabric: Fabric | None, clock: Clock) -> DressedGarment:
        """Return the garment on the body."""
        from ...core.reuse.wear.dressing import dress_body

        return dress_body(worn, body, fabric, clock)

    def store(self, session: Session, claim: Claim, result: DressedGarment) -> Outcome:
        """Add the rows of pattern, fabric, body and metrics."""
        return store_dressed(session, claim.job, result)

    def show(self, session: Session, row: JobRow) -> dict[str, Any]:
        """Return garment, template, fabric and body by name."""
        return show_garment(session, row.id)


class Refit(Dress):
    """Fit a stored result to the measures of a body, and dress the body."""

    name = "refit"
    stages: ClassVar[tuple[str, ...]] = ("check", "body", "refit", "drape", "measure")
    reads_too = MappingProxyType({})
    persons = ""

    def wear(self, worn: WornGarment, body: Body, fabric: Fabric | None, clock: Clock) -> DressedGarment:
        """Return the refitted garment on the body."""
        from ...core.reuse.wear.refit import make_to_measure

        return make_to_measure(worn, body, fabric, clock)


def store_dressed(session: Session, job: str, result: DressedGarment) -> Outcome:
    """Add the rows of a garment on a body, and return the outcome for the job's row."""
    worn = result.worn
    session.add(describe_body(job, worn.body))
    add_pattern(session, job, worn.pattern, worn.fabric, (worn.category, worn.template))
    add_pieces(session, job, result.pieces)
    add_metrics(session, job, result.report.metrics)
    return Outcome(summarise(result.report))
