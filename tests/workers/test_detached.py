"""Processes that outlive the one that started them."""

from __future__ import annotations

import os
import signal

import pytest
from garmentq.service.signals import handle_signals
from garmentq.workers.detached import launch_or_kill

SLEEP = ["/bin/sleep", "600"]


def test_a_signal_while_a_process_starts_leaves_none_behind(tmp_path, monkeypatch):
    """Broken where who is told to stop before he has the process's id leaves it running for ever."""
    spawn, started = os.posix_spawn, []

    def told(*given, **options):
        started.append(spawn(*given, **options))
        signal.raise_signal(signal.SIGINT)
        return started[0]

    monkeypatch.setattr(os, "posix_spawn", told)
    with handle_signals([signal.SIGINT], signal.default_int_handler):
        with pytest.raises(KeyboardInterrupt), launch_or_kill(SLEEP, tmp_path / "log"):
            pytest.fail("the signal is lost")
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert os.WTERMSIG(os.waitpid(started[0], 0)[1]) == signal.SIGKILL


def test_what_is_up_stays_and_what_is_not_ends(tmp_path):
    """Broken where a start that failed leaves its process, or one that succeeded ends with the block."""
    with launch_or_kill(SLEEP, tmp_path / "log") as process:
        pass
    assert os.waitpid(process, os.WNOHANG) == (0, 0)
    os.kill(process, signal.SIGTERM)
    assert os.WTERMSIG(os.waitpid(process, 0)[1]) == signal.SIGTERM
    with pytest.raises(ValueError, match="not up"), launch_or_kill(SLEEP, tmp_path / "log") as process:
        raise ValueError("not up")
    assert os.WTERMSIG(os.waitpid(process, 0)[1]) == signal.SIGKILL
