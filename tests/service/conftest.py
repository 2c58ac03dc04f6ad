"""Take the fixtures of the stand-in home; every test that touches the database runs on SQLite and on PostgreSQL."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from garmentq.service.local import LocalBackend
from garmentq.service.local_token import make_local_token
from garmentq.service.remote import RemoteBackend
from garmentq_family_home import family, persons, queue_person  # noqa: F401
from garmentq_home import (  # noqa: F401
    DATABASES,
    blank_database,
    cli,
    database,
    database_url,
    postgres,
    postgres_server,
    queue_job,
    settings,
    store,
)

sys.path.insert(0, str(Path(__file__).parents[1] / "api"))

from api_client import serving


@pytest.fixture(scope="session", params=DATABASES)
def database_kind(request):
    """Choose both databases, one after the other."""
    return request.param


@pytest.fixture(params=["local", "remote"])
def backend(request, settings):  # noqa: F811
    """Answer from the home, and from a service that serves it."""
    if request.param == "local":
        opened = LocalBackend(settings)
        yield opened
        opened.close()
    else:
        with serving(settings) as url, RemoteBackend(url, make_local_token(settings.home)) as there:
            yield there
