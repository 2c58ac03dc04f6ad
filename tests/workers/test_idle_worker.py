"""When an embedded worker goes home."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from pathlib import Path

import pytest
from garmentq.service.database import open_database
from garmentq.service.settings import ServiceSettings
from garmentq.workers.worker import DispatcherStep


def test_a_fresh_worker_waits_for_its_first_job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Breaks where an empty queue sends a worker home at the first look, seconds after `garmentq up`."""
    sent: list[int] = []
    monkeypatch.setattr(os, "kill", lambda process, number: sent.append(number))
    duties = DispatcherStep.__new__(DispatcherStep)
    duties.settings = replace(ServiceSettings(), home=tmp_path, idle_seconds=900.0)
    duties.database = open_database(duties.settings)
    duties.started = time.monotonic()
    duties._exit_if_idle()
    assert not sent
    duties.started -= 901.0
    duties._exit_if_idle()
    assert len(sent) == 1
