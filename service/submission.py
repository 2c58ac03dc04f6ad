"""From files on disk to a queued job: the files are kept, and one scan with the same settings is one job."""

from __future__ import annotations

import hashlib
import json
import re
import uuid
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sqlalchemy import select

from .. import __version__
from ..core.body import is_builtin
from ..core.errors import BadInput
from ..core.settings import RecoverySettings
from .database import Database, clock, serialise
from .jobs import NewJob, create, move
from .keys import check_quota, own
from .models import JobRow, ScanRow
from .states import QUEUES, UNSUCCESSFUL, State
from .store import Store, Stored


class BodyUnreadable(BadInput):
    """The body file cannot be read; give a mesh file, or --body builtin:female,height=1.70."""

    code = "body.unreadable"


@dataclass(frozen=True)
class Order:
    """Say what is to be recovered.

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
    """Keep the files, then add the job, its first event and its outbox row in one transaction.

    Raises:
        BodyMissing: where no body was named, and nothing says which part of the scan is the garment.
        StorageFull: where the files cannot be kept.
    """
    if order.body is None:
        _check_dressed(order)
    scan = store.put(order.scan)
    request = _describe(order, scan, store)
    nonce = (order.nonce or uuid.uuid4().hex) if order.force else ""
    dedup = _hash({"request": request, "version": __version__, "nonce": nonce})
    with database.write() as session:
        serialise(session, scan.sha256)  # equal orders at the same time are one job
        row = session.scalars(select(JobRow).where(JobRow.dedup == dedup).with_for_update()).one_or_none()
        if row is not None:
            own(session, order.key, row.id)
            if row.state in UNSUCCESSFUL:
                check_quota(session, order.key, order.quota)
                move(session, row, State.QUEUED, "resubmitted", payer=order.key)
            return Submitted(row.id, False, row.state)
        check_quota(session, order.key, order.quota)
        name = request["scan"]["name"]
        if session.get(ScanRow, scan.sha256) is None:
            session.add(ScanRow(sha256=scan.sha256, name=name, size=scan.size, created=clock()))
            session.flush()
        new = NewJob(dedup, scan.sha256, Path(name).stem, request, order.priority, order.queue, order.key)
        job = create(session, new)
        own(session, order.key, job)
    return Submitted(job, True, State.QUEUED)


def clean_name(name: str) -> str:
    """Give a file name without folders, control characters or anything a shell or a page could stumble over.

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
    body: dict[str, str] | str | None
    if order.body is None:
        body = None
    elif is_builtin(order.body):
        body = order.body
    else:
        body = _kept(Path(str(order.body)), store)
    template = _kept(order.template, store) if order.template else None
    if template is not None and order.settings.template:
        template["name"] = clean_name(f"{order.settings.template}.json")  # what the user calls an imported one
    labels = {"labels": _kept(order.labels, store)} if order.labels else {}
    return labels | {
        "scan": {"sha256": scan.sha256, "name": clean_name(order.scan.name)},
        "body": body,
        "template": template,
        "settings": order.settings.as_dict(),
    }


def _kept(path: Path, store: Store) -> dict[str, str]:
    try:
        return {"sha256": store.put(path).sha256, "name": clean_name(path.name)}
    except FileNotFoundError:
        raise BodyUnreadable(f"there is no file '{path}'.") from None


def _hash(value: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()
