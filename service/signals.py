"""Stop signals, and handlers of them for a block."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Ctrl-C, a supervisor, a terminal that closes."""


@contextmanager
def handle_signals(
    signals: Iterable[signal.Signals], handler: Callable[[int, Any], Any] | signal.Handlers
) -> Iterator[None]:
    """Install a handler of signals for the block, and restore the earlier ones afterwards."""
    before = {number: signal.signal(number, handler) for number in signals}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


@contextmanager
def defer_stop_signals() -> Iterator[None]:
    """Defer stop signals that arrive within the block to its end; ignored signals stay ignored.

    Python handles signals only in its main thread: in others the block changes nothing.
    """
    came: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()
    numbers = [number for number in STOP_SIGNALS if is_main and signal.getsignal(number) is not signal.SIG_IGN]
    try:
        with handle_signals(numbers, lambda number, _: came.append(number)):
            yield
    finally:  # also after an error: a signal is never lost
        for number in came:
            signal.raise_signal(number)
