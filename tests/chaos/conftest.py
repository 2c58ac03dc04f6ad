"""Take the fixtures of the stand-in home; every fault is tried on SQLite and on PostgreSQL, with a real Valkey."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from garmentq_home import (  # noqa: F401
    DATABASES,
    blank_database,
    cli,
    database,
    database_url,
    make_environment,
    postgres,
    postgres_server,
    queue_job,
    settings,
    store,
)
from worker_nursery import Nursery

STANDIN = Path(__file__).parents[1] / "standin"


@pytest.fixture(scope="session", params=DATABASES)
def database_kind(request):
    """Choose both databases, one after the other."""
    return request.param


@pytest.fixture(scope="session")
def nursery():
    """Start workers quickly."""
    path = os.pathsep.join(part for part in (str(STANDIN), os.environ.get("PYTHONPATH", "")) if part)
    started = Nursery({**os.environ, "PYTHONPATH": path})
    yield started
    started.end()


@pytest.fixture
def start_worker(nursery, settings, marks):  # noqa: F811
    """Return a context in which a worker of one job at a time runs; what is left of it at the end is killed."""

    @contextmanager
    def start(*arguments, **changes):
        environment = {**os.environ, **replace(settings, **changes).as_environment()}
        process = nursery.start(["--workers", "1", *arguments], environment, settings.home / "worker.log")
        try:
            yield process
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()

    return start


@pytest.fixture
def marks(settings, monkeypatch, tmp_path):  # noqa: F811
    """Let workers find the stand-in, give the file of its marks, and leave nothing running behind."""
    from garmentq.workers.embedded import stop_services

    path = tmp_path / "marks"
    for name, value in {**make_environment(settings), "STANDIN_MARKS": str(path)}.items():
        monkeypatch.setenv(name, value)
    yield path
    stop_services(settings)
