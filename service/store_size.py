"""The size of all stored files, sampled: a sum over every row, which a scrape need not wait for."""

from __future__ import annotations

import logging
import shutil
import threading
import time

from sqlalchemy import func, select, union

from ..core.run.errors import GarmentqError
from .database import Database, skip_damaged_rows
from .exposition import Labelled, format_family
from .models import ArtifactRow, ScanRow, UploadRow
from .settings import ServiceSettings

log = logging.getLogger(__name__)

SAMPLE_SECONDS = 3600.0
"""Interval between two sums [s]: with 800 000 rows one takes seconds, and a disk fills in days."""


@skip_damaged_rows
def sum_store_size(database: Database) -> int:
    """Return the size of all files that rows name [bytes], each counted once."""
    named = union(*(select(table.sha256, table.size) for table in (ArtifactRow, UploadRow, ScanRow))).subquery()
    with database.read() as session:
        return int(session.scalar(select(func.sum(named.c.size))) or 0)


class StoreSize:
    """Report the size of the stored files and the room that is left for more."""

    def __init__(self, database: Database, settings: ServiceSettings) -> None:
        """Prepare the first sample; nothing is read before the first report.

        Args:
            database: The database whose rows name the files.
            settings: Settings of the home.
        """
        self._database = database
        self._settings = settings
        self._size: int | None = None
        self._next = 0.0
        self._lock = threading.Lock()

    def format_metrics(self) -> str:
        """Return the metrics: the size as sampled last, and the free space of a folder's disk now.

        The first report has no size yet; a bucket has no free space.
        """
        self._sample_if_due()
        sizes: list[Labelled] = [] if self._size is None else [({}, float(self._size))]
        return "".join(
            [
                format_family("store_bytes", "gauge", "Stored files that rows name, sampled once an hour.", sizes),
                format_family("store_free_bytes", "gauge", "Free space of the store's disk.", self._measure_free()),
            ]
        )

    def _measure_free(self) -> list[Labelled]:
        if self._settings.is_store_remote:
            return []
        try:
            return [({}, float(shutil.disk_usage(self._settings.store_path).free))]
        except OSError:
            return []

    def _sample_if_due(self) -> None:
        with self._lock:
            if time.monotonic() < self._next:
                return
            self._next = time.monotonic() + SAMPLE_SECONDS
        threading.Thread(target=self._sample, name="store-size", daemon=True).start()

    def _sample(self) -> None:
        try:
            self._size = sum_store_size(self._database)
        except GarmentqError as error:
            log.warning("the size of the store is unknown: %s", error)
            self._next = 0.0
