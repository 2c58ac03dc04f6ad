"""One job in a child process of the pool: claim it, run its kind, store its result."""

from __future__ import annotations

import io
import logging
import os
import shutil
import socket
import tempfile
import time
import traceback
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..core.run.errors import BadInput, Cancelled, GarmentqError, Unavailable
from ..core.run.hooks import Arrays, Hooks
from ..core.run.sandbox import is_memory_short
from ..service.checking import STAGE, check_files
from ..service.columns import RowDamaged
from ..service.database import Database, DatabaseUnreachable
from ..service.jobs import Claim, FenceLost, claim_next, end_cancelled, fail
from ..service.kinds import Kind, KindChange, RunContext, find_files, find_kind, read_request
from ..service.late_claims import return_attempt
from ..service.outage import find_outage, note_outage
from ..service.private import make_private
from ..service.progress import Pace, ProgressEstimator, learn_pace, report
from ..service.requeueing import PREEMPTED_EVENT, give_way, release, reschedule
from ..service.results import CHECKPOINT, PREVIOUS, export_files, load_checkpoint, save_checkpoint, store_result
from ..service.services import Services
from ..service.settings import ServiceSettings
from ..service.shown_errors import is_service_error, show_message
from ..service.states import State
from ..service.store import ArtifactDamaged, ArtifactMissing, Store
from ..service.stores import open_store
from ..service.understanding import change_kind, note_checked
from .patience import persist, tolerate_outage, wait_for_store
from .threads import limit_threads
from .watch import JobInterrupted, JobTooLong, LeaseKeeper

log = logging.getLogger(__name__)

REPORT_SECONDS = 0.5
"""Shortest time between two progress events of one stage [s]; each event is a row of the database."""

MEMORY = "job.out_of_memory"
"""Code of a job that exceeded the memory limit of its process."""

FORCED_EXIT_STATUS = 75
"""Exit status of a child process that ended before its job did; EX_TEMPFAIL of sysexits.h."""


def run_job(
    settings: ServiceSettings, database: Database, wakeup: str, is_draining: Callable[[], bool], mark: str = ""
) -> str:
    """Claim and run the most urgent job of the queue of a wake-up's job, if there is one.

    Args:
        settings: Settings of the home.
        database: The jobs' database.
        wakeup: The job id in the broker's message.
        is_draining: Returns whether this worker must stop.
        mark: End of the owner's name, by which the parent finds the claim of a dead child.

    Returns:
        The outcome: `unclaimed`, `succeeded`, `failed`, `cancelled`, `released`, `preempted`, `put_off` or `lost`.
    """
    if is_draining():
        return "unclaimed"  # the job stays queued, and another worker's reaper publishes it again
    owner = f"{socket.gethostname()}:{os.getpid()}:{mark or uuid.uuid4().hex}"
    store = open_store(settings, must_exist=True)
    try:
        ready = wait_for_store(settings, database, store, is_draining)
        claim = claim_next(database, wakeup, owner, settings.lease_seconds) if ready else None
    except (DatabaseUnreachable, RowDamaged) as error:
        log.warning("no job is started: %s", error)
        claim = None
    if claim is None:
        return "unclaimed"
    note = make_note(claim)
    log.info("job %s attempt %d starts", claim.job, claim.attempt, extra=note)

    def force(reason: str) -> None:
        """End this process, whose job does not stop; its work since the last checkpoint is lost."""
        log.warning("job %s does not stop (%s): its process ends", claim.job, reason, extra=note)
        try:
            _stop(database, claim, reason, settings.max_seconds)
        except GarmentqError as error:
            log.warning("%s", error, extra=note)
        finally:
            os._exit(FORCED_EXIT_STATUS)

    times = (settings.lease_seconds, settings.poll_seconds, settings.max_seconds)
    watch = LeaseKeeper(database, claim, *times, is_draining, settings.grace_seconds, force)
    try:
        with watch:
            outcome = _work(Services(settings, database, store), claim, watch)
    except FenceLost:
        outcome = _stop(database, claim, "lost", settings.max_seconds)
    except (DatabaseUnreachable, RowDamaged) as error:
        outcome = "lost"
        log.warning("job %s: %s", claim.job, error, extra=note)
    log.info("job %s: %s", claim.job, outcome, extra=note)
    return outcome


