"""Behaviour of a worker during an outage: it claims no job without a store, and retries a write until it succeeds."""

from __future__ import annotations

import logging
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

from ..core.run.errors import GarmentqError, Unavailable
from ..service.database import Database, DatabaseUnreachable
from ..service.outage import MAX_OUTAGE_PAUSE, end_outages, find_outage, find_pause, note_outage
from ..service.settings import ServiceSettings
from ..service.store import Store
from .watch import LeaseKeeper

log = logging.getLogger(__name__)

T = TypeVar("T")

AWAY_SECONDS = 0.2
"""Pause between two attempts to reach an unavailable database or store, and between two checks whether to stop [s]."""

MAX_STORE_CHECK_PAUSE = 30.0
"""Longest pause between two checks of the store [s]: the longest delay of the queue after the store is back."""


def wait_for_store(
    settings: ServiceSettings, database: Database, store: Store, is_draining: Callable[[], bool]
) -> bool:
    """Wait until the store responds and has room: without a store a worker would only take jobs that others could do.

    Returns:
        False if the store stays unavailable, or the worker is to stop; the wake-up is then published again.
    """
    deadline, tries = time.monotonic() + MAX_OUTAGE_PAUSE, 0
    while not is_draining() and time.monotonic() < deadline:
        try:
            store.check(settings.free_bytes)
            end_outages(database, socket.gethostname())
            return True
        except Unavailable as error:
            log.warning("no job is started: %s", error)
            _report_outage(database, error)
        pause, tries = min(MAX_STORE_CHECK_PAUSE, find_pause(settings.pause_seconds, tries)), tries + 1
        until = time.monotonic() + pause
        while time.monotonic() < until and not is_draining():
            time.sleep(AWAY_SECONDS)
    return False


def persist(write: Callable[[], T], watch: LeaseKeeper) -> T:
    """Repeat a write while database or store is unavailable, and return its result.

    An unavailable database is waited for as long as the job may run: afterwards the fence shows whether the job is
    still this worker's. The store is waited for a few minutes; then the job returns to the queue and resumes from its
    last checkpoint.

    Raises:
        Unavailable: if the outage lasts longer, or the job must stop.
        FenceLost: if another worker has taken the job over.
    """
    deadline, reported = time.monotonic() + MAX_OUTAGE_PAUSE, ""
    while True:
        try:
            done = write()
        except Exception as error:
            outage = find_outage(error)
            is_patient = isinstance(outage, DatabaseUnreachable) or time.monotonic() < deadline
            if outage is None or watch.reason or not is_patient:
                raise
            if outage.code != reported:
                log.warning("a write waits: %s", outage)
                reported = _report_outage(watch.database, outage)
        else:
            if reported:
                end_outages(watch.database, socket.gethostname())
            return done
        time.sleep(AWAY_SECONDS)


def _report_outage(database: Database, outage: Unavailable) -> str:
    """Record for other hosts, if possible, what this host waits for; return the outage's code."""
    if not isinstance(outage, DatabaseUnreachable):
        with suppress(GarmentqError):
            note_outage(database, socket.gethostname(), outage.code)
    return outage.code


@contextmanager
def tolerate_outage(job: str, note: dict[str, Any]) -> Iterator[None]:
    """Continue without a report or checkpoint during an outage; the lease keeper limits its duration.

    Args:
        job: The job's id.
        note: Fields of the log line.
    """
    try:
        yield
    except Exception as error:
        if find_outage(error) is None:
            raise
        log.warning("job %s continues: %s", job, error, extra=note)
