"""From files on disk to a queued job: the files are kept, and one scan with the same settings is one job."""

from __future__ import annotations

import hashlib
import json
import re
import unicodedata
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from .. import __version__
from ..core.body import is_builtin
from ..core.errors import BadInput
from ..core.settings import RecoverySettings
from .database import Database, clock, serialise
from .families import share, try_again
from .jobs import JobUnknown, create
from .keys import check_quota, own
from .kinds import FileRef, pack_request
from .kinds.recover import Recover, RecoverRequest
from .models import JobRow, OwnerRow, ScanRow
from .new_job import NewJob
from .states import QUEUES, UNSUCCESSFUL, State
from .store import Store, Stored


class BodyUnreadable(BadInput):
    """The body file cannot be read; give a mesh file, or --body builtin:female,height=1.70."""

    code = "body.unreadable"


class LabelBad(BadInput):
    """A name has at most 255 printable letters, each of at most 20 tags from 1 to 64; choose shorter ones."""

    code = "order.label_bad"


class InputNotEnded(BadInput):
    """The job whose result is to be read has none; wait until it has succeeded."""

    code = "job.input_not_ended"


LONGEST_NAME, LONGEST_TAG, MOST_TAGS = 255, 64, 20
"""Bounds of what a user calls a family; the longest name is the column's."""

SIGNS = "._-()+,"
"""What a file's own name keeps beside letters and digits: nothing that a page, a shell or a spreadsheet understands."""


@dataclass(frozen=True)
class Order:
    """Describe what is to be recovered.

    Attributes:
        scan: The garment's file.
        body: The wearer's file, or a text that begins with `builtin:`.
        template: A pattern file, or None.
        settings: Everything else.
        priority: Larger goes first.
        force: Make a new job even where an equal one exists.
        labels: A file with one label per vertex of a dressed person's scan, or None.
        queue: One of `QUEUES`: which kind of worker takes it.
        nonce: What makes a forced job the same when it is asked for again; empty: a random one.
        key: Id of the API key that asks, or empty; the job is then that key's too.
        quota: Jobs that the key may have queued at a time.
        name: What the family is called; empty: after the scan's file.
        tags: Words that it can be found by.
    """

    scan: Path
    body: Path | str | None
    template: Path | None = None
    settings: RecoverySettings = field(default_factory=RecoverySettings)
    priority: int = 0
    force: bool = False
    labels: Path | None = None
    queue: str = QUEUES[0]
    nonce: str = ""
    key: str = ""
    quota: int = 0
    name: str = ""
    tags: tuple[str, ...] = ()


@dataclass(frozen=True)
class JobRequest:
    """Ask for one job of any kind; its files are in the store.

    Attributes:
        kind: Name of the kind.
        request: What `pack_request` makes of the kind's request.
        scan: Key and cleaned name of the file that the family's work goes back to; of a job that only reads results,
            that of an input.
        name: What it is called; empty: after the file.
        tags: Words that it can be found by.
        inputs: Ids of the jobs whose results it reads, by the name of the folder in which it finds them.
        priority: Larger goes first.
        queue: One of `QUEUES`.
        nonce: Makes it another job than an equal one without it.
        key: Id of the API key that asks, or empty.
        quota: Jobs that the key may have open at a time.
    """

    kind: str
    request: dict[str, Any]
    scan: str
    name: str = ""
    tags: tuple[str, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)
    priority: int = 0
    queue: str = QUEUES[0]
    nonce: str = ""
    key: str = ""
    quota: int = 0


@dataclass(frozen=True)
class Submitted:
    """Answer a submission.

    Attributes:
        job: The job's id.
        is_new: False where an equal job existed; it is queued again if it had ended without success.
        state: The job's state now.
    """

    job: str
    is_new: bool
    state: State


def submit(database: Database, store: Store, order: Order) -> Submitted:
    """Keep the files, then ask for the recovery.

    Raises:
        BodyMissing: where no body was named, and nothing says which part of the scan is the garment.
        LabelBad: where name or tags cannot be used.
        StorageFull: where the files cannot be kept.
    """
    if order.body is None:
        _check_dressed(order)
    check_labels(order.name, order.tags)
    scan = store.put(order.scan)
    request = _describe(order, scan, store)
    with database.write() as session:
        serialise(session, scan.sha256)
        if session.get(ScanRow, scan.sha256) is None:
            name = request["scan"]["name"]
            session.add(ScanRow(sha256=scan.sha256, name=name, size=scan.size, created=clock()))
            session.flush()
        nonce = (order.nonce or uuid.uuid4().hex) if order.force else ""
        wanted = JobRequest(
            Recover.name,
            request,
            scan.sha256,
            order.name or own_name(order.scan.name),
            order.tags,
            priority=order.priority,
            queue=order.queue,
            nonce=nonce,
            key=order.key,
            quota=order.quota,
        )
        return add_job(session, wanted)


