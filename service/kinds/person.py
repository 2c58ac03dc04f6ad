"""The kind `person`: a raw scan of a dressed person is segmented, and each garment recovered by a job of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ...core.run.errors import GarmentqError
from ..jobs import Claim
from .kind import PARENT, ChildRequest, Kind, Outcome, RunContext
from .person_request import PersonRequest
from .recover import Recover
from .recover_request import PERSON
from .request import pack_request, read_request
from .rows import add_metrics, describe_body, summarise

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

    from ...core.run.hooks import Hooks
    from ..models import JobRow
    from ..settings import ServiceSettings
    from .person_found import PersonFound


class Person(Kind):
    """Segment a person; the children are the garments' recoveries."""

    name = "person"
    request = PersonRequest
    stages = ("check", "body", "separate", "garments")

    def checker(self, settings: ServiceSettings) -> str:
        """Return the reader of raw scans, bodies, labels and patterns."""
        return settings.person_checker

    def run(self, request: PersonRequest, work: RunContext, hooks: Hooks) -> PersonFound:
        """Segment the person and write its files."""
        found: PersonFound = work.settings.find("separator")(request, work, hooks)
        return found

    def store(self, session: Session, claim: Claim, result: PersonFound) -> Outcome:
        """Add the rows of wearer and metrics, and request the garments' recoveries."""
        session.add(describe_body(claim.job, result.body))
        add_metrics(session, claim.job, result.report.metrics)
        summary = summarise(result.report) | {"person": result.person}
        if result.problem is not None:
            return Outcome(summary, failure=result.problem)
        try:
            return Outcome(summary, _make_children(read_request(PersonRequest, claim.request), result))
        except GarmentqError as error:
            return Outcome(summary, failure=error)

    def show(self, session: Session, row: JobRow) -> dict[str, Any]:
        """Return garments, readings of the outfit, and the parts."""
        person = (row.result or {}).get("person", {})
        return {name: person.get(name) for name in ("garments", "outfits", "parts")}


def _make_children(request: PersonRequest, found: PersonFound) -> tuple[ChildRequest, ...]:
    """Return a recovery for each garment that has no problem."""
    chosen = request.choose(found.words)
    return tuple(
        ChildRequest(
            word, Recover.name, pack_request(request.make_recovery(word, chosen[word])), inputs={PERSON: PARENT}
        )
        for word in found.recovered_words
    )
