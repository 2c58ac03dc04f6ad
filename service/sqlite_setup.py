"""How a connection to SQLite is set up: write-ahead log, foreign keys, and a transaction that waits for the writer."""

from __future__ import annotations

import sqlite3
import time
from typing import Any

from sqlalchemy import Connection, Engine, event

from .columns import add_functions

WRITE = "garmentq_write"
"""Name of the execution option that marks a writing transaction."""

BUSY_SECONDS = 30
"""Longest wait of SQLite for another writer [s]; a write takes milliseconds, so this outlasts any queue."""

WAL_SECONDS = 0.05
"""Pause between two attempts to enter the write-ahead log [s]: a connection opens or closes in less."""


def set_up_sqlite(engine: Engine) -> None:
    """Prepare each connection of an engine, and begin its transactions as the option `WRITE` says."""
    event.listen(engine, "connect", _prepare_sqlite)
    event.listen(engine, "begin", _begin_sqlite)


def _prepare_sqlite(connection: Any, record: Any) -> None:
    connection.isolation_level = None  # the driver starts no transaction of its own; `_begin_sqlite` does
    _enter_wal(connection)
    add_functions(connection)
    connection.execute("pragma foreign_keys = on")


def _enter_wal(connection: Any) -> None:
    """Turn the write-ahead log on; wait while another process opens or closes the log.

    SQLite reports that at once as locked, instead of waiting as it does for a writer.
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
