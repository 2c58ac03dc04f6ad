"""What the steps of a calculation find beside its result."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any


class FindingKind(StrEnum):
    """Describe what a finding is of, in the order in which a report shows them."""

    NOTE = "note"
    """What the user should know."""
    CUT = "cut"
    """A cut of the library that was compared with the scan."""
    PANEL_CHANGE = "panel_change"
    """A dart that was added or closed."""
    CORNER = "corner"
    """A corner that the scan proves where the base pattern is smooth."""
    CHOICE = "choice"
    """Alternatives that were tried, and the one that was taken."""


@dataclass(frozen=True)
class Finding:
    """Describe one thing that a step found.

    Attributes:
        kind: What it is of.
        message: One sentence for the user; empty where it only stands in the manifest.
        value: Its figure, or None.
        evidence: What the manifest holds of it, as JSON values.
    """

    kind: FindingKind
    message: str = ""
    value: float | None = None
    evidence: dict[str, Any] = field(default_factory=dict)


def note(message: str) -> Finding:
    """Return what the user should know as a finding."""
    return Finding(FindingKind.NOTE, message)
