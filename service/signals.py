"""The signals that tell a process to stop, and handlers of them that last for a block."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Ctrl-C, a supervisor, a terminal that closes."""


@contextmanager
def handling(signals: Iterable[signal.Signals], handler: Callable[[int, Any], Any] | signal.Handlers) -> Iterator[None]:
    """Handle signals by a handler for the block, and afterwards as before."""
    before = {number: signal.signal(number, handler) for number in signals}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)
