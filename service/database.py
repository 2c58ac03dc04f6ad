"""The database: how to reach it, its clock, and its two kinds of transaction."""

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
from .columns import RowDamaged, add_functions
from .damage import DamagedRow, SoundSession, describe_damaged_rows, find_damaged
from .lock import hold_lock
from .private import make_private
from .settings import ServiceSettingBad, ServiceSettings, hide_password

log = logging.getLogger(__name__)

P = ParamSpec("P")
T = TypeVar("T")

WRITE = "garmentq_write"
"""Name of the execution option that marks a transaction as one that writes."""

DATABASE_CONNECT_TIMEOUT = 10
"""Time limit for PostgreSQL to accept a connection [s]; a server in another town takes a fraction of a second."""

BUSY_SECONDS = 30
"""How long SQLite waits for another writer [s]; a write here takes milliseconds, so this outlasts any queue of them."""

DECODE_ERROR_TEXT = "Could not decode to UTF-8"
"""What the driver says of a text that is none."""

DAMAGE_ERROR_TEXTS = (
    "malformed", "file is not a database", "unsupported file format", "no such table", "no such column",
)  # fmt: skip
"""What SQLite says of a file whose bytes changed; the tables of another version are told before any question."""

DAMAGED_CODES = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_FORMAT)
"""How it classes them, whatever it says."""

DOUBT_SECONDS = 60.0
"""How long damaged rows that were met once are left out without another try [s]: each is a look through a table."""

WAL_SECONDS = 0.05
"""Pause between two tries to enter the write-ahead log [s]: a connection opens or closes in less."""


class DatabaseUnreachable(Unavailable):
    """The database cannot be reached; check GARMENTQ_DATABASE_URL or the rights on the home folder."""

    code = "service.database_unreachable"


class DatabaseDamaged(DatabaseUnreachable):
    """The database file is damaged; `garmentq down`, keep the file aside, then `garmentq restore BACKUP.tar`."""

    code = "service.database_damaged"


class DatabaseTooNew(GarmentqError):
    """The database was made by a newer garmentq; upgrade this one, or use another --home."""

    code = "service.database_too_new"


class DatabaseTooOld(GarmentqError):
    """The database was made by an older garmentq; stop its workers, save it, then run `garmentq db upgrade`."""

    code = "service.database_too_old"


class DriverMissing(GarmentqError):
    """The package that speaks to this database is missing; pip install 'garmentq[postgres]'."""

    code = "service.driver_missing"


class clock(FunctionElement[float]):
    """Return the database's own time [s since 1970], so that no worker's clock matters."""

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
    """Hand out transactions. One object per process: never carry it over a fork.

    A transaction that comes to a value which its column cannot hold ends with `RowDamaged`, which names table and key.

    Attributes:
        url: SQLAlchemy address.
        engine: The connections.
        sound: The same database as if its damaged rows were not there; `skip_damaged_rows` asks it.
        doubtful_until: Until when `sound` is asked at once [s, monotonic].
    """

    def __init__(self, url: str, pooled: bool = True) -> None:
        """Prepare an engine; nothing is opened before the first transaction.

        Args:
            url: SQLAlchemy address.
            pooled: Keep connections open between transactions. False in a process that forks.
        """
        self.url = url
        self.engine = _make_engine(url, pooled)
        self._writer = self.engine.execution_options(**{WRITE: True})
        self._session: type[Session] = Session
        self.doubtful_until = -math.inf
        self.sound = copy(self)
        self.sound.sound, self.sound._session, self.sound.doubtful_until = self.sound, SoundSession, math.inf

    @contextmanager
    def read(self) -> Iterator[Session]:
        """Open a session that only reads."""
        with self._open(self.engine) as session:
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
        """Return whether this is the embedded kind of database."""
        return self.engine.dialect.name == "sqlite"

    def dispose(self) -> None:
        """Close every connection."""
        self.engine.dispose()


def skip_damaged_rows(ask: Callable[Concatenate[Database, P], T]) -> Callable[Concatenate[Database, P], T]:
    """Make a question to a database, or a change of it, go on past damaged rows; the log names them."""

    @wraps(ask)
    def go_on(database: Database, *args: P.args, **kwargs: P.kwargs) -> T:
        if time.monotonic() >= database.doubtful_until:
            try:
                return ask(database, *args, **kwargs)
            except RowDamaged as error:
                log.warning("%s: %s They are left out.", error.code, error.message)
                database.doubtful_until = time.monotonic() + DOUBT_SECONDS
        return ask(database.sound, *args, **kwargs)

    return cast(Callable[Concatenate[Database, P], T], go_on)


