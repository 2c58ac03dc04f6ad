"""What a signal does to a command: all that tell it to stop are as Ctrl-C, so that whatever it must undo is undone."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

TOLD = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that tell a command to stop: Ctrl-C, a supervisor, a terminal that closes."""


def stop_as_told() -> None:
    """Turn SIGTERM and SIGHUP into KeyboardInterrupt, as Python does with SIGINT; what is ignored stays so (nohup)."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number in TOLD:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Let no further signal cut short what is undone in the block; each part of it ends by itself."""
    before = {number: signal.signal(number, signal.SIG_IGN) for number in TOLD}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
