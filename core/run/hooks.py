"""The calls of a running stage to its surroundings: progress, cancellation, checkpoints, findings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeAlias

from .errors import Cancelled
from .finding import Finding

if TYPE_CHECKING:
    import numpy as np

Arrays: TypeAlias = "Mapping[str, np.ndarray]"


def _no_progress(stage: str, fraction: float, message: str) -> None:
    return None


def _never_cancelled() -> bool:
    return False


def _no_save(name: str, arrays: Arrays) -> None:
    return None


def _no_load(name: str) -> Arrays | None:
    return None


def _no_report(finding: Finding) -> None:
    return None


@dataclass(frozen=True)
class Hooks:
    """Describe the calls that a running stage makes to its surroundings.

    Attributes:
        on_progress: Called with (stage, fraction in 0..1, message).
        is_cancelled: Called between iterations; True stops the stage within one of them.
        save_checkpoint: Stores arrays under a name for a later run of the same job.
        load_checkpoint: Returns the arrays stored under a name, or None.
        on_finding: Called with each finding of a stage.
    """

    on_progress: Callable[[str, float, str], None] = field(default=_no_progress)
    is_cancelled: Callable[[], bool] = field(default=_never_cancelled)
    save_checkpoint: Callable[[str, Arrays], None] = field(default=_no_save)
    load_checkpoint: Callable[[str], Arrays | None] = field(default=_no_load)
    on_finding: Callable[[Finding], None] = field(default=_no_report)

    def progress(self, stage: str, fraction: float, message: str = "") -> None:
        """Report progress of a stage; raise `Cancelled` if the job was cancelled meanwhile."""
        self.on_progress(stage, float(min(max(fraction, 0.0), 1.0)), message)
        self.check()

    def report(self, finding: Finding) -> None:
        """Report a finding."""
        self.on_finding(finding)

    def quiet(self) -> Hooks:
        """Return the same hooks without progress, for a stage within a stage, whose fractions would jump."""
        return replace(self, on_progress=_no_progress)

    def check(self) -> None:
        """Raise `Cancelled` if the job was cancelled."""
        if self.is_cancelled():
            raise Cancelled()


SILENT_HOOKS = Hooks()
