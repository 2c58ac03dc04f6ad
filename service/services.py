"""An open home: its settings, its database and its store."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from .database import Database, open_database
from .private import make_private
from .settings import ServiceSettings
from .store import Store, check_room
from .stores import open_store


@dataclass(frozen=True)
class Services:
    """Describe the parts of an open home.

    Attributes:
        settings: Settings of the home.
        database: Its database.
        store: Its files.
    """

    settings: ServiceSettings
    database: Database
    store: Store

    @property
    def incoming(self) -> Path:
        """Return the folder of unfinished transfers."""
        return self.settings.home / "incoming"

    @contextmanager
    def copying(self) -> Iterator[Path]:
        """Yield a folder for copies of stored files, which is deleted after the block.

        Raises:
            StorageFull: if the disk has less room than `free_bytes`.
        """
        folder = make_private(self.incoming)
        check_room(folder, self.settings.free_bytes)
        with tempfile.TemporaryDirectory(dir=folder) as made:
            yield Path(made)


def open_services(settings: ServiceSettings, pooled: bool = True) -> Services:
    """Open a home; its database is created if it is missing.

    Raises:
        DatabaseUnreachable: if the database cannot be opened.
        DatabaseTooOld, DatabaseTooNew: if an older or a newer version created it.
    """
    return Services(settings, open_database(settings, pooled), open_store(settings))