def add_job(session: Session, wanted: JobRequest) -> Submitted:
    """Add a job, its first event and its outbox row; an equal job is that job, tried again if it did not succeed.

    Raises:
        JobUnknown: where a job to be read is none that the key may see.
        InputNotEnded: where a job to be read has no result.
        QueueFull: where the key has as many open jobs as it may.
    """
    for job in wanted.inputs.values():  # first, or an equal job would show what its inputs hold to whoever names them
        _check_input(session, job, wanted.key)
    dedup = _hash(wanted)
    serialise(session, dedup)  # equal orders at the same time are one job
    row = session.scalars(select(JobRow).where(JobRow.dedup == dedup).with_for_update()).one_or_none()
    if row is not None:
        if row.state in UNSUCCESSFUL:
            try_again(session, [row], "resubmitted", wanted.key, wanted.quota)
        share(session, wanted.key, row)  # after the quota: a new owner's row holds the key's, which the quota locks
        return Submitted(row.id, False, row.state)
    check_quota(session, wanted.key, wanted.quota)
    columns = ("kind", "request", "scan", "name", "priority", "queue", "tags", "inputs")
    new = NewJob(dedup, payer=wanted.key, **{name: getattr(wanted, name) for name in columns})
    made = create(session, new)
    own(session, wanted.key, made.id)
    return Submitted(made.id, True, made.state)


def check_labels(name: str, tags: Sequence[str]) -> None:
    """Check what a user calls a family.

    Raises:
        LabelBad: where it cannot be used.
    """
    is_bad = len(name) > LONGEST_NAME or not name.isprintable() or len(set(tags)) > MOST_TAGS
    if is_bad or any(not 0 < len(tag) <= LONGEST_TAG or not tag.isprintable() for tag in tags):
        raise LabelBad()


def own_name(file: str) -> str:
    """Return a file's own name for people to read: the letters, marks and digits of any script, and harmless signs."""
    kept = (c if unicodedata.category(c)[0] in "LMN" or c in SIGNS else " " for c in Path(file).stem)
    return " ".join("".join(kept).split())[:LONGEST_NAME] or "scan"


def clean_name(name: str) -> str:
    """Return a file name without folders, control characters or anything a shell or a page could stumble over.

    It begins neither with a dot nor, like an option, with a dash.
    """
    return re.sub(r"[^A-Za-z0-9._-]+", "_", Path(name).name)[-100:].lstrip(".-") or "file"


def _check_dressed(order: Order) -> None:
    from ..core.body import BodyMissing
    from ..core.recovery import make_selection

    if make_selection(order.labels, order.settings) is None:
        raise BodyMissing()


def _describe(order: Order, scan: Stored, store: Store) -> dict[str, Any]:
    """Describe an order by hashes only, so that the same files elsewhere are the same order."""
    body: FileRef | str | None = order.body if is_builtin(order.body) else None
    if order.body is not None and body is None:
        body = _kept(Path(order.body), store)
    template = _kept(order.template, store) if order.template else None
    if template is not None and order.settings.template:  # what the user calls an imported one
        template = replace(template, name=clean_name(f"{order.settings.template}.json"))
    labels = _kept(order.labels, store) if order.labels else None
    file = FileRef(scan.sha256, clean_name(order.scan.name))
    return pack_request(RecoverRequest(file, body, template, order.settings, labels))


def _kept(path: Path, store: Store) -> FileRef:
    try:
        return FileRef(store.put(path).sha256, clean_name(path.name))
    except FileNotFoundError:
        raise BodyUnreadable(f"there is no file '{path}'.") from None


def _check_input(session: Session, job: str, key: str) -> None:
    """Refuse a job without a result, and one that the key does not own: to it that one is as unknown as none."""
    row = session.get(JobRow, job)
    if row is None or (key and session.get(OwnerRow, (key, job)) is None):
        raise JobUnknown(f"there is no job '{job[:40]}'; `garmentq status` lists them all.")
    if row.state != State.SUCCEEDED:
        raise InputNotEnded(f"job {job} is {row.state}; its result can be read once it has succeeded.")


def _hash(wanted: JobRequest) -> str:
    """Return what makes a job the same as another: what is computed, not what it is called."""
    value: dict[str, Any] = {"request": wanted.request, "version": __version__, "nonce": wanted.nonce}
    if wanted.kind != Recover.name:
        value["kind"] = wanted.kind
    if wanted.inputs:
        value["inputs"] = dict(wanted.inputs)
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()
