"""A recovery before its re-drape as one file of plain arrays, kept in its result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...core.body.body import Body
from ...core.people.undeclared import UndeclaredGarment
from ...core.recover.case import Case
from ...core.recover.drape.wearer import WearerGeometry
from ...core.recover.recovery import Request
from ...core.recover.state import RecoveryState
from ...core.reuse.wear.worn import ResultOld
from ...core.run.records import read_record, write_record
from ...core.run.sandbox import ReaderCrashed
from ...core.scan.contours.target import Target
from ...core.scan.scan import Scan
from .redrape_request import UNFINISHED, RedrapeRequest

if TYPE_CHECKING:
    from ...core.recover.delivery import UnfinishedRecovery
    from ...core.run.report import ResultReport


@dataclass(frozen=True)
class StoredUnfinished:
    """Describe a recovery before its re-drape, without its request.

    Attributes:
        scan: The checked scan.
        scan_target: The garment's surface as the scan shows it.
        body: The wearer as it was found.
        undeclared: Garments that labels mark as skin; None without labels.
        state: The state after the last step.
        metrics: The metrics so far.
        stage_seconds: CPU seconds of each stage so far.
        cpu_seconds: CPU seconds so far.
        peak_mb: Largest memory so far [MB].
    """

    scan: Scan
    scan_target: Target
    body: Body
    undeclared: tuple[UndeclaredGarment, ...] | None
    state: RecoveryState
    metrics: dict[str, float | None]
    stage_seconds: dict[str, float]
    cpu_seconds: float
    peak_mb: float

    def make_case(self, request: RedrapeRequest) -> Case:
        """Return the inputs of the recovery; its files, which no later step reads, are not there."""
        template = Path("pattern.json") if request.has_pattern_file else None
        recovered = Request(Path(self.scan.name), template=template, settings=request.settings)
        return Case(recovered, self.scan, self.scan_target, WearerGeometry(self.body), self.undeclared)

    def add_cost(self, report: ResultReport) -> ResultReport:
        """Return a report with the cost of both jobs."""
        names = [*self.stage_seconds, *(name for name in report.stage_seconds if name not in self.stage_seconds)]
        parts: tuple[Mapping[str, float], ...] = (self.stage_seconds, report.stage_seconds)
        seconds = {name: sum(part.get(name, 0.0) for part in parts) for name in names}
        total, peak = self.cpu_seconds + report.cpu_seconds, max(self.peak_mb, report.peak_mb)
        return replace(report, stage_seconds=seconds, cpu_seconds=total, peak_mb=peak)


def keep_unfinished(recovery: UnfinishedRecovery, folder: Path) -> None:
    """Write what a recovery's re-drape starts from into the folder of its result."""
    case, state, report = recovery.case, recovery.state, recovery.report
    found = StoredUnfinished(
        case.scan, case.scan_target, case.body, case.undeclared, state, report.metrics, report.stage_seconds,
        report.cpu_seconds, report.peak_mb,
    )  # fmt: skip
    write_record(found, folder / UNFINISHED)


def load_unfinished(folder: Path) -> StoredUnfinished:
    """Read a recovery before its re-drape from the folder of its result.

    Raises:
        ResultOld: if another version wrote it.
    """
    try:
        return read_record(StoredUnfinished, folder / UNFINISHED)
    except ReaderCrashed as error:
        raise ResultOld() from error
