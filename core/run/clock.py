"""Measure CPU seconds of each stage of a run, and report progress by stage."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from .finding import Finding
from .hooks import SILENT_HOOKS, Hooks


def peak_bytes() -> int:
    """Return the largest resident memory so far [bytes]; Linux counts in KiB, macOS in bytes."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def peak_mb() -> float:
    """Return the largest resident memory of the process so far [MB]."""
    return peak_bytes() / 2**20


class Clock:
    """Measure CPU seconds by stage, report the running stage to the hooks, and collect findings."""

    def __init__(self, hooks: Hooks = SILENT_HOOKS) -> None:
        self.hooks = replace(hooks, on_finding=self._collect)
        self.seconds: dict[str, float] = {}
        self.start = time.process_time()
        self._found: list[Finding] = []

    @contextmanager
    def stage(self, name: str, message: str) -> Iterator[Hooks]:
        """Time one stage, which may be entered again; the hooks that it yields report progress under its name."""
        self.hooks.progress(name, 0.0, message)
        before = time.process_time()
        yield replace(self.hooks, on_progress=lambda _, fraction, text: self.hooks.on_progress(name, fraction, text))
        self.seconds[name] = self.seconds.get(name, 0.0) + time.process_time() - before
        self.hooks.progress(name, 1.0, message)

    def _collect(self, finding: Finding) -> None:
        self._found.append(finding)

    def take_findings(self) -> tuple[Finding, ...]:
        """Return the findings since the last call."""
        found, self._found = tuple(self._found), []
        return found

    @property
    def total(self) -> float:
        """Return the CPU seconds since the start."""
        return time.process_time() - self.start
