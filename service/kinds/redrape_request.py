"""The request of a re-drape, and the names that it shares with the recovery that makes it."""

from __future__ import annotations

from dataclasses import dataclass, field

from ...core.recover.settings import RecoverySettings

REDRAPE = "redrape"
"""Name of the kind, and of the job among its siblings."""

REDRAPE_PRIORITY = -100
"""Number for the priority of a re-drape, the lowest that an order may have: every result goes before it."""

UNFINISHED = "unfinished.npz"
"""File of a recovery's result from which its re-drape starts; it is dropped with the end of that."""

REDRAPED_FILES = ("redrape.ply", "metrics.json", "manifest.json", "report.html")
"""Files of a recovery's result that its re-drape writes."""


@dataclass(frozen=True)
class RedrapeRequest:
    """Describe the re-drape of a recovery.

    Attributes:
        settings: Settings of the recovery.
        has_pattern_file: Whether its base pattern was a file, so that the cut that came out has no name.
    """

    settings: RecoverySettings = field(default_factory=RecoverySettings)
    has_pattern_file: bool = False
