"""The tables. Times are seconds since 1970 by the database's clock; everything physical is SI."""

from __future__ import annotations

from typing import Any

from sqlalchemy import ForeignKey, Index, false, text
from sqlalchemy.orm import Mapped, mapped_column

from .columns import SERIAL, Whole, Words
from .model_base import Base
from .share_models import ShareRow as ShareRow
from .states import State
from .subject_models import BatchRow as BatchRow
from .subject_models import SubjectJobRow as SubjectJobRow
from .subject_models import SubjectRow as SubjectRow
from .webhook_models import DeliveryRow as DeliveryRow
from .webhook_models import WebhookRow as WebhookRow


class ScanRow(Base):
    """Store one uploaded file by the hash of its bytes."""

    __tablename__ = "scans"
    sha256: Mapped[str] = mapped_column(Words(64), primary_key=True)
    name: Mapped[str] = mapped_column(Words(255))
    size: Mapped[int] = mapped_column(Whole(is_big=True))
    created: Mapped[float]
    details: Mapped[dict[str, Any]] = mapped_column(default=dict)


LISTED_FIELDS = (
    "name", "kind", "state", "version", "error_code", "verdict", "garment", "template", "fabric", "body", "method",
    "preset", "started", "finished", "attempts", "priority", "cpu_seconds", "peak_mb",
)  # fmt: skip
"""Columns of a job by which lists are filtered and sorted, besides `created`: each has an index, so that a page of a
hundred thousand jobs is read in its order."""


class JobRow(Base):
    """Store one job and the claim on it; only `jobs.py` changes a state.

    `family` is the id of the root, its own for a root; `scan` is the file from which the family's work derives.
    `method` and `preset` repeat what the request says, `garment` to `peak_mb` what the rows of the result say.
    """

    __tablename__ = "jobs"
    __table_args__ = (
        Index(
            "ix_jobs_urgency",
            "state",
            "queue",
            "lane",
            text("priority DESC"),
            "payer",
            "family_created",
            "created",
            "id",
        ),
        Index("ix_jobs_lease_until", "lease_until"),
        Index("ix_jobs_created", "created"),
        Index("ix_jobs_payer_state", "payer", "state"),
        Index("ix_jobs_family", "family"),
        Index("ix_jobs_parent_created", "parent", "created", "id"),
        Index("ix_jobs_state_finished", "state", "finished"),
        *(Index(f"ix_jobs_{name}_created", name, "created", "id") for name in LISTED_FIELDS),
    )
    id: Mapped[str] = mapped_column(Words(16), primary_key=True)
    dedup: Mapped[str] = mapped_column(Words(64), unique=True)
    scan: Mapped[str] = mapped_column(ForeignKey("scans.sha256"), index=True)
    name: Mapped[str] = mapped_column(Words(255))
    request: Mapped[dict[str, Any]]
    kind: Mapped[str] = mapped_column(Words(32), default="recover", server_default="recover")
    parent: Mapped[str | None] = mapped_column(ForeignKey("jobs.id"))
    family: Mapped[str] = mapped_column(Words(16), default="", server_default="")
    version: Mapped[str] = mapped_column(Words(32))
    priority: Mapped[int] = mapped_column(default=0)
    queue: Mapped[str] = mapped_column(Words(16), default="cpu", server_default="cpu")
    payer: Mapped[str] = mapped_column(Words(16), default="", server_default="")
    lane: Mapped[int] = mapped_column(default=2, server_default="2")
    family_created: Mapped[float] = mapped_column(default=0.0, server_default="0")
    state: Mapped[State]
    cancel: Mapped[bool] = mapped_column(default=False)
    preempt: Mapped[bool] = mapped_column(default=False, server_default=false())
    preemptions: Mapped[int] = mapped_column(default=0, server_default="0")
    attempts: Mapped[int] = mapped_column(default=0)
    fence: Mapped[int] = mapped_column(default=0)
    owner: Mapped[str | None] = mapped_column(Words(255))
    lease_until: Mapped[float | None]
    touched: Mapped[float]
    created: Mapped[float]
    started: Mapped[float | None]
    finished: Mapped[float | None]
    stage: Mapped[str] = mapped_column(Words(32), default="")
    progress: Mapped[float] = mapped_column(default=0.0)
    overall: Mapped[float] = mapped_column(default=0.0, server_default="0")
    expected_end: Mapped[float | None]
    error_code: Mapped[str | None] = mapped_column(Words(64))
    error_message: Mapped[str | None] = mapped_column(Words())
    bad_input: Mapped[bool] = mapped_column(default=False)
    verdict: Mapped[str | None] = mapped_column(Words(16))
    delays: Mapped[int] = mapped_column(default=0, server_default="0")
    delay_code: Mapped[str | None] = mapped_column(Words(64))
    not_before: Mapped[float | None]
    result: Mapped[dict[str, Any] | None]
    checked: Mapped[dict[str, Any] | None]
    method: Mapped[str | None] = mapped_column(Words(32))
    preset: Mapped[str | None] = mapped_column(Words(32))
    garment: Mapped[str | None] = mapped_column(Words(32))
    template: Mapped[str | None] = mapped_column(Words(255))
    fabric: Mapped[str | None] = mapped_column(Words(64))
    body: Mapped[str | None] = mapped_column(Words(255))
    cpu_seconds: Mapped[float | None]
    peak_mb: Mapped[float | None]


