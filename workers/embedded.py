"""Start and stop the broker and the worker of an embedded home; both outlive the command that started them."""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..core.run.errors import GarmentqError
from ..service.lock import hold_lock, is_locked, take_lock
from ..service.settings import ServiceSettings
from .broker import run_folder, start_broker, stop_broker
from .detached import has_ended, kill_group, launch_or_kill
from .log_files import rotate_logs
from .threads import VARIABLES, count_cores

log = logging.getLogger(__name__)

KEEP_SECONDS = 5.0
"""Interval at which broker and worker are checked to be alive [s]."""

WORKER_START_TIMEOUT = 30.0
"""Time limit of the worker's start [s]; it takes about 1 s on an idle machine."""

GRACE_SECONDS = 20.0
"""Time for a worker to stop its jobs [s]; a stage checks several times a second whether it must stop."""


STOPPED = "stopped"
"""File that `garmentq down` creates: a waiting command must not restart what the user stopped."""

LOOK_SECONDS = 1.0
"""Longest time that another process may hold the lock only to check whether it is free [s]; in practice a few
microseconds."""


class StoppedByUser(GarmentqError):
    """`garmentq down` stopped the worker; the jobs stay queued, and `garmentq up` goes on with them."""

    code = "service.stopped"


class WorkerNotStarted(GarmentqError):
    """The worker did not start; see worker.log in the home folder."""

    code = "service.worker_not_started"


def ensure_services(settings: ServiceSettings, workers: int | None = None) -> list[str]:
    """Start the broker and the worker unless they run.

    Args:
        settings: Settings of the home.
        workers: Number of jobs at a time; None: one per core.

    Returns:
        What was started, `broker` and `worker`.

    Raises:
        BrokerUnreachable, WorkerNotStarted: if one of them does not start.
    """
    folder = run_folder(settings)
    (folder / STOPPED).unlink(missing_ok=True)
    started = ["broker"] if start_broker(settings) else []
    with hold_lock(folder / "start.lock"):
        if not is_locked(folder / "worker.lock"):
            _launch(settings, folder, workers or count_cores())
            started.append("worker")
    return started


@contextmanager
def keep_services_up(settings: ServiceSettings, workers: int | None = None) -> Iterator[None]:
    """Restart broker and worker if they die within the block, unless the user stopped them."""
    ended = threading.Event()

    def keep() -> None:
        while not ended.wait(KEEP_SECONDS):
            try:
                if not was_stopped(settings):
                    ensure_services(settings, workers)
            except GarmentqError as error:
                log.warning("%s", error)

    thread = threading.Thread(target=keep, name="keeping-up", daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def stop_services(settings: ServiceSettings) -> list[str]:
    """Stop the worker, whose jobs return to the queue, then the broker.

    Returns:
        What was stopped.
    """
    (run_folder(settings) / STOPPED).touch()
    stopped = ["worker"] if _stop_worker(settings) else []
    if stop_broker(settings):
        stopped.append("broker")
    return stopped


def was_stopped(settings: ServiceSettings) -> bool:
    """Return whether a user stopped the services and they have not been started since."""
    return (run_folder(settings) / STOPPED).exists()


def is_worker_up(settings: ServiceSettings) -> bool:
    """Return whether the embedded worker of a home runs on this machine."""
    return is_locked(run_folder(settings) / "worker.lock")


def hold_worker_lock(settings: ServiceSettings) -> int | None:
    """Take the lock of a home's embedded worker and write its pid file; return None if another worker has the lock."""
    folder = run_folder(settings)
    deadline = time.monotonic() + LOOK_SECONDS
    while (lock := take_lock(folder / "worker.lock")) is None and time.monotonic() < deadline:
        time.sleep(0.01)
    if lock is not None:
        (folder / "worker.pid").write_text(f"{os.getpid()}\n")
    return lock


def _launch(settings: ServiceSettings, folder: Path, workers: int) -> None:
    """Start a worker process and wait until it has taken its lock."""
    environment = {**os.environ, **settings.as_environment(), **dict.fromkeys(VARIABLES, str(settings.threads))}
    command = [sys.executable, "-m", "garmentq.cli.main", "worker", "--embedded", "--workers", str(workers)]
    deadline = time.monotonic() + WORKER_START_TIMEOUT
    rotate_logs(settings)
    with launch_or_kill(command, settings.home / "worker.log", environment) as process:
        while time.monotonic() < deadline and not has_ended(process):
            if is_locked(folder / "worker.lock"):
                return
            time.sleep(0.05)
        raise WorkerNotStarted(f"the worker did not start; see {settings.home / 'worker.log'}.")


def _stop_worker(settings: ServiceSettings) -> bool:
    folder = run_folder(settings)
    lock = folder / "worker.lock"
    if not is_locked(lock):
        return False
    pid = int((folder / "worker.pid").read_text())
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGTERM)
    deadline = time.monotonic() + GRACE_SECONDS
    while is_locked(lock) and time.monotonic() < deadline:
        time.sleep(0.05)
    if is_locked(lock):
        kill_group(pid)
    (folder / "worker.pid").unlink(missing_ok=True)
    return True
