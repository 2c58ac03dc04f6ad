"""Whether a queue is quiet: no job is open, no message is owed, and nothing was written since that was seen.

A round of the dispatcher takes a dozen transactions. While the queue is quiet, it waits for a change: of an embedded
database by its files, of a server's by one query.
"""

from __future__ import annotations

import os
import time
from contextlib import suppress

from ..core.run.errors import GarmentqError
from ..service.database import Database
from ..service.pending import has_work

FileStamp = tuple[tuple[int, int, int], ...]
"""Index, size [bytes] and time of the last write [ns] of each file of an SQLite database."""


class QuietQueue:
    """Find out when a quiet queue needs another round of the dispatcher."""

    def __init__(self, database: Database, longest: float) -> None:
        """Begin with a queue that is not quiet.

        Args:
            database: The jobs' database.
            longest: Longest time between two rounds [s], in which leases are renewed.
        """
        self._database = database
        self._longest = longest
        self._until = 0.0
        self._stamp: FileStamp = ()

    def begin(self) -> bool:
        """Return whether there is work; if there is none, the queue is quiet from now on.

        The files are looked at before the tables: whatever is written afterwards, they differ from then on. Connections
        are closed before, because the last one to be closed writes the log into the file.

        Raises:
            DatabaseUnreachable: if the database does not respond.
        """
        self._until, now = 0.0, time.monotonic()
        self._database.dispose()
        self._stamp = self._read_stamp()
        if has_work(self._database):
            return True
        self._until = now + self._longest
        return False

    def is_over(self) -> bool:
        """Return whether another round is due: there was work, time is up, or something was written."""
        if time.monotonic() >= self._until:
            return True
        if self._database.is_sqlite:
            return self._read_stamp() != self._stamp
        try:
            return has_work(self._database)
        except GarmentqError:
            return True
        finally:
            self._database.dispose()

    def _read_stamp(self) -> FileStamp:
        path, found = self._database.engine.url.database or "", []
        for file in (path, f"{path}-wal") if self._database.is_sqlite else ():
            with suppress(FileNotFoundError):
                state = os.stat(file)
                found.append((state.st_ino, state.st_size, state.st_mtime_ns))
        return tuple(found)
