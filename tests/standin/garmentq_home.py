"""Fixtures of the queue's tests: a fresh home with the stand-in pipeline, its database, and files to submit."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import fields
from pathlib import Path
from unittest import mock

import pytest
from garmentq.cli.main import main
from garmentq.service.database import Database, open_database, upgrade
from garmentq.service.jobs import find_job
from garmentq.service.models import JobRow
from garmentq.service.settings import ServiceSettings
from garmentq.service.states import ENDED
from garmentq.service.store import Store
from garmentq.service.submission import Order, submit
from garmentq.service.terms import JobTerms
from patience import WAIT_SECONDS
from postgres_server import PostgresServer
from sqlalchemy import create_engine, text
from sqlalchemy.engine import make_url
from sqlalchemy.pool import NullPool

STANDIN = Path(__file__).parent

HEADER = "ply\nformat ascii 1.0\nelement vertex 1\n" + "".join(f"property float {axis}\n" for axis in "xyz")
"""Begin of a file of one point, as far as its header is looked at."""

SERVER, BLANK = pytest.StashKey[PostgresServer](), pytest.StashKey[str]()

DATABASES = ("sqlite", "postgresql")
"""What the service must run on; a folder's conftest parametrises `database_kind` over it."""


SQLITE_BY_DAY = pytest.mark.parametrize(
    "database_kind", ["sqlite", pytest.param("postgresql", marks=pytest.mark.nightly)], indirect=True
)
"""For faults of processes, which look the same on both databases, and take long on each."""


def make_settings(home: Path, **changes) -> ServiceSettings:
    """Return settings with short times and the stand-in pipeline."""
    quick = {
        "lease_seconds": 2.0,
        "poll_seconds": 0.2,
        "republish_seconds": 3.0,
        "idle_seconds": 0.0,
        "pipeline": "garmentq_standin:recover",
        "writer": "garmentq_standin:write",
        "checker": "garmentq_checker:check",
        "person_checker": "garmentq_checker:check",
    }
    return ServiceSettings(home=home, **(quick | changes))


def make_environment(settings: ServiceSettings) -> dict[str, str]:
    """Return the environment of a command that uses these settings."""
    path = os.pathsep.join(part for part in (str(STANDIN), os.environ.get("PYTHONPATH", "")) if part)
    return {**os.environ, **settings.as_environment(), "PYTHONPATH": path, "COLUMNS": "200"}


class Cli:
    """Run garmentq's commands, in this process (quick) or in one of their own (as a user does)."""

    def __init__(self, settings: ServiceSettings) -> None:
        self.settings = settings
        self.environment = make_environment(settings)

    def __call__(self, *arguments: object, **variables: str) -> subprocess.CompletedProcess[str]:
        """Run one command to its end in this process."""
        words, out, error = [str(argument) for argument in arguments], io.StringIO(), io.StringIO()
        with (
            mock.patch.dict(os.environ, {**self.environment, **variables}),
            redirect_stdout(out),
            redirect_stderr(error),
        ):
            try:
                main(words)
            except SystemExit as end:
                return subprocess.CompletedProcess(words, int(end.code or 0), out.getvalue(), error.getvalue())
        raise AssertionError("a command must end by SystemExit")

    def start(self, *arguments: object, **variables: str) -> subprocess.CompletedProcess[str]:
        """Run one command to its end in a process of its own."""
        command = [sys.executable, "-m", "garmentq.cli.main", *map(str, arguments)]
        environment = {**self.environment, **variables}
        return subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=WAIT_SECONDS, check=False
        )


def put_file(folder: Path, name: str, content: str = "") -> Path:
    """Write a file that the stand-in takes for a mesh; its bytes differ by name."""
    path = folder / name
    path.write_text(f"{HEADER}comment {name} {content}\nend_header\n0 0 0\n")
    return path


def wait_for(check: Callable[[], object], seconds: float = WAIT_SECONDS) -> None:
    """Wait until something is true, and fail where it does not become so."""
    deadline = time.monotonic() + seconds
    while not check():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.05)


