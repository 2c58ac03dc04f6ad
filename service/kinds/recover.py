"""The kind `recover`: a garment's scan becomes a pattern, a fabric and meshes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy.orm import Session

from ...core.recover.recovery import STAGES
from ..jobs import Claim
from ..models import JobRow, ScanRow
from .kind import Kind, KindChange, Outcome, RunContext
from .person_request import make_person
from .recover_request import AS_PERSON, PERSON, PERSON_REPORT_FILE, READING, RecoverRequest
from .redrape import order_redrape
from .request import pack_request
from .rows import add_metrics, add_pattern, add_pieces, describe_body, show_garment, summarise

if TYPE_CHECKING:
    from ...core.recover.recovery import Recovery, Request
    from ...core.run.hooks import Hooks
    from ..settings import ServiceSettings


class Recover(Kind):
    """Recover a garment's pattern, fabric and meshes from its scan."""

    name = "recover"
    request = RecoverRequest
    stages = ("check", *STAGES)

    def checker(self, settings: ServiceSettings) -> str:
        """Return the reader of scans, bodies, labels and patterns."""
        return settings.checker

    def choose_input(self, request: RecoverRequest, name: str) -> tuple[str, ...]:
        """Return the reading of the garment and the person's report, without other garments, pictures and reports."""
        return (f"{request.part}/{READING}", PERSON_REPORT_FILE) if name == PERSON and request.part is not None else ()

    def run(self, request: RecoverRequest, work: RunContext, hooks: Hooks) -> Recovery:
        """Run the pipeline and write its files."""
        from ...core.recover.delivery import UnfinishedRecovery
        from .unfinished import keep_unfinished

        person = work.inputs.get(PERSON)
        recovery: Recovery = work.settings.find("pipeline")(request.unpack(work.files, person), hooks)
        if request.part is not None and person is not None:
            recovery.report.metrics["confidence"] = _read_confidence(person, request.part)
        work.settings.find("writer")(recovery, work.out)
        if isinstance(recovery, UnfinishedRecovery):
            keep_unfinished(recovery, work.out)
        return recovery

    def turn(self, request: RecoverRequest, work: RunContext, hooks: Hooks) -> KindChange | None:
        """Return a person's job if the scan shows its wearer's head, hands or feet, or its labels name parts."""
        if request.part is not None or not request.is_open:
            return None
        if (work.files / AS_PERSON).exists() or _is_person(request.unpack(work.files), hooks):
            return KindChange("person", pack_request(make_person(request)))
        return None

    def store(self, session: Session, claim: Claim, result: Recovery) -> Outcome:
        """Add the rows of pattern, panels, pieces, fabric, wearer and metrics, and order the re-drape."""
        _add_scan(session, result)
        session.add(describe_body(claim.job, result.body))
        add_pattern(session, claim.job, result.pattern, result.fabric, _find_names(result))
        add_pieces(session, claim.job, result.pieces)
        add_metrics(session, claim.job, result.report.metrics)
        return Outcome(summarise(result.report), order_redrape(result))

    def show(self, session: Session, row: JobRow) -> dict[str, Any]:
        """Return garment, template, fabric and body by name."""
        return show_garment(session, row.id)


def _read_confidence(person: Path, part: str) -> float | None:
    """Return the confidence of a garment's labels from the result of the person's job."""
    report = json.loads((person / PERSON_REPORT_FILE).read_text(encoding="utf-8"))
    return next((one["confidence"] for one in report["garments"] if one["part"] == part), None)


def _is_person(request: Request, hooks: Hooks) -> bool:
    """Return whether a scan that was read with its wearer shows the whole person."""
    reading = request.reading
    if reading is None or request.body is None or request.labels is not None:
        return False
    from ...core.people.whole_person import has_person_height, shows_person
    from ...core.recover.wearer import find_body

    if not has_person_height(reading.pieces.garment, reading.pieces.wearer):
        return False
    return shows_person(reading.pieces.garment, find_body(request, reading.pieces, hooks))


def _add_scan(session: Session, recovery: Recovery) -> None:
    row = session.get(ScanRow, recovery.scan.sha256) if recovery.scan.sha256 else None
    if row is not None:
        scan = recovery.scan
        row.details = {
            "units": scan.units,
            "up_axis": scan.up_axis,
            "vertices": len(scan.vertices),
            "faces": len(scan.faces),
            "repairs": list(scan.repairs),
            "contours": {c.name: c.length for c in recovery.target.contours},
        }


def _find_names(recovery: Recovery) -> tuple[str, str]:
    return recovery.pattern.category or recovery.target.category, recovery.template
