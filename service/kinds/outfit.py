"""The kind `outfit`: all recovered garments of a person on one body, each over the one before."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from sqlalchemy import select
from sqlalchemy.orm import Session

from ..jobs import Claim
from ..lanes import Lane
from ..models import JobRow
from ..states import State
from .dress import BODY_CHECKER, GARMENT_FILES
from .dress_request import BODY
from .kind import Kind, Outcome, RunContext
from .outfit_request import OutfitRequest
from .recover_request import PERSON, PERSON_REPORT_FILE
from .request import FileRef, RequestBad, read_request
from .rows import add_metrics, describe_body, summarise

if TYPE_CHECKING:
    from ...core.reuse.wear.outfit import DressedOutfit
    from ...core.run.hooks import Hooks
    from ..settings import ServiceSettings


class Outfit(Kind):
    """Dress a body in all garments of a person; the person's job is one input, each garment's recovery another."""

    name = "outfit"
    request = OutfitRequest
    stages: ClassVar[tuple[str, ...]] = ("check", "body", "drape", "measure")
    lane = Lane.INTERACTIVE
    reads = MappingProxyType({PERSON: ("person",)})

    def checker(self, settings: ServiceSettings) -> str:
        """Return the reader of bodies."""
        return BODY_CHECKER

    def adopt(self, session: Session, request: dict[str, Any], row: JobRow) -> dict[str, Any]:
        """Return the request with the order of the garments, derived from the openings in the person's result.

        Raises:
            RequestBad: if the requested order does not name the worn garments.
        """
        from ..layering import order_garments

        person = (row.result or {}).get("person")
        if person is None:  # it has not ended; the caller refuses that
            return request
        found, words = order_garments(person), read_request(OutfitRequest, request).words
        if words and sorted(words) != sorted(found):
            raise RequestBad(f"'order' names each garment that was recovered, innermost first: {','.join(found)}.")
        return request | {"order": ",".join(words or found)}

    def find_inputs(self, session: Session, request: dict[str, Any], row: JobRow) -> dict[str, str]:
        """Return the recovery of each garment of the person by its word.

        Raises:
            RequestBad: if one was deleted.
        """
        below = session.scalars(select(JobRow).where(JobRow.parent == row.id, JobRow.kind == "recover"))
        words = read_request(OutfitRequest, request).words
        found = {str(one.request.get("part")): one.id for one in below}
        for word in words:
            if word not in found and row.state == State.SUCCEEDED:
                raise RequestBad(f"the job of the person's {word} was deleted; dress in each garment that is left.")
        return {word: found[word] for word in words if word in found}

    def choose_input(self, request: OutfitRequest, name: str) -> tuple[str, ...]:
        """Return the person's report, or a garment on its wearer, without meshes, pictures and other reports."""
        return (PERSON_REPORT_FILE,) if name == PERSON else GARMENT_FILES

    def run(self, request: OutfitRequest, work: RunContext, hooks: Hooks) -> DressedOutfit:
        """Dress the body and write the files."""
        from ...core.deliver.export.outfit import write_outfit
        from ...core.reuse.wear.bodies import BodyFile, find_wearer
        from ...core.reuse.wear.outfit import dress_outfit
        from ...core.reuse.wear.worn import load_worn
        from ...core.run.clock import Clock
        from ...core.run.records import read_record

        outfit = {word: load_worn(work.inputs[word]) for word in request.words}
        first, clock = next(iter(outfit.values())), Clock(hooks)
        body_file = read_record(BodyFile, work.files / BODY) if isinstance(request.body, FileRef) else request.body
        with clock.stage("body", "finding the body's joints") as stage_hooks:
            body = find_wearer(body_file, first.body, request.pose, stage_hooks)
        dressed = dress_outfit(outfit, body, clock)
        write_outfit(dressed, work.out)
        return dressed

    def store(self, session: Session, claim: Claim, result: DressedOutfit) -> Outcome:
        """Add the rows of the body and the metrics."""
        session.add(describe_body(claim.job, result.body))
        add_metrics(session, claim.job, result.report.metrics)
        return Outcome(summarise(result.report))

    def show(self, session: Session, row: JobRow) -> dict[str, Any]:
        """Return the garments from the innermost to the outermost, and the body by name."""
        words = read_request(OutfitRequest, row.request).words
        return {"garments": list(words), "body": ((row.result or {}).get("manifest") or {}).get("body")}