def make_note(claim: Claim, stage: str = "") -> dict[str, Any]:
    """Return the fields of a structured log line."""
    return {"job": claim.job, "attempt": claim.attempt, "stage": stage}


def _work(services: Services, claim: Claim, watch: LeaseKeeper) -> str:
    settings, database, store = services.settings, services.database, services.store
    try:
        with work_folder(settings.home / "work", claim.job) as folder:
            limit_threads(settings.threads)
            kind, request, work, turned = _begin(services, claim, watch, folder / "1")
            if turned is not None:
                claim = persist(partial(change_kind, database, claim, turned.kind, turned.request), watch)
                kind, request, work, _ = _begin(services, claim, watch, folder / "2")
            pace = learn_pace(database, claim.kind, claim.request, kind.stages)
            result = kind.run(request, work, make_hooks(database, store, claim, watch, pace))
            watch.note_computed()
            if watch.reason in ("lost", "cancelled"):
                watch.end()
                return _stop(database, claim, watch.reason, settings.max_seconds)
            return persist(partial(store_result, database, store, claim, kind, result, work.out), watch)
    except FenceLost:
        raise
    except BaseException as error:
        if watch.reason:
            watch.end()
            return _stop(database, claim, watch.reason, settings.max_seconds)
        if isinstance(error, Cancelled | JobInterrupted) and watch.must_stop():
            watch.end()
            persist(partial(give_way, database, claim), watch)
            return PREEMPTED_EVENT
        if not isinstance(error, Exception) or isinstance(error, DatabaseUnreachable):
            raise
        if (outage := find_outage(error)) is not None:
            return _reschedule(settings, database, claim, outage, watch)
        persist(partial(_fail, database, claim, error), watch)
        return State.FAILED


def _begin(
    services: Services, claim: Claim, watch: LeaseKeeper, folder: Path
) -> tuple[Kind, Any, RunContext, KindChange | None]:
    """Copy and check a job's files, and find whether they belong to another kind."""
    settings, database = services.settings, services.database
    kind = find_kind(settings, claim.kind)
    request = read_request(kind.request, claim.request)
    work = unpack(services, claim, folder, kind, request)
    hooks = make_hooks(database, services.store, claim, watch)
    if work.files.is_dir() and (checker := kind.checker(settings)):
        hooks.progress(STAGE, 0.0, "reading and checking the files")
        found = check_files(checker, claim.request, work.files, hooks.is_cancelled)
        persist(partial(note_checked, database, claim, found), watch)
    return kind, request, work, kind.turn(request, work, hooks)


def _stop(database: Database, claim: Claim, reason: str, seconds: float) -> str:
    """End an attempt that must stop."""
    if reason == "cancelled":
        end_cancelled(database, claim)
    elif reason == "released":
        release(database, claim)
    elif reason == "lost":
        with tolerate_outage(claim.job, make_note(claim)):
            return_attempt(database, claim)
    elif reason == "too_long":
        message = (
            f"the job took longer than {seconds:g} s; use fewer --vertices or a shorter motion, "
            "or raise GARMENTQ_MAX_SECONDS."
        )
        fail(database, claim, JobTooLong.code, message, bad_input=False)
        return State.FAILED
    return reason


