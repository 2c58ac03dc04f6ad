"""One job in a pool child: claim it, run the pipeline on it, keep what it found."""

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
from pathlib import Path
from typing import Any

import numpy as np

from ..core.errors import BadInput, GarmentqError
from ..core.hooks import Arrays, Hooks
from ..core.recovery import Request
from ..core.settings import RecoverySettings
from ..service.database import Database
from ..service.jobs import Claim, FenceLost, claim, end_cancelled, fail, release, report
from ..service.results import load_checkpoint, save_checkpoint, store_recovery
from ..service.settings import ServiceSettings
from ..service.store import ArtifactDamaged, ArtifactMissing, Store
from .threads import limit_threads
from .watch import JobTooLong, Watch

log = logging.getLogger(__name__)

REPORT_SECONDS = 0.5
"""Shortest time between two progress events of one stage [s]; more often is not seen, and each is a row."""


def run_job(settings: ServiceSettings, database: Database, job: str, is_draining: Callable[[], bool]) -> str:
    """Work on one job if it can be claimed.

    Returns:
        What became of it: `unclaimed`, `succeeded`, `failed`, `cancelled`, `released` or `lost`.
    """
    if is_draining():
        return "unclaimed"  # the job stays queued, and another worker's reaper publishes it again
    owner = f"{socket.gethostname()}:{os.getpid()}:{uuid.uuid4().hex[:6]}"
    held = claim(database, job, owner, settings.lease_seconds)
    if held is None:
        return "unclaimed"
    log.info("job %s attempt %d starts", job, held.attempt)
    watch = Watch(database, held, settings.lease_seconds, settings.poll_seconds, settings.max_seconds, is_draining)
    try:
        with watch:
            outcome = _work(settings, database, held, watch)
    except FenceLost:
        outcome = "lost"
    log.info("job %s: %s", job, outcome)
    return outcome


def _work(settings: ServiceSettings, database: Database, held: Claim, watch: Watch) -> str:
    store = Store(settings.store_path)
    try:
        with work_folder(settings.home / "work", held.job) as folder:
            request = unpack_request(held, store, folder)
            limit_threads(settings.threads)
            recovery = settings.find("pipeline")(request, make_hooks(database, store, held, watch))
            files = folder / "result"
            files.mkdir()
            settings.find("writer")(recovery, files)
            if watch.reason in ("lost", "cancelled"):
                return _stop(database, held, watch.reason, settings.max_seconds)
            store_recovery(database, store, held, recovery, files)
        return "succeeded"
    except FenceLost:
        raise
    except BaseException as error:
        if watch.reason:
            return _stop(database, held, watch.reason, settings.max_seconds)
        if not isinstance(error, Exception):
            raise
        return _fail(database, held, error)


def _stop(database: Database, held: Claim, reason: str, seconds: float) -> str:
    """End an attempt that was told to stop."""
    if reason == "cancelled":
        end_cancelled(database, held)
    elif reason == "released":
        release(database, held)
    elif reason == "too_long":
        message = f"the job took longer than {seconds:g} s; use fewer --vertices, or raise GARMENTQ_MAX_SECONDS."
        fail(database, held, JobTooLong.code, message, bad_input=False)
        return "failed"
    return reason


def _fail(database: Database, held: Claim, error: Exception) -> str:
    if isinstance(error, GarmentqError):
        code, message = error.code, error.message
    else:
        code, message = (
            "job.crashed",
            f"{type(error).__name__}: {error}; this is a fault of garmentq, please report it.",
        )
    if not isinstance(error, BadInput):
        log.error("job %s failed:\n%s", held.job, "".join(traceback.format_exception(error)))
    fail(database, held, code, message.replace("\n", " ")[:2000], isinstance(error, BadInput))
    return "failed"


@contextmanager
def work_folder(root: Path, job: str) -> Iterator[Path]:
    """Give a job an empty folder for the block; what an attempt that was killed left behind is removed first."""
    root.mkdir(parents=True, exist_ok=True, mode=0o700)
    for left in root.glob(f"{job}-*"):
        shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=f"{job}-", dir=root, ignore_cleanup_errors=True) as folder:
        yield Path(folder)


def unpack_request(held: Claim, store: Store, folder: Path) -> Request:
    """Put a job's files into a folder under their own names, each in a folder of its own."""
    wanted = held.request

    def unpack(part: str) -> Path:
        kept = wanted[part]
        return store.copy(kept["sha256"], folder / part / kept["name"])

    return Request(
        scan=unpack("scan"),
        body=unpack("body") if isinstance(wanted["body"], dict) else wanted["body"],
        template=unpack("template") if wanted["template"] else None,
        settings=RecoverySettings(**wanted["settings"]),
        labels=unpack("labels") if wanted.get("labels") else None,
    )


def make_hooks(database: Database, store: Store, held: Claim, watch: Watch) -> Hooks:
    """Connect a pipeline's four calls to the job's row."""
    last: dict[str, Any] = {"stage": "", "at": 0.0}

    def on_progress(stage: str, fraction: float, message: str) -> None:
        now = time.monotonic()
        if stage == last["stage"] and fraction < 1.0 and now - last["at"] < REPORT_SECONDS:
            return
        last.update(stage=stage, at=now)
        report(database, held, stage, fraction, message)

    def save(name: str, arrays: Arrays) -> None:
        buffer = io.BytesIO()
        np.savez(buffer, **{key: np.asarray(value) for key, value in arrays.items()})  # type: ignore[arg-type]
        save_checkpoint(database, store, held, name, buffer.getvalue())

    def load(name: str) -> Arrays | None:
        try:
            content = load_checkpoint(database, store, held.job, name)
        except (ArtifactDamaged, ArtifactMissing):
            log.warning("job %s: checkpoint '%s' is damaged; its stage starts anew", held.job, name)
            return None
        if content is None:
            return None
        with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
            return {key: arrays[key] for key in arrays.files}

    return Hooks(on_progress, watch.must_stop, save, load)