class JobFileRow(Base):
    """Store a stored file that a job's request names."""

    __tablename__ = "job_files"
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    sha256: Mapped[str] = mapped_column(Words(64), primary_key=True, index=True)


class JobInputRow(Base):
    """Store an ended job whose result a job reads; it is never rerun or cancelled with its readers."""

    __tablename__ = "job_inputs"
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    name: Mapped[str] = mapped_column(Words(64), primary_key=True)
    input: Mapped[str] = mapped_column(ForeignKey("jobs.id"), index=True)


class JobWaitRow(Base):
    """Store a sibling that must have succeeded before a job begins."""

    __tablename__ = "job_waits"
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    awaited: Mapped[str] = mapped_column(ForeignKey("jobs.id"), primary_key=True, index=True)


class JobTagRow(Base):
    """Store one tag of a family; each job of the family has it."""

    __tablename__ = "job_tags"
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    tag: Mapped[str] = mapped_column(Words(64), primary_key=True, index=True)


class EventRow(Base):
    """Store one event of a job; rows are only added."""

    __tablename__ = "events"
    id: Mapped[int] = mapped_column(SERIAL, primary_key=True, autoincrement=True)
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), index=True)
    at: Mapped[float]
    kind: Mapped[str] = mapped_column(Words(32))
    data: Mapped[dict[str, Any]] = mapped_column(default=dict)


class EventCountRow(Base):
    """Store the number of events of a kind up to one; that one's id is the number of the kind `COUNTED_TO`.

    Events that were counted stay so when their jobs are deleted.
    """

    __tablename__ = "event_counts"
    kind: Mapped[str] = mapped_column(Words(32), primary_key=True)
    number: Mapped[int] = mapped_column(Whole(is_big=True))


class OutboxRow(Base):
    """Store one wake-up for the broker; deleted only after it was published."""

    __tablename__ = "outbox"
    id: Mapped[int] = mapped_column(SERIAL, primary_key=True, autoincrement=True)
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), index=True)
    created: Mapped[float]


class LockRow(Base):
    """Assign a leader lease to one process at a time, for as long as it renews the lease."""

    __tablename__ = "locks"
    name: Mapped[str] = mapped_column(Words(32), primary_key=True)
    owner: Mapped[str] = mapped_column(Words(255))
    until: Mapped[float]


class OutageRow(Base):
    """Store what a host's workers wait for, by its error's code; `seen` is renewed while they wait."""

    __tablename__ = "outages"
    place: Mapped[str] = mapped_column(Words(255), primary_key=True)
    code: Mapped[str] = mapped_column(Words(64), primary_key=True)
    since: Mapped[float]
    seen: Mapped[float]


