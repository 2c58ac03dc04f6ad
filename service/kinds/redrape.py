"""The kind `redrape`: a recovered pattern is dressed anew, and the result that it belongs to is judged by that too."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from sqlalchemy import delete, update
from sqlalchemy.orm import Session

from ..jobs import Claim
from ..judging import change_result
from ..lanes import Lane
from ..models import ArtifactRow, JobRow, MetricRow
from .dress_request import RESULT
from .kind import PARENT, ChildRequest, Kind, Outcome, RunContext
from .redrape_request import REDRAPE, REDRAPE_PRIORITY, REDRAPED_FILES, UNFINISHED, RedrapeRequest
from .request import pack_request
from .rows import add_metrics, summarise

if TYPE_CHECKING:
    from ...core.recover.recovery import Recovery
    from ...core.run.hooks import Hooks


class Redrape(Kind):
    """Dress the wearer of a recovery anew in its pattern; only a recovery makes such a job."""

    name = REDRAPE
    request = RedrapeRequest
    stages: ClassVar[tuple[str, ...]] = ("check", "redrape", "measure")
    changes = RESULT

    def choose_input(self, request: RedrapeRequest, name: str) -> tuple[str, ...]:
        """Return the file of the recovery before its re-drape."""
        return (UNFINISHED,)

    def run(self, request: RedrapeRequest, work: RunContext, hooks: Hooks) -> Recovery:
        """Drape, measure, and write the files that differ."""
        from dataclasses import replace

        from ...core.recover.pipeline import finish
        from .unfinished import load_unfinished

        kept = load_unfinished(work.inputs[RESULT])
        found = finish(kept.make_case(request), kept.state, kept.metrics, hooks)
        work.settings.find("writer")(replace(found, report=kept.add_cost(found.report)), work.out)
        for path in work.out.rglob("*"):
            if path.is_file() and path.name not in REDRAPED_FILES:
                path.unlink()
        return found

    def store(self, session: Session, claim: Claim, result: Recovery) -> Outcome:
        """Replace metrics, verdict and files of the recovery's result; its other rows stay."""
        recovery, summary = claim.inputs[RESULT], summarise(result.report)
        session.flush()
        session.execute(delete(MetricRow).where(MetricRow.job == recovery))
        add_metrics(session, recovery, result.report.metrics)
        is_file = ArtifactRow.kind == "result"
        replaced = is_file & (ArtifactRow.job == recovery) & ArtifactRow.name.in_([UNFINISHED, *REDRAPED_FILES])
        session.execute(delete(ArtifactRow).where(replaced))
        session.execute(update(ArtifactRow).where(is_file, ArtifactRow.job == claim.job).values(job=recovery))
        changed = {name: summary[name] for name in ("gates", "warnings", "manifest")}
        change_result(session, session.get_one(JobRow, recovery), changed, claim.job)
        return Outcome({name: value for name, value in summary.items() if name not in changed})


def order_redrape(recovery: Recovery) -> tuple[ChildRequest, ...]:
    """Return the re-drape of a recovery that left it for later, or none."""
    from ...core.recover.delivery import UnfinishedRecovery

    if not isinstance(recovery, UnfinishedRecovery):
        return ()
    recovered = recovery.case.request
    request = RedrapeRequest(recovered.settings, recovered.template is not None)
    inputs, lane = {RESULT: PARENT}, Lane.BATCH
    packed = pack_request(request)
    return (ChildRequest(REDRAPE, REDRAPE, packed, inputs=inputs, priority=REDRAPE_PRIORITY, lane=lane),)
