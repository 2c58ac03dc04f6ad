"""The database: connections, its clock, and its two kinds of transaction."""

from __future__ import annotations

import logging
import math
import os
import sqlite3
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from copy import copy
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, TypeVar, cast

from sqlalchemy import (
    ColumnElement,
    Connection,
    CursorResult,
    Delete,
    Engine,
    Float,
    Update,
    create_engine,
    event,
    func,
    inspect,
    text,
)
from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError, DatabaseError, OperationalError
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.orm import Session
from sqlalchemy.pool import NullPool
from sqlalchemy.sql.functions import FunctionElement

from ..core.run.errors import GarmentqError, Unavailable
from ..core.run.text import TextBad, has_unstorable_text
from .columns import RowDamaged
from .damage import DamagedRow, SoundSession, describe_damaged_rows, find_damaged
from .lock import hold_lock
from .private import make_private
from .settings import ServiceSettingBad, ServiceSettings, hide_password
from .sqlite_setup import BUSY_SECONDS, WRITE, set_up_sqlite

log = logging.getLogger(__name__)

P = ParamSpec("P")
T = TypeVar("T")

DATABASE_CONNECT_TIMEOUT = 10
"""Time limit for PostgreSQL to accept a connection [s]; a distant server takes a fraction of a second."""

DECODE_ERROR_TEXT = "Could not decode to UTF-8"
"""The driver's message for a text that is not UTF-8."""

DAMAGE_ERROR_TEXTS = (
    "malformed", "file is not a database", "unsupported file format", "no such table", "no such column",
)  # fmt: skip
"""SQLite's messages for a file whose bytes changed; tables of another version are detected before any query."""

DAMAGED_CODES = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_FORMAT)
"""SQLite's error codes for the same, whatever the message."""

ONE_MOMENT = "REPEATABLE READ"
"""Isolation of a reading transaction on PostgreSQL: by default each query sees what others committed before it, so a
job whose state changes between two queries is in neither answer, or in both. SQLite's log does so by itself."""

DOUBT_SECONDS = 60.0
"""Time for which rows found damaged are excluded without another attempt [s]: each attempt may scan a table."""


class DatabaseUnreachable(Unavailable):
    """The database cannot be reached; check GARMENTQ_DATABASE_URL or the permissions of the home folder."""

    code = "service.database_unreachable"


class DatabaseDamaged(DatabaseUnreachable):
    """The database file is damaged; `garmentq down`, keep the file aside, then `garmentq restore BACKUP.tar`."""

    code = "service.database_damaged"


class DatabaseEmpty(GarmentqError):
    """The database has no tables yet; run `garmentq db upgrade` once, which creates them and the store."""

    code = "service.database_empty"


class DatabaseTooNew(GarmentqError):
    """The database was made by a newer garmentq; upgrade this one, or use another --home."""

    code = "service.database_too_new"


class DatabaseTooOld(GarmentqError):
    """The database was made by an older garmentq; stop its workers, save it, then run `garmentq db upgrade`."""

    code = "service.database_too_old"


class DriverMissing(GarmentqError):
    """The driver for this database is missing; pip install 'garmentq[postgres]'."""

    code = "service.driver_missing"


class clock(FunctionElement[float]):
    """Return the database's own time [s since 1970], so that the clocks of workers have no effect."""

    type = Float()
    inherit_cache = True
    name = "clock"


@compiles(clock, "sqlite")
def _clock_sqlite(element: clock, compiler: Any, **options: Any) -> str:
    return "((julianday('now') - 2440587.5) * 86400.0)"


@compiles(clock, "postgresql")
def _clock_postgresql(element: clock, compiler: Any, **options: Any) -> str:
    return "extract(epoch from clock_timestamp())::double precision"


