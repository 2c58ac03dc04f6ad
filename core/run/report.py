"""The report of a result: numbers, verdicts, warnings, cost, and what reproduces it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from .clock import Clock, peak_mb
from .verdict import Gate

Metrics = dict[str, float | None]
"""Flat dotted names to numbers; None where a metric does not apply."""


@dataclass(frozen=True)
class ResultReport:
    """Describe the report of one result.

    Attributes:
        metrics: The measurements.
        gates: The verdicts.
        warnings: Warnings for the user, one sentence each.
        stage_seconds: CPU seconds by stage name.
        cpu_seconds: CPU seconds of the whole.
        peak_mb: Largest resident memory of the process [MB].
        manifest: What reproduces the result: versions, hashes, settings, findings.
    """

    metrics: Metrics = field(default_factory=dict)
    gates: tuple[Gate, ...] = ()
    warnings: tuple[str, ...] = ()
    stage_seconds: dict[str, float] = field(default_factory=dict)
    cpu_seconds: float = 0.0
    peak_mb: float = 0.0
    manifest: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls, clock: Clock, metrics: Metrics, gates: Iterable[Gate], warnings: Iterable[str], manifest: dict[str, Any]
    ) -> ResultReport:
        """Return the report of a calculation that ends now; repeated warnings are listed once."""
        unique = tuple(dict.fromkeys(warnings))
        return cls(metrics, tuple(gates), unique, clock.seconds, clock.total, peak_mb(), manifest)