def open_database(settings: ServiceSettings, pooled: bool = True, is_upgraded: bool = False) -> Database:
    """Open the database of a home; where it is empty its tables are made.

    Args:
        settings: Which home.
        pooled: As for `Database`.
        is_upgraded: Bring an old one up to date. That is said by `garmentq db upgrade` alone: the workers and commands
            of an older version cannot use the database afterwards.

    Raises:
        DatabaseUnreachable: where it cannot be opened.
        DatabaseTooOld, DatabaseTooNew: where an older or a newer version made it.
    """
    try:
        make_private(settings.home)
        if not settings.database_url:  # SQLite would make it with the rights that the user's files have
            # Never one that is there: to close it would drop the locks that this process holds on it (POSIX).
            with suppress(FileExistsError):
                os.close(os.open(settings.home / "garmentq.db", os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600))
    except OSError as error:
        raise DatabaseUnreachable(f"the home folder {settings.home} cannot be made: {error.strerror}.") from error
    database = Database(settings.database, pooled)
    from ..migrations import HEAD

    try:
        with database.read() as session:
            current = read_revision(session.connection())
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
    """Look through an SQLite file for pages that cannot be; a server looks after its own.

    Raises:
        DatabaseDamaged: where there are some.
    """
    if database.is_sqlite:
        with database.read() as session:
            found = str(session.execute(text("pragma quick_check(1)")).scalar())
        if found != "ok":
            raise DatabaseDamaged()


def take_advisory_lock(session: Session, key: str) -> None:
    """Block other transactions with the same key from here until this one ends.

    For "insert it unless it is there": PostgreSQL lets two transactions look at the same time, and the second insert
    then fails. SQLite has one writer at a time, so there is nothing to do.
    """
    if session.connection().dialect.name == "postgresql":
        session.execute(text("select pg_advisory_xact_lock(hashtextextended(:key, 0))"), {"key": key})


def starts_with(column: Any, text: str) -> ColumnElement[bool]:
    """Return the condition of a value that begins with a text; unlike LIKE it knows no signs and, on SQLite, case."""
    return func.substr(column, 1, len(text)) == text


def change_rows(session: Session, statement: Update | Delete) -> int:
    """Run an UPDATE or DELETE, and return how many rows it touched; rows that the session holds are not refreshed."""
    changed = session.execute(statement.execution_options(synchronize_session=False))
    return cast(CursorResult[Any], changed).rowcount


def read_revision(connection: Connection) -> str | None:
    """Return the migration that the database stands at, or None for an empty one."""
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
            "GARMENTQ_DATABASE_URL is no address; write postgresql://USER:PASSWORD@HOST/DB."
        ) from None
    if "@" in (parsed.host or ""):
        raise ServiceSettingBad("the password in GARMENTQ_DATABASE_URL holds an '@'; write %40 for it.")
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
    event.listen(engine, "connect", _prepare_sqlite)
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def _refuse_text(connection: Any, cursor: Any, statement: str, values: Any, context: Any, is_many: bool) -> None:
    """Refuse what PostgreSQL refuses of a text by an error of its own, and SQLite in part; alike on both.

    Raises:
        TextBad: where there is such a text among the values of a statement.
    """
    if has_unstorable_text(values):
        raise TextBad()


def _prepare_sqlite(connection: Any, record: Any) -> None:
    connection.isolation_level = None  # the driver starts no transaction of its own; `_begin_sqlite` does
    _enter_wal(connection)
    add_functions(connection)
    connection.execute("pragma foreign_keys = on")


def _enter_wal(connection: Any) -> None:
    """Turn the write-ahead log on; where another process opens or leaves the log just then, wait for it.

    SQLite refuses that at once as locked, instead of waiting as it does for a writer.
    """
    deadline = time.monotonic() + BUSY_SECONDS
    while True:
        try:
            connection.execute("pragma journal_mode = wal")
            return
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > deadline:
                raise
            time.sleep(WAL_SECONDS)


def _begin_sqlite(connection: Connection) -> None:
    write = connection.get_execution_options().get(WRITE, False)
    connection.exec_driver_sql("begin immediate" if write else "begin")


@contextmanager
def translate_driver_errors(url: str) -> Iterator[None]:
    """Turn what a driver raises within the block into our errors.

    Raises:
        DatabaseUnreachable, DatabaseDamaged: where the database does not answer, or its file is none any more.
    """
    try:
        yield
    except UnicodeDecodeError as error:  # the driver quotes a table's definition that is no text any more
        raise _make_damage_error(url, "a table's definition is no text") from error
    except (DatabaseError, sqlite3.DatabaseError) as error:
        reason = (str(getattr(error, "orig", error)).strip().splitlines() or [""])[0]
        if DECODE_ERROR_TEXT in reason:
            raise RowDamaged(reason) from error
        code = getattr(getattr(error, "orig", error), "sqlite_errorcode", 0) & 0xFF  # without SQLite's further classes
        if code in DAMAGED_CODES or any(words in reason for words in DAMAGE_ERROR_TEXTS):
            raise _make_damage_error(url, reason) from error
        if not isinstance(error, OperationalError | sqlite3.OperationalError):
            raise
        raise DatabaseUnreachable(f"the database {hide_password(url)} does not answer: {reason}.") from error


def _make_damage_error(url: str, reason: str) -> DatabaseDamaged:
    return DatabaseDamaged(
        f"the database {hide_password(url)} is damaged ({reason}); `garmentq down`, keep the file aside, then "
        "`garmentq restore BACKUP.tar`, or run it on what `sqlite3 FILE .recover` saves."
    )
