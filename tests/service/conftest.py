"""Take the fixtures of the stand-in home; every test that touches the database runs on SQLite and on PostgreSQL."""

from __future__ import annotations

import pytest
from garmentq_family_home import family, persons, queue_person  # noqa: F401
from garmentq_home import (  # noqa: F401
    DATABASES,
    blank_database,
    cli,
    database,
    database_url,
    postgres,
    queue_job,
    settings,
    store,
)


@pytest.fixture(scope="session", params=DATABASES)
def database_kind(request):
    """Choose both databases, one after the other."""
    return request.param
