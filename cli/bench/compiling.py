"""The CPU time that numba takes to compile kernels: once an installation, and no part of what a recovery costs."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event


class CompileClock(event.Listener):
    """Sum the CPU seconds of compilations; one inside another counts once, and what is read from the cache does not.

    Attributes:
        seconds: CPU seconds so far.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._depth = 0
        self._start = 0.0

    def on_start(self, event: Any) -> None:
        """Begin with the outermost compilation."""
        if self._depth == 0:
            self._start = time.process_time()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """End with the outermost compilation."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.process_time() - self._start


@contextmanager
def time_compiling() -> Iterator[CompileClock]:
    """Measure what is compiled while the context lasts."""
    clock = CompileClock()
    event.register("numba:compile", clock)  # type: ignore[no-untyped-call]
    try:
        yield clock
    finally:
        event.unregister("numba:compile", clock)  # type: ignore[no-untyped-call]