class PayerRow(Base):
    """Store when a job of a payer (an API key, or empty) was claimed last: the one served longest ago is next."""

    __tablename__ = "payers"
    payer: Mapped[str] = mapped_column(Words(16), primary_key=True)
    served: Mapped[float]


class WorkerRow(Base):
    """Store one live worker, by its parent process; `seen` is renewed at each heartbeat."""

    __tablename__ = "workers"
    name: Mapped[str] = mapped_column(Words(255), primary_key=True)
    queues: Mapped[str] = mapped_column(Words(64))
    concurrency: Mapped[int]
    started: Mapped[float]
    seen: Mapped[float]


class TemplateRow(Base):
    """Store one imported template."""

    __tablename__ = "templates"
    name: Mapped[str] = mapped_column(Words(64), primary_key=True)
    sha256: Mapped[str] = mapped_column(Words(64))
    category: Mapped[str] = mapped_column(Words(32), default="")
    panels: Mapped[int] = mapped_column(default=0)
    created: Mapped[float]


class FabricRow(Base):
    """Store one imported fabric: its parameters in SI units with their sources, as JSON values."""

    __tablename__ = "fabrics"
    name: Mapped[str] = mapped_column(Words(64), primary_key=True)
    fabric: Mapped[dict[str, Any]]
    created: Mapped[float]


class MaterialRow(Base):
    """Store one fabric as it was used: H [N/m], k [N m], density [kg/m2], thickness [m]."""

    __tablename__ = "materials"
    id: Mapped[str] = mapped_column(Words(64), primary_key=True)
    name: Mapped[str] = mapped_column(Words(64), index=True)
    title: Mapped[str] = mapped_column(Words(255), default="")
    H00: Mapped[float]
    H01: Mapped[float]
    H11: Mapped[float]
    H22: Mapped[float]
    k: Mapped[float]
    density: Mapped[float]
    thickness: Mapped[float]
    friction: Mapped[float]
    sources: Mapped[list[Any]] = mapped_column(default=list)


class BodyRow(Base):
    """Store one wearer as a job estimated it: joints [m] by SMPL name and the fitted model's parameters."""

    __tablename__ = "bodies"
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    source: Mapped[str] = mapped_column(Words(255))
    fit_rms: Mapped[float]
    joints: Mapped[dict[str, Any]] = mapped_column(default=dict)
    parameters: Mapped[dict[str, Any]] = mapped_column(default=dict)


class PatternRow(Base):
    """Store the pattern that a job recovered."""

    __tablename__ = "patterns"
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    name: Mapped[str] = mapped_column(Words(255))
    category: Mapped[str] = mapped_column(Words(32), index=True)
    template: Mapped[str] = mapped_column(Words(255))
    material: Mapped[str] = mapped_column(ForeignKey("materials.id"))
    seams: Mapped[int]


class PanelRow(Base):
    """Store one panel: control points [m] and edges as the pattern has them, area of its polygon [m2]."""

    __tablename__ = "panels"
    job: Mapped[str] = mapped_column(ForeignKey("patterns.job", ondelete="CASCADE"), primary_key=True)
    name: Mapped[str] = mapped_column(Words(255), primary_key=True)
    label: Mapped[str] = mapped_column(Words(255), default="")
    points: Mapped[list[Any]]
    edges: Mapped[list[Any]]
    area: Mapped[float]


class PieceRow(Base):
    """Store the numbers of one production piece: sew line [m], area within the cut line and of all copies [m2]."""

    __tablename__ = "pieces"
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    name: Mapped[str] = mapped_column(Words(32), primary_key=True)
    quantity: Mapped[int]
    is_pair: Mapped[bool]
    is_folded: Mapped[bool]
    perimeter: Mapped[float]
    area: Mapped[float]
    cloth: Mapped[float]
    notches: Mapped[int]


