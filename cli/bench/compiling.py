"""The CPU time that numba takes to compile kernels, once an installation: it is not part of a recovery's cost."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event


class CompileClock(event.Listener):
    """Sum the CPU seconds of compilations; nested ones count once, and kernels read from the cache do not count.

    Attributes:
        seconds: CPU seconds so far.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._depth = 0
        self._start = 0.0

    def on_start(self, event: Any) -> None:
        """Start the clock at the outermost compilation."""
        if self._depth == 0:
            self._start = time.process_time()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """Stop the clock at the outermost compilation."""
        self._depth -= 1
        if self._depth == 0:
            self.seconds += time.process_time() - self._start


@contextmanager
def time_compiling() -> Iterator[CompileClock]:
    """Measure the compilations within the block."""
    clock = CompileClock()
    event.register("numba:compile", clock)  # type: ignore[no-untyped-call]
    try:
        yield clock
    finally:
        event.unregister("numba:compile", clock)  # type: ignore[no-untyped-call]
