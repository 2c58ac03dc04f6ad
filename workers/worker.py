"""The Celery worker: child processes run the jobs; the parent's event loop runs the dispatcher and the reaper.

Both are timers of the event loop, not threads: a fork beside a running thread could copy a locked lock.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import resource
import signal
import socket
import sys
import time
import uuid
import warnings
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from billiard.exceptions import TimeLimitExceeded, WorkerLostError
from celery import Celery, bootsteps, signals
from celery.apps.worker import install_worker_term_handler
from celery.platforms import SecurityWarning

from ..core.run.errors import GarmentqError
from ..service.audit import forget_accesses
from ..service.clocks import ClockJumpGuard, clamp_future_times, read_clock
from ..service.database import Database, DatabaseUnreachable, open_database
from ..service.event_counts import settle_event_counts
from ..service.families import release_waiting_jobs
from ..service.home import use_home
from ..service.logs import set_up_logs
from ..service.preemption import preempt
from ..service.reaper import (
    DISPATCHER_LEASE,
    FORGET_SECONDS,
    LEADER_LEASE_TIME,
    acquire_leader_lease,
    dispatch,
    is_idle,
    reap,
    record_heartbeat,
    release_leader_lease,
    release_lost_leases,
    remove_worker,
    republish_stalled_jobs,
)
from ..service.retention import enforce_retention
from ..service.settings import ServiceSettings
from ..service.states import QUEUES
from ..service.stores import open_store
from ..service.webhooks import forget_messages, has_due
from .alive import Kept, end_heartbeat, renew_heartbeat
from .app import CHANNELS, TASK, count_messages, make_app, publish
from .courier import start_courier
from .detached import end_group, has_ended
from .log_files import rotate_logs
from .messages import MessageGuard
from .quiet import QuietQueue
from .recovery import run_job
from .threads import limit_threads

log = logging.getLogger(__name__)

LIFE_SECONDS = 5.0
"""Interval between a worker's heartbeats [s]."""

ROUNDS_PER_LEASE = 2
"""Number of rounds of a quiet queue in the shorter of the leader lease and a job's lease: one may be late by a half."""

IDLE_CHECK_SECONDS = 5.0
"""Longest interval between the checks whether an embedded worker is idle and may stop [s]."""

RETENTION_PAUSE = 5.0
"""Pause between two deletions while the retention of more families is over [s]: the dispatcher goes on between them."""

FORGET_OLD_SECONDS = 3600.0
"""Interval at which old rows of the audit log and of sent messages are deleted [s]; rows are kept for days."""


