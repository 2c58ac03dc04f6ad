"""Findings of the steps of a calculation, in addition to its result."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any


class FindingKind(StrEnum):
    """Describe the kind of a finding, in the order of a report."""

    NOTE = "note"
    """Information for the user."""
    CUT = "cut"
    """A cut of the library that was compared with the scan."""
    OPENING = "opening"
    """An opening of the garment beside its contours: a front, a placket, a wrap, a vent."""
    PANEL_CHANGE = "panel_change"
    """A dart that was added or closed."""
    CORNER = "corner"
    """A corner that the scan proves where the base pattern is smooth."""
    CHOICE = "choice"
    """Alternatives that were tried, and the one that was taken."""


@dataclass(frozen=True)
class Finding:
    """Describe one finding of a step.

    Attributes:
        kind: Its kind.
        message: One sentence for the user; empty for a finding that is only in the manifest.
        value: Its figure, or None.
        evidence: Its entry in the manifest, as JSON values.
    """

    kind: FindingKind
    message: str = ""
    value: float | None = None
    evidence: dict[str, Any] = field(default_factory=dict)


def note(message: str) -> Finding:
    """Return a message to the user as a finding."""
    return Finding(FindingKind.NOTE, message)