class Database:
    """Provide transactions. One object per process: do not use it in a forked child.

    A transaction that reads an invalid value ends with `RowDamaged`, which names table and key.

    Attributes:
        url: SQLAlchemy address.
        engine: The connections.
        intact: The same database without its damaged rows; used by `skip_damaged_rows`.
        doubtful_until: Time until which `intact` is used at once [s, monotonic].
    """

    def __init__(self, url: str, pooled: bool = True) -> None:
        """Prepare an engine; no connection is opened before the first transaction.

        Args:
            url: SQLAlchemy address.
            pooled: Keep connections open between transactions. False in a process that forks.
        """
        self.url = url
        self.engine = _make_engine(url, pooled)
        self._writer = self.engine.execution_options(**{WRITE: True})
        self._reader = self.engine if self.is_sqlite else self.engine.execution_options(isolation_level=ONE_MOMENT)
        self._session: type[Session] = Session
        self.doubtful_until = -math.inf
        self.intact = copy(self)
        self.intact.intact, self.intact._session, self.intact.doubtful_until = self.intact, SoundSession, math.inf

    @contextmanager
    def read(self) -> Iterator[Session]:
        """Open a session that only reads; all its queries see the database as it was at the first."""
        with self._open(self._reader) as session:
            yield session

    @contextmanager
    def write(self) -> Iterator[Session]:
        """Open a session that may write; SQLite takes its write lock at once (`BEGIN IMMEDIATE`)."""
        with self._open(self._writer) as session:
            yield session

    @contextmanager
    def _open(self, engine: Engine) -> Iterator[Session]:
        try:
            opened = self._session(engine, expire_on_commit=False)
            with translate_driver_errors(self.url), opened as session, session.begin():
                yield session
        except RowDamaged as error:
            rows = self.find_damaged([error.table] if error.table else ())
            raise RowDamaged(describe_damaged_rows(rows) if rows else "", error.table) from error

    def find_damaged(self, tables: Sequence[str] = ()) -> list[DamagedRow]:
        """Return every row that cannot be read, of some tables or of all."""
        with translate_driver_errors(self.url), Session(self.engine) as session, session.begin():
            return find_damaged(session, tables)

    @property
    def is_sqlite(self) -> bool:
        """Return whether this is an embedded database."""
        return self.engine.dialect.name == "sqlite"

    def dispose(self) -> None:
        """Close every connection."""
        self.engine.dispose()


def skip_damaged_rows(function: Callable[Concatenate[Database, P], T]) -> Callable[Concatenate[Database, P], T]:
    """Return a function on a database that excludes damaged rows instead of raising; the log names them."""

    @wraps(function)
    def go_on(database: Database, *args: P.args, **kwargs: P.kwargs) -> T:
        if time.monotonic() >= database.doubtful_until:
            try:
                return function(database, *args, **kwargs)
            except RowDamaged as error:
                log.warning("%s: %s They are left out.", error.code, error.message)
                database.doubtful_until = time.monotonic() + DOUBT_SECONDS
        return function(database.intact, *args, **kwargs)

    return cast(Callable[Concatenate[Database, P], T], go_on)


def open_database(settings: ServiceSettings, pooled: bool = True, is_upgraded: bool = False) -> Database:
    """Open the database of a home; create the tables of an empty SQLite file.

    Args:
        settings: Settings of the home.
        pooled: As for `Database`.
        is_upgraded: Upgrade an old database, and create the tables of an empty one of a server. Only `garmentq db
            upgrade` does so: workers and commands of an older version cannot use the database afterwards.

    Raises:
        DatabaseUnreachable: if it cannot be opened.
        DatabaseEmpty: if a server's database has no tables.
        DatabaseTooOld, DatabaseTooNew: if an older or a newer version created it.
    """
    try:
        make_private(settings.home)
        if not settings.database_url:  # SQLite would create it with the user's default permissions
            # Not an existing file: closing it would drop the locks of this process on it (POSIX).
            with suppress(FileExistsError):
                os.close(os.open(settings.home / "garmentq.db", os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600))
    except OSError as error:
        raise DatabaseUnreachable(f"the home folder {settings.home} cannot be created: {error.strerror}.") from error
    database = Database(settings.database, pooled)
    from ..migrations import HEAD

    try:
        with database.read() as session:
            current = read_revision(session.connection())
        if current is None and not is_upgraded and not database.is_sqlite:
            raise DatabaseEmpty()
        if current is not None and not is_upgraded and current < HEAD:
            raise DatabaseTooOld()
        if current != HEAD:
            with hold_lock(settings.home / "upgrade.lock"):
                upgrade(database)
    except BaseException:
        database.dispose()
        raise
    return database


def check_integrity(database: Database) -> None:
    """Check an SQLite file for invalid pages; a database server checks its own.

    Raises:
        DatabaseDamaged: if there are some.
    """
    if database.is_sqlite:
        with database.read() as session:
            found = str(session.execute(text("pragma quick_check(1)")).scalar())
        if found != "ok":
            raise DatabaseDamaged()


def take_advisory_lock(session: Session, key: str) -> None:
    """Block other transactions with the same key until this one ends.

    For "insert unless it exists": PostgreSQL lets two transactions read at the same time, and the second insert then
    fails. SQLite has one writer at a time, so nothing is done.
    """
    if session.connection().dialect.name == "postgresql":
        session.execute(text("select pg_advisory_xact_lock(hashtextextended(:key, 0))"), {"key": key})