class DispatcherStep(bootsteps.StartStopStep):
    """Run dispatcher and reaper in the parent's event loop while this worker has the leader lease."""

    requires = ("celery.worker.components:Timer", "celery.worker.components:Pool")

    def start(self, parent: Any) -> None:
        """Start the timers."""
        self.settings: ServiceSettings = parent.app.garmentq_settings
        # closed after each round: no connection is open where a child is forked
        self.database = Database(self.settings.database)
        self.quiet = QuietQueue(self.database, min(LEADER_LEASE_TIME, self.settings.lease_seconds) / ROUNDS_PER_LEASE)
        self.name = f"{socket.gethostname()}:{os.getpid()}:{uuid.uuid4().hex[:6]}"
        self.app = parent.app
        self.rounds = parent.timer.call_repeatedly(self.settings.poll_seconds, self._round)
        # A dying child's pipe closes a moment before the system reports its end; Celery would check again after 5 s.
        parent.timer.call_repeatedly(self.settings.poll_seconds, parent.pool.maintain_pool)
        self.last_heartbeat, self.last_purge, self.next_round = 0.0, -FORGET_OLD_SECONDS, 0.0
        self.last_sign, self.has_log_file = -LIFE_SECONDS, parent.app.garmentq_is_embedded
        self.courier: int | None = None
        self.clock_guard = ClockJumpGuard(self.settings.lease_seconds)
        self.started = time.monotonic()
        if parent.app.garmentq_is_embedded and self.settings.idle_seconds:
            period = min(IDLE_CHECK_SECONDS, self.settings.idle_seconds)
            parent.timer.call_repeatedly(period, self._exit_if_idle)

    def stop(self, parent: Any) -> None:
        """Release the leader lease at once; the parent's timers continue while its children finish."""
        log.info("stopping: running jobs return to the queue at their next step")
        self.rounds.cancel()
        if self.courier is not None and not has_ended(self.courier):
            end_group(self.courier)  # messages that it has not sent stay pending
        try:
            remove_worker(self.database, self.name)
            release_leader_lease(self.database, DISPATCHER_LEASE, self.name)
        except GarmentqError as error:
            log.warning("the leader lease could not be released: %s", error)
        finally:
            self.database.dispose()

    def _round(self) -> None:
        """Renew the leases, and do the dispatcher's duties, unless nothing can have come up since the last round."""
        if time.monotonic() - self.last_sign > LIFE_SECONDS:
            self.last_sign = time.monotonic()
            with suppress(OSError):  # a full disk is reported by the jobs
                renew_heartbeat(self.settings, Kept.WORKER)
            if self.has_log_file:
                rotate_logs(self.settings)
        if time.monotonic() < self.next_round or not self.quiet.is_over():
            return
        try:
            is_leader = self._renew_leases()
            if not is_leader:  # another worker dispatches; it is replaced within a lease and a half
                self.next_round = time.monotonic() + LEADER_LEASE_TIME / ROUNDS_PER_LEASE
            if self.quiet.begin() and is_leader:
                self._do_duties()
        except DatabaseUnreachable as error:
            self.clock_guard.note_outage()
            log.warning("a round of the dispatcher failed: %s", error)
        except Exception as error:  # the next round tries again; the loop must never end
            log.warning("a round of the dispatcher failed: %s: %s", type(error).__name__, error)
        finally:
            self.database.dispose()

    def _renew_leases(self) -> bool:
        """Send a heartbeat, if it is time; return whether this worker has the leader lease."""
        if time.monotonic() - self.last_heartbeat > LIFE_SECONDS:
            queues, concurrency = self.app.garmentq_strength
            record_heartbeat(self.database, self.name, queues, concurrency, FORGET_SECONDS)
            self.last_heartbeat = time.monotonic()
        if not acquire_leader_lease(self.database, DISPATCHER_LEASE, self.name, LEADER_LEASE_TIME):
            return False
        clamp_future_times(self.database)
        self.clock_guard.note(read_clock(self.database))
        if time.monotonic() - self.last_purge > FORGET_OLD_SECONDS:
            self.last_purge = time.monotonic()
            if enforce_retention(self.database, open_store(self.settings), self.settings):
                self.last_purge += RETENTION_PAUSE - FORGET_OLD_SECONDS  # there is more to delete
            forget_accesses(self.database)
            forget_messages(self.database)
            settle_event_counts(self.database)
        return True

    def _do_duties(self) -> None:
        if self.clock_guard.is_steady:
            reap(self.database, self.settings.max_attempts, self.settings.lease_seconds)
        release_waiting_jobs(self.database)
        republish_stalled_jobs(self.database, self.settings.republish_seconds, lambda: count_messages(self.app) == 0)
        preempt(self.database)
        dispatch(self.database, lambda job, queue: publish(self.app, job, queue))
        self._send_messages()

    def _send_messages(self) -> None:
        """Start a courier if webhook messages are due and none runs, unless a separate courier sends them."""
        if self.settings.send_messages and (self.courier is None or has_ended(self.courier)) and has_due(self.database):
            self.courier = start_courier(self.settings, dict(os.environ))

    def _exit_if_idle(self) -> None:
        """Stop an embedded worker after `idle_seconds` without a job, counted from its start at the earliest."""
        if time.monotonic() - self.started < self.settings.idle_seconds:
            return
        try:
            if is_idle(self.database, self.settings.idle_seconds):
                log.info("no job for %g s: this worker stops", self.settings.idle_seconds)
                os.kill(os.getpid(), signal.SIGTERM)
        except GarmentqError as error:
            log.warning("%s", error)
        finally:
            self.database.dispose()