def _reschedule(
    settings: ServiceSettings, database: Database, claim: Claim, outage: Unavailable, watch: LeaseKeeper
) -> str:
    """Return a job that met an outage to the queue, and record the outage for the display of workers."""
    log.warning("job %s is rescheduled: %s", claim.job, outage, extra=make_note(claim))
    persist(partial(note_outage, database, socket.gethostname(), outage.code), watch)
    persist(partial(reschedule, database, claim, outage, settings.pause_seconds), watch)
    return "put_off"


def _fail(database: Database, claim: Claim, error: BaseException) -> None:
    if isinstance(error, GarmentqError):
        code, message = error.code, show_message(error)
    elif is_memory_short(error):
        code = MEMORY
        message = "the job needs more memory than GARMENTQ_JOB_MEMORY_MB; use fewer --vertices, or raise it."
    else:
        code, message = (
            "job.crashed",
            f"{type(error).__name__}: a fault of garmentq; please report it with the worker's log.",
        )
    if not isinstance(error, BadInput) or is_service_error(error):
        log.error("job %s failed:\n%s", claim.job, "".join(traceback.format_exception(error)), extra=make_note(claim))
    fail(database, claim, code, message, isinstance(error, BadInput))


@contextmanager
def work_folder(root: Path, job: str) -> Iterator[Path]:
    """Yield an empty folder for a job; what a killed attempt left behind is removed first."""
    make_private(root)
    for left in root.glob(f"{job}-*"):
        shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=f"{job}-", dir=root, ignore_cleanup_errors=True) as folder:
        yield Path(folder)


def unpack(services: Services, claim: Claim, folder: Path, kind: Kind, request: Any) -> RunContext:
    """Copy a job's files, each into a folder of its own, and the results of other jobs that it reads.

    Raises:
        ResultMissing: if a job that is read has no result.
    """
    work = RunContext(services.settings, folder / "files", {}, folder / "result")
    work.out.mkdir(parents=True)
    for field, file in find_files(claim.request):
        services.store.copy(file.sha256, work.files / field / file.name)
    inputs = {name: folder / "inputs" / str(number) for number, name in enumerate(claim.inputs)}
    for name, place in inputs.items():
        names = kind.choose_input(request, name)
        export_files(services.database, services.store, claim.inputs[name], place, names)
    return replace(work, inputs=inputs)


def make_hooks(database: Database, store: Store, claim: Claim, watch: LeaseKeeper, pace: Pace = Pace()) -> Hooks:  # noqa: B008
    """Return hooks that write progress and checkpoints to the job's row; `pace` estimates the overall progress."""
    pacer = ProgressEstimator(pace)
    last: dict[str, Any] = {"stage": "", "at": 0.0}

    def on_progress(stage: str, fraction: float, message: str) -> None:
        now = time.monotonic()
        if stage == last["stage"] and fraction < 1.0 and now - last["at"] < REPORT_SECONDS:
            return
        last.update(stage=stage, at=now)
        log.debug("job %s: %s %.2f", claim.job, stage, fraction, extra=make_note(claim, stage))
        with tolerate_outage(claim.job, make_note(claim, stage)):
            report(database, claim, pacer.note(stage, fraction, message))

    def save(name: str, arrays: Arrays) -> None:
        buffer = io.BytesIO()
        np.savez(buffer, **{key: np.asarray(value) for key, value in arrays.items()})  # type: ignore[arg-type]
        with tolerate_outage(claim.job, make_note(claim, last["stage"])):
            save_checkpoint(database, store, claim, name, buffer.getvalue())
            watch.note_checkpoint()

    def load(name: str) -> Arrays | None:
        for kind in (CHECKPOINT, PREVIOUS):
            try:
                content = load_checkpoint(database, store, claim.job, name, kind)
            except (ArtifactDamaged, ArtifactMissing):
                log.warning("job %s: %s '%s' is damaged", claim.job, kind, name, extra=make_note(claim, last["stage"]))
                continue
            if content is not None:
                with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
                    return {key: arrays[key] for key in arrays.files}
        return None

    return Hooks(on_progress, watch.must_stop, save, load)