def starts_with(column: Any, text: str) -> ColumnElement[bool]:
    """Return the condition that a value begins with a text, without LIKE's wildcards and SQLite's case folding."""
    return func.substr(column, 1, len(text)) == text


def change_rows(session: Session, statement: Update | Delete) -> int:
    """Run an UPDATE or DELETE, and return how many rows it changed; rows loaded in the session are not refreshed."""
    changed = session.execute(statement.execution_options(synchronize_session=False))
    return cast(CursorResult[Any], changed).rowcount


def read_revision(connection: Connection) -> str | None:
    """Return the database's current migration, or None for an empty one."""
    if not inspect(connection).has_table("alembic_version"):
        return None
    return connection.execute(text("select version_num from alembic_version")).scalar()


def upgrade(database: Database, revision: str = "head") -> None:
    """Run the migrations up to a revision."""
    from alembic import command
    from alembic.config import Config
    from alembic.util.exc import CommandError

    from .. import migrations

    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent).replace("%", "%%"))
    with database.write() as session:
        take_advisory_lock(session, "garmentq upgrade")  # two hosts may open a new database at the same time
        config.attributes["connection"] = session.connection()
        try:
            command.upgrade(config, revision)
        except CommandError as error:
            raise DatabaseTooNew() from error


def _make_engine(url: str, pooled: bool) -> Engine:
    try:
        parsed = make_url(url)
    except ArgumentError:
        raise ServiceSettingBad(
            "GARMENTQ_DATABASE_URL is not an address; write postgresql://USER:PASSWORD@HOST/DB."
        ) from None
    if "@" in (parsed.host or ""):
        raise ServiceSettingBad("the password in GARMENTQ_DATABASE_URL contains an '@'; write %40 for it.")
    options: dict[str, Any] = {} if pooled else {"poolclass": NullPool}
    if parsed.drivername in ("postgres", "postgresql", "postgresql+psycopg"):
        try:
            engine = create_engine(
                parsed.set(drivername="postgresql+psycopg"),
                pool_pre_ping=pooled,
                connect_args={"connect_timeout": DATABASE_CONNECT_TIMEOUT},
                **options,
            )
        except ImportError as error:
            raise DriverMissing() from error
        event.listen(engine, "before_cursor_execute", _refuse_text)
        return engine
    if parsed.get_backend_name() != "sqlite":
        raise ServiceSettingBad(f"GARMENTQ_DATABASE_URL names '{parsed.drivername}'; use sqlite or postgresql.")
    engine = create_engine(parsed, connect_args={"timeout": BUSY_SECONDS, "check_same_thread": False}, **options)
    event.listen(engine, "before_cursor_execute", _refuse_text)
    set_up_sqlite(engine)
    return engine


def _refuse_text(connection: Any, cursor: Any, statement: str, values: Any, context: Any, is_many: bool) -> None:
    """Refuse text that PostgreSQL cannot store, alike on both databases.

    Raises:
        TextBad: if the values of a statement contain such a text.
    """
    if has_unstorable_text(values):
        raise TextBad()


@contextmanager
def translate_driver_errors(url: str) -> Iterator[None]:
    """Convert a driver's errors within the block into our errors.

    Raises:
        DatabaseUnreachable, DatabaseDamaged: if the database does not respond, or its file is invalid.
    """
    try:
        yield
    except UnicodeDecodeError as error:  # the driver quotes a table's damaged definition
        raise _make_damage_error(url, "a table's definition is not text") from error
    except (DatabaseError, sqlite3.DatabaseError) as error:
        reason = (str(getattr(error, "orig", error)).strip().splitlines() or [""])[0]
        if DECODE_ERROR_TEXT in reason:
            raise RowDamaged(reason) from error
        code = getattr(getattr(error, "orig", error), "sqlite_errorcode", 0) & 0xFF  # without SQLite's extended code
        if code in DAMAGED_CODES or any(words in reason for words in DAMAGE_ERROR_TEXTS):
            raise _make_damage_error(url, reason) from error
        if not isinstance(error, OperationalError | sqlite3.OperationalError):
            raise
        raise DatabaseUnreachable(f"the database {hide_password(url)} does not respond: {reason}.") from error


def _make_damage_error(url: str, reason: str) -> DatabaseDamaged:
    return DatabaseDamaged(
        f"the database {hide_password(url)} is damaged ({reason}); `garmentq down`, keep the file aside, then "
        "`garmentq restore BACKUP.tar`, or run it on what `sqlite3 FILE .recover` saves."
    )