def run_worker(
    settings: ServiceSettings, concurrency: int, lock: int | None = None, queues: Sequence[str] = QUEUES
) -> int:
    """Run a worker in this process until SIGTERM, SIGHUP or SIGINT; further signals have no effect.

    Args:
        settings: Settings of the home.
        concurrency: Number of child processes, each with one job at a time.
        lock: Descriptor of the embedded worker's lock; such a worker stops after `idle_seconds` without a job.
        queues: The queues of jobs that it serves.

    Returns:
        Exit status.
    """
    in_use = use_home(settings)
    set_up_logs(bool(settings.log_json))
    # Running as root is safe here: only JSON is accepted, so a message can only start a job.
    warnings.simplefilter("ignore", SecurityWarning)
    limit_threads(settings.threads)
    open_database(settings, pooled=False).dispose()
    app = make_app(settings)
    app.garmentq_settings = settings
    app.garmentq_strength = (",".join(queues), concurrency)
    app.garmentq_is_embedded = lock is not None
    draining = multiprocessing.RawValue("b", 0)
    _register(app, settings, draining, lock)
    app.steps["worker"].add(DispatcherStep)
    app.steps["consumer"].add(MessageGuard)
    worker = _make_worker(
        app,
        hostname=f"garmentq-{os.getpid()}@{socket.gethostname()}",
        pool_cls="prefork",
        concurrency=concurrency,
        loglevel="INFO",
        queues=[CHANNELS[name] for name in queues],
        quiet=True,
        without_gossip=True,
        without_mingle=True,
    )
    try:
        worker.start()
    finally:
        end_heartbeat(settings, Kept.WORKER)
        os.close(in_use)
    return int(worker.exitcode or 0)


def _make_worker(app: Celery, **options: Any) -> Any:
    """Return a worker that stops gracefully on each stop signal, however often it comes.

    Celery's own worker aborts its jobs at the second SIGINT, and restarts itself at a SIGHUP.
    """

    class Worker(app.Worker):
        """Stop gracefully on SIGTERM, SIGINT and SIGHUP."""

        def install_platform_tweaks(self, worker: Any) -> None:
            """Handle SIGINT and SIGHUP as SIGTERM; an ignored SIGHUP stays ignored (nohup)."""
            is_kept = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            super().install_platform_tweaks(worker)
            install_worker_term_handler(worker, verbose=False)  # it would print a line that is not of the log
            stop = signal.getsignal(signal.SIGTERM)
            signal.signal(signal.SIGINT, stop)
            signal.signal(signal.SIGHUP, signal.SIG_IGN if is_kept else stop)

    return Worker(**options)


def limit_job_memory(megabytes: int) -> None:
    """Limit the memory that this process may allocate; mapped libraries and child processes do not count."""
    if megabytes and sys.platform == "linux":
        hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
        limit = megabytes * 10**6
        soft = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


def _ignore_signal(number: int, frame: object) -> None:
    """Do nothing; unlike SIG_IGN, this handler is not inherited by a program that is started."""


def _register(app: Celery, settings: ServiceSettings, draining: Any, lock: int | None) -> None:
    """Add the task and the initialisation of a child; `draining` is memory that parent and children share."""
    state: dict[str, Database] = {}

    @app.task(name=TASK, ignore_result=True, bind=True)
    def recover(task: Any, job: str) -> str:
        for number in (signal.SIGTERM, signal.SIGHUP):  # sent to a whole unit or terminal; the parent stops us
            signal.signal(number, _ignore_signal)
        return run_job(settings, state["database"], job, lambda: bool(draining.value), task.request.id)

    @signals.task_failure.connect(weak=False)
    def release_leases(task_id: str = "", exception: Any = None, **_: Any) -> None:
        if not isinstance(exception, WorkerLostError | TimeLimitExceeded):
            return
        database = Database(settings.database, pooled=False)
        try:
            release_lost_leases(database, task_id, str(exception))
        except GarmentqError as error:
            log.warning("%s; the lease must run out", error)
        finally:
            database.dispose()

    @signals.worker_process_init.connect(weak=False)
    def begin(**_: Any) -> None:
        if lock is not None:
            os.close(lock)  # a child that outlives a killed parent must not pass for a running worker
        limit_threads(settings.threads)
        limit_job_memory(settings.job_memory_mb)
        state["database"] = Database(settings.database)

    @signals.worker_shutting_down.connect(weak=False)
    def drain(**_: Any) -> None:
        draining.value = 1
