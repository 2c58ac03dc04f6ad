"""Take the fixtures of the stand-in home; every fault is tried on SQLite and on PostgreSQL, with a real Valkey."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "standin"))

from garmentq_home import (  # noqa: F401
    DATABASES,
    blank_database,
    cli,
    database,
    database_url,
    make_environment,
    postgres,
    queue_job,
    settings,
    store,
)


@pytest.fixture(scope="session", params=DATABASES)
def database_kind(request):
    """Choose both databases, one after the other."""
    return request.param


@pytest.fixture
def marks(settings, monkeypatch, tmp_path):  # noqa: F811
    """Let workers find the stand-in, give the file of its marks, and leave nothing running behind."""
    from garmentq.workers.embedded import stop_services

    path = tmp_path / "marks"
    for name, value in {**make_environment(settings), "STANDIN_MARKS": str(path)}.items():
        monkeypatch.setenv(name, value)
    yield path
    stop_services(settings)
