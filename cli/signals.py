"""What a signal does to a command: all that tell it to stop are as Ctrl-C, so that whatever it must undo is undone."""

from __future__ import annotations

import signal
import threading
from contextlib import AbstractContextManager

from ..service.signals import STOP_SIGNALS, handle_signals


def interrupt_on_stop_signals() -> None:
    """Turn SIGTERM and SIGHUP into KeyboardInterrupt, as Python does with SIGINT; what is ignored stays so (nohup)."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number in STOP_SIGNALS:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)


def ignore_stop_signals() -> AbstractContextManager[None]:
    """Return a block in which no further signal cuts short what is undone; each part of it ends by itself."""
    return handle_signals(STOP_SIGNALS, signal.SIG_IGN)
