"""Signals in a command: every stop signal acts like Ctrl-C, so that the command cleans up."""

from __future__ import annotations

import signal
import threading
from contextlib import AbstractContextManager

from ..service.signals import STOP_SIGNALS, handle_signals


def interrupt_on_stop_signals() -> None:
    """Convert SIGTERM and SIGHUP into KeyboardInterrupt, as Python does with SIGINT; ignored ones stay ignored."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number in STOP_SIGNALS:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)


def ignore_stop_signals() -> AbstractContextManager[None]:
    """Return a context in which further stop signals do not interrupt the clean-up; each part of it ends by itself."""
    return handle_signals(STOP_SIGNALS, signal.SIG_IGN)
