"""The signals that tell a process to stop, and handlers of them that last for a block."""

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
    """Handle signals by a handler for the block, and afterwards as before."""
    before = {number: signal.signal(number, handler) for number in signals}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


@contextmanager
def defer_stop_signals() -> Iterator[None]:
    """Handle what tells this process to stop within the block at its end; what is ignored stays so.

    Python handles signals in its main thread alone: in others the block changes nothing.
    """
    came: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()
    heard = [number for number in STOP_SIGNALS if is_main and signal.getsignal(number) is not signal.SIG_IGN]
    try:
        with handle_signals(heard, lambda number, _: came.append(number)):
            yield
    finally:  # also where the block failed: a signal is never lost
        for number in came:
            signal.raise_signal(number)
