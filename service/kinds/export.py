"""The kind `export`: a stored result as files for production."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from sqlalchemy.orm import Session

from ..jobs import Claim
from ..lanes import Lane
from ..models import JobRow
from .dress import GARMENTS
from .dress_request import RESULT
from .export_request import ExportRequest, add_day, add_scan
from .kind import Kind, Outcome, RunContext
from .rows import add_metrics, add_pieces, summarise

if TYPE_CHECKING:
    from ...core.garment.pieces.piece import PieceSet
    from ...core.run.hooks import Hooks
    from ...core.run.report import ResultReport


@dataclass(frozen=True)
class ExportResult:
    """Describe the pieces that were written, and the report with its cost."""

    pieces: PieceSet
    report: ResultReport


class Export(Kind):
    """Write a stored result in a production format."""

    name = "export"
    request = ExportRequest
    stages = ("check", "write")
    lane = Lane.INTERACTIVE
    reads = MappingProxyType({RESULT: GARMENTS})

    def adopt(self, session: Session, request: dict[str, Any], row: JobRow) -> dict[str, Any]:
        """Return the request with the result's day, and its scan if the format uses its colours."""
        return add_day(add_scan(session, request, row), row)

    def run(self, request: ExportRequest, work: RunContext, hooks: Hooks) -> ExportResult:
        """Write the files."""
        from ...core.deliver.formats.production import Production, write_production
        from ...core.reuse.wear.worn import load_worn
        from ...core.run.clock import Clock
        from ...core.run.report import ResultReport

        clock = Clock(hooks)
        with clock.stage("write", f"writing {request.format}") as stage_hooks:
            scan = None if request.scan is None else work.files / "scan" / request.scan.name
            worn, made = load_worn(work.inputs[RESULT]), request.made or ""
            production = Production(worn, request, work.inputs[RESULT], scan, stage_hooks, made)
            write_production(production, work.out)
            pieces = production.pieces
        return ExportResult(pieces, ResultReport.of(clock, {}, (), pieces.missing, {}))

    def store(self, session: Session, claim: Claim, result: ExportResult) -> Outcome:
        """Add the rows of the pieces and their metrics."""
        from ...core.garment.pieces.numbers import describe_pieces

        measured, lay = describe_pieces(result.pieces)
        add_pieces(session, claim.job, measured)
        add_metrics(session, claim.job, lay)
        return Outcome(summarise(result.report))

    def show(self, session: Session, row: JobRow) -> dict[str, Any]:
        """Return None for all names: the garment is that of its input."""
        return {"garment": None, "template": None, "fabric": None, "body": None}