@pytest.fixture(scope="session")
def blank_database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make the tables once; each test takes a copy."""
    home = tmp_path_factory.mktemp("blank")
    open_database(make_settings(home), pooled=False).dispose()
    return home / "garmentq.db"


@pytest.fixture(scope="session")
def postgres(request: pytest.FixtureRequest) -> str:
    """Start a real PostgreSQL, once for all folders of tests; its blank database has the tables of the migrations.

    Gives the address of that database; `make_database` copies it.
    """
    stash = request.config.stash
    if BLANK not in stash:
        server = PostgresServer()
        request.config.add_cleanup(server.end)
        stash[SERVER], stash[BLANK] = server, make_database(server.url, template="template1")
    return stash[BLANK]


@pytest.fixture(scope="session")
def postgres_server(postgres: str, request: pytest.FixtureRequest) -> PostgresServer:
    """Return that server itself; whoever stops it must start it again."""
    return request.config.stash[SERVER]


def make_database(postgres: str, template: str | None = None) -> str:
    """Make a database on the server of `postgres`, by default a copy of that one, and give its address."""
    origin = make_url(postgres)
    made = origin.set(database=f"gq_{uuid.uuid4().hex[:12]}")
    engine = create_engine(origin.set(database="postgres"), isolation_level="AUTOCOMMIT", poolclass=NullPool)
    with engine.connect() as connection:
        connection.execute(text(f'create database "{made.database}" template "{template or origin.database}"'))
    engine.dispose()
    address = made.render_as_string(hide_password=False)
    if template:
        blank = Database(address, pooled=False)
        upgrade(blank)
        blank.dispose()
    return address


def drop_tables(address: str) -> None:
    """Empty a database of the test server."""
    engine = create_engine(address, poolclass=NullPool)
    with engine.begin() as connection:
        connection.execute(text("drop schema public cascade"))
        connection.execute(text("create schema public"))
    engine.dispose()


def drop_database(address: str) -> None:
    """Drop a database of the test server with every connection to it."""
    made = make_url(address)
    engine = create_engine(made.set(database="postgres"), isolation_level="AUTOCOMMIT", poolclass=NullPool)
    with engine.connect() as connection:
        connection.execute(text(f'drop database "{made.database}" with (force)'))
    engine.dispose()


@pytest.fixture(scope="session")
def database_kind() -> str:
    """Choose SQLite; a folder whose tests run on both overrides this with `params=DATABASES`."""
    return "sqlite"


@pytest.fixture
def database_url(database_kind: str, request: pytest.FixtureRequest) -> Iterator[str]:
    """Return the address of a fresh database with all tables; empty for SQLite, which lives in the home."""
    if database_kind == "sqlite":
        yield ""
        return
    address = make_database(request.getfixturevalue("postgres"))
    yield address
    drop_database(address)


@pytest.fixture
def settings(
    tmp_path: Path, blank_database: Path, database_url: str, monkeypatch: pytest.MonkeyPatch
) -> ServiceSettings:
    """Return a fresh home."""
    monkeypatch.syspath_prepend(str(STANDIN))
    return make_home(tmp_path / "home", blank_database, database_url)


def make_home(home: Path, blank_database: Path, database_url: str = "") -> ServiceSettings:
    """Make a home with a fresh database, or of the database of an address."""
    home.mkdir(mode=0o700)
    if not database_url:
        shutil.copy(blank_database, home / "garmentq.db")
    return make_settings(home, database_url=database_url)


@pytest.fixture
def database(settings: ServiceSettings) -> Iterator[Database]:
    """Open the home's database."""
    opened = open_database(settings)
    yield opened
    opened.dispose()


@pytest.fixture
def store(settings: ServiceSettings) -> Store:
    """Open the home's store."""
    return Store(settings.store_path)


@pytest.fixture
def cli(settings: ServiceSettings) -> Cli:
    """Return the command line for the home."""
    return Cli(settings)


@pytest.fixture
def queue_job(settings: ServiceSettings, database: Database, store: Store, tmp_path: Path) -> Callable[..., str]:
    """Return a function that queues a job for a scan of a name."""

    def queue(name: str = "shirt", **changes) -> str:
        body, known = put_file(tmp_path, "body.ply"), {field.name for field in fields(JobTerms)}
        terms = JobTerms(**{name: changes.pop(name) for name in known & set(changes)})
        return submit(database, store, Order(put_file(tmp_path, f"{name}.ply"), body, terms=terms, **changes)).job

    return queue


def read_job(settings: ServiceSettings, job: str) -> JobRow:
    """Read a job through a connection of its own."""
    opened = Database(settings.database, pooled=False)
    try:
        return find_job(opened, job)
    finally:
        opened.dispose()


def wait_ended(settings: ServiceSettings, job: str, seconds: float = WAIT_SECONDS) -> JobRow:
    """Wait until a job has ended."""
    wait_for(lambda: read_job(settings, job).state in ENDED, seconds)
    return read_job(settings, job)