class ArtifactRow(Base):
    """Store the name of one file of a job: a result, or a checkpoint."""

    __tablename__ = "artifacts"
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    kind: Mapped[str] = mapped_column(Words(16), primary_key=True)
    name: Mapped[str] = mapped_column(Words(255), primary_key=True)
    sha256: Mapped[str] = mapped_column(Words(64), index=True)
    size: Mapped[int] = mapped_column(Whole(is_big=True))
    created: Mapped[float]


class MetricRow(Base):
    """Store one metric of a result under its dotted name; None where it does not apply."""

    __tablename__ = "metrics"
    __table_args__ = (Index("ix_metrics_name_value", "name", "value"),)
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True)
    name: Mapped[str] = mapped_column(Words(128), primary_key=True)
    value: Mapped[float | None]


class ApiKeyRow(Base):
    """Store one API key by the hash of its token; a token is shown once. `earlier_hash` is that of the one before."""

    __tablename__ = "api_keys"
    id: Mapped[str] = mapped_column(Words(16), primary_key=True)
    name: Mapped[str] = mapped_column(Words(255))
    hash: Mapped[str] = mapped_column(Words(64), unique=True)
    scopes: Mapped[list[Any]]
    quota: Mapped[int]
    created: Mapped[float]
    revoked: Mapped[float | None]
    priority: Mapped[int] = mapped_column(default=0, server_default="0")
    expires: Mapped[float | None]
    used: Mapped[float | None]
    earlier_hash: Mapped[str | None] = mapped_column(Words(64), index=True)
    earlier_until: Mapped[float | None]


class AuditRow(Base):
    """Store one request that changed or downloaded something over HTTP; rows are only added."""

    __tablename__ = "audit"
    id: Mapped[int] = mapped_column(SERIAL, primary_key=True, autoincrement=True)
    at: Mapped[float] = mapped_column(index=True)
    key: Mapped[str] = mapped_column(Words(16))
    action: Mapped[str] = mapped_column(Words(32))
    subject: Mapped[str] = mapped_column(Words(255))
    address: Mapped[str] = mapped_column(Words(64))
    request: Mapped[str] = mapped_column(Words(64))


class SessionRow(Base):
    """Store a browser's session, or a link that begins one, by its token's hash; `key` is empty for the local user."""

    __tablename__ = "sessions"
    hash: Mapped[str] = mapped_column(Words(64), primary_key=True)
    key: Mapped[str] = mapped_column(Words(16))
    is_link: Mapped[bool] = mapped_column(default=False)
    created: Mapped[float]
    expires: Mapped[float] = mapped_column(index=True)


class OwnerRow(Base):
    """Store a key that submitted a job and may see it; equal jobs of several keys are one job that each sees."""

    __tablename__ = "owners"
    key: Mapped[str] = mapped_column(ForeignKey("api_keys.id", ondelete="CASCADE"), primary_key=True)
    job: Mapped[str] = mapped_column(ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=True, index=True)


class UploadRow(Base):
    """Store a file that a key (empty: no key) uploaded and may use, with the name that it gave."""

    __tablename__ = "uploads"
    key: Mapped[str] = mapped_column(Words(16), primary_key=True)
    sha256: Mapped[str] = mapped_column(Words(64), primary_key=True, index=True)
    name: Mapped[str] = mapped_column(Words(255))
    size: Mapped[int] = mapped_column(Whole(is_big=True))
    created: Mapped[float]
    kinds: Mapped[list[Any]] = mapped_column(default=list, server_default="[]")


class IdempotencyRow(Base):
    """Store the request for which a client used an Idempotency-Key."""

    __tablename__ = "idempotency"
    key: Mapped[str] = mapped_column(Words(16), primary_key=True)
    token: Mapped[str] = mapped_column(Words(128), primary_key=True)
    fingerprint: Mapped[str] = mapped_column(Words(64))
    job: Mapped[str | None] = mapped_column(Words(16))
    created: Mapped[float]
