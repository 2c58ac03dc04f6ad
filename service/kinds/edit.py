"""The kind `edit`: a stored result with an edited pattern, draped from where its garment hangs; a new version of it."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from sqlalchemy.orm import Session

from ..jobs import Claim
from ..lanes import Lane
from ..models import JobInputRow, JobRow
from ..patterns import refuse_unsound
from .dress import GARMENT_FILES, GARMENTS
from .dress_request import RESULT
from .edit_request import PATTERN, EditRequest, add_recovered
from .kind import Kind, Outcome, RunContext
from .rows import add_metrics, add_pattern, describe_body, show_garment, summarise

if TYPE_CHECKING:
    from ...core.reuse.edit.redraping import EditedGarment
    from ...core.run.hooks import Hooks
    from ...core.run.sandbox import IsStopped
    from ..settings import ServiceSettings
    from ..store import Store

PATTERN_CHECKER = "garmentq.service.checking:check_edit"
"""Function that reads a pattern's file first, in a limited process."""


class Edit(Kind):
    """Drape an edited pattern on the wearer of a stored result."""

    name = "edit"
    request = EditRequest
    stages: ClassVar[tuple[str, ...]] = ("check", "drape", "measure")
    lane = Lane.INTERACTIVE
    reads = MappingProxyType({RESULT: GARMENTS})

    def checker(self, settings: ServiceSettings) -> str:
        """Return the reader of patterns."""
        return PATTERN_CHECKER

    def refuse(self, store: Store, request: EditRequest, is_stopped: IsStopped) -> None:
        """Refuse a pattern that cannot be sewn or meshed when it is submitted, with the place of the fault."""
        refuse_unsound(store, request.pattern.sha256, is_stopped)

    def adopt(self, session: Session, request: dict[str, Any], row: JobRow) -> dict[str, Any]:
        """Return the request with the recovered pattern."""
        return add_recovered(session, request, row)

    def choose_input(self, request: EditRequest, name: str) -> tuple[str, ...]:
        """Return the file of the garment on its wearer, without meshes, pictures and reports."""
        return GARMENT_FILES

    def run(self, request: EditRequest, work: RunContext, hooks: Hooks) -> EditedGarment:
        """Drape the pattern and write the files."""
        from ...core.deliver.export.edited import write_edited
        from ...core.garment.garmentcode import load_pattern
        from ...core.garment.reading import load_given_pattern
        from ...core.reuse.edit.redraping import drape_edit
        from ...core.reuse.wear.worn import load_worn
        from ...core.run.clock import Clock

        worn, clock = load_worn(work.inputs[RESULT]), Clock(hooks)
        pattern = load_given_pattern(work.files / PATTERN)
        file = request.recovered
        recovered = worn.pattern if file is None else load_pattern(work.files / "recovered" / file.name)
        edited = drape_edit(worn, pattern, recovered, clock)
        write_edited(edited, work.out)
        return edited

    def store(self, session: Session, claim: Claim, result: EditedGarment) -> Outcome:
        """Add the rows of pattern, fabric, body and metrics."""
        worn = result.worn
        session.add(describe_body(claim.job, worn.body))
        add_pattern(session, claim.job, worn.pattern, worn.fabric, (worn.category, worn.template))
        add_metrics(session, claim.job, result.report.metrics)
        return Outcome(summarise(result.report))

    def show(self, session: Session, row: JobRow) -> dict[str, Any]:
        """Return garment, template, fabric and body by name, and the job of the previous version."""
        read = session.get(JobInputRow, (row.id, RESULT))
        return show_garment(session, row.id) | {"predecessor": read.input if read else None}
