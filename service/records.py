"""Frozen records that leave the service, the same from a home's database and from a service's JSON response.

Rows of tables do not leave this layer, and dictionaries of responses do not leave the client.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, dataclass, field, fields
from datetime import UTC, datetime
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from .adapters import ReadText, get_adapter
from .states import UNSUCCESSFUL, State

if TYPE_CHECKING:
    from .models import ApiKeyRow, ArtifactRow, EventRow, JobRow

Json = Mapping[str, Any]
"""One object of a JSON response."""

CLOSED = {"extra": "forbid"}
"""OpenAPI configuration of a record that is a response: these fields and no others."""


def check_id(job: str) -> str:
    """Return an id if it may be printed and used in a path.

    Raises:
        ValueError: if it may not.
    """
    if not (job.isascii() and job.isalnum() and len(job) <= 16):
        raise ValueError("a job's id is made of at most 16 letters and digits")
    return job


JobId = Annotated[str, ReadText(check_id)]
"""Id of a job."""


class JsonRecord:
    """Convert a dataclass from and to JSON values; a field's metadata `alias` is its name in JSON."""

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's response; the fields that only a later version has are ignored.

        Raises:
            ValueError: if a field is missing or of another type, or an id may not be printed or used in a path.
        """
        return get_adapter(cls).validate_python(found, extra="ignore")

    def as_json(self) -> dict[str, Any]:
        """Return the record as JSON values, the same keys for every state."""
        return {get_json_name(item): _show(getattr(self, item.name)) for item in fields(self)}  # type: ignore[arg-type]


def format_time(seconds: float | None) -> str | None:
    """Return a time [s since 1970] in UTC as ISO 8601 to the millisecond, or None for none, or one of no calendar."""
    if seconds is None:
        return None
    try:
        found = datetime.fromtimestamp(seconds, UTC)
    except (OverflowError, OSError, ValueError):
        return None
    return found.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def get_json_name(item: Field[Any]) -> str:
    """Return the name of a record's field in JSON."""
    return str(item.metadata.get("alias", item.name))


def _show(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return [_show(one) for one in value]
    return value.as_json() if isinstance(value, JsonRecord) else value


@dataclass(frozen=True)
class Failure(JsonRecord):
    """Describe why a job ended without success."""

    __pydantic_config__: ClassVar = CLOSED
    code: str
    message: str


@dataclass(frozen=True)
class Gate(JsonRecord):
    """Describe the verdict on one metric of a result: `verdict` is pass, doubtful or fail."""

    __pydantic_config__: ClassVar = CLOSED
    name: str
    verdict: str
    value: float | None
    limit: float | None
    message: str


@dataclass(frozen=True)
class Child(JsonRecord):
    """Describe a job that another one made."""

    __pydantic_config__: ClassVar = CLOSED
    job: JobId
    name: str
    kind: str
    state: State


class RedrapeState(StrEnum):
    """Describe whether a recovered pattern was dressed anew."""

    PENDING = "pending"
    DONE = "done"
    FAILED = "failed"
    NEVER = "never"


@dataclass(frozen=True)
class Redrape(JsonRecord):
    """Describe the re-drape of a recovery: its state, the job that makes it, and why that failed.

    `state` is `pending`, `done`, `failed` or `never`; without a `job` the recovery made it, or none was ordered.
    """

    __pydantic_config__: ClassVar = CLOSED
    state: RedrapeState
    job: JobId | None = None
    code: str | None = None

    @classmethod
    def from_job(cls, row: JobRow) -> Self:
        """Read the row of the job that makes it."""
        if row.state in UNSUCCESSFUL:
            return cls(RedrapeState.FAILED, row.id, row.error_code or f"job.{row.state}")
        return cls(RedrapeState.DONE if row.state == State.SUCCEEDED else RedrapeState.PENDING, row.id)


@dataclass(frozen=True)
class Artifact(JsonRecord):
    """Describe one file of a job: its name, sha256 (hex) and size [bytes]."""

    __pydantic_config__: ClassVar = CLOSED
    name: str
    sha256: str
    size: int

    @classmethod
    def from_row(cls, row: ArtifactRow) -> Self:
        """Read a row of the table of artifacts."""
        return cls(row.name, row.sha256, row.size)


@dataclass(frozen=True)
class Event(JsonRecord):
    """Describe one event of a job: `kind`, and its data as JSON values; `at` in s since 1970."""

    __pydantic_config__: ClassVar = CLOSED
    id: int
    job: str
    at: float
    kind: str
    data: dict[str, Any]

    @property
    def progress(self) -> Progress | None:
        """Return the progress of a stage, if the event reports that."""
        if self.kind != "progress":
            return None
        shown = (self.data.get(name) for name in ("overall", "left_seconds"))
        whole = (None if value is None else float(value) for value in shown)
        return Progress(str(self.data["stage"]), float(self.data["fraction"]), str(self.data["message"]), *whole)

    @classmethod
    def from_row(cls, row: EventRow) -> Self:
        """Read a row of the table of events."""
        return cls(row.id, row.job, row.at, row.kind, row.data)


@dataclass(frozen=True)
class Progress:
    """Describe the progress of a job: a fraction of a stage, and if known of the whole with the remaining time [s]."""

    stage: str
    fraction: float
    message: str
    overall: float | None = None
    left_seconds: float | None = None


@dataclass(frozen=True)
class News:
    """Describe a job's state and its events since the last poll; an ended state comes with all of them."""

    state: State
    events: list[Event]


@dataclass(frozen=True)
class Key(JsonRecord):
    """Describe an API key, without its token: at most `quota` jobs open at a time, none of a higher `priority`.

    Times in s since 1970; `used` has a resolution of `keys.USED_SECONDS`. Until `earlier_until` the token before the
    last rotation is valid too.
    """

    id: str = field(metadata={"alias": "key"})
    name: str
    scopes: list[str]
    quota: int
    created: float
    revoked: float | None
    priority: int = 0
    expires: float | None = None
    used: float | None = None
    earlier_until: float | None = None

    @classmethod
    def from_row(cls, row: ApiKeyRow) -> Self:
        """Read a row of the table of keys."""
        life = (row.created, row.revoked, row.priority, row.expires, row.used, row.earlier_until)
        return cls(row.id, row.name, list(row.scopes), row.quota, *life)


@dataclass(frozen=True)
class Delay(JsonRecord):
    """Describe why a queued job is paused: an outage's code, and until when [s since 1970]."""

    __pydantic_config__: ClassVar = CLOSED
    code: str
    until: float


@dataclass(frozen=True)
class Job(JsonRecord):
    """Describe the progress of a job: `progress` of its stage, `overall` of the whole, 0..1; times in s since 1970, and
    those that end in `_at` the same in UTC as ISO 8601, to the millisecond: `2026-11-30T09:15:00.000Z`.

    `expected_end` is when a running job should end, estimated from earlier jobs of its kind.
    `family` is the id of the root job, its own for a root, which has no `parent`; `verdict` is the worst of its gates,
    `pass`, `doubtful` or `fail`, and None without gates.
    """

    id: JobId = field(metadata={"alias": "job"})
    name: str
    state: State
    stage: str
    progress: float
    attempts: int
    created: float
    started: float | None
    finished: float | None
    error: Failure | None
    bad_input: bool
    queue: str
    priority: int
    kind: str
    family: JobId
    parent: JobId | None
    verdict: str | None
    delay: Delay | None = None
    overall: float = 0.0
    expected_end: float | None = None
    created_at: str | None = None
    started_at: str | None = None
    finished_at: str | None = None

    def __post_init__(self) -> None:
        """Write the times as texts, whatever an answer had."""
        for name in ("created", "started", "finished"):
            object.__setattr__(self, f"{name}_at", format_time(getattr(self, name)))

    @classmethod
    def from_row(cls, row: JobRow) -> Job:
        """Read a row of the table of jobs."""
        return Job(**_read_row(row))


@dataclass(frozen=True, kw_only=True)
class ListedJob(Job):
    """Describe a job as lists show it: beside its progress garment, base pattern, fabric, CPU time [s] and memory [MB].

    These are of the result, and None before it.
    """

    garment: str | None
    template: str | None
    fabric: str | None
    cpu_seconds: float | None
    peak_mb: float | None

    @classmethod
    def from_row(cls, row: JobRow) -> ListedJob:
        """Read a row of the table of jobs."""
        own = {name: getattr(row, name) for name in ("garment", "template", "fabric", "cpu_seconds", "peak_mb")}
        return ListedJob(**_read_row(row), **own)


@dataclass(frozen=True)
class JobPage:
    """Describe a page of a list of jobs.

    Attributes:
        jobs: The jobs.
        total: Number of jobs of the whole list; None if more than 1000 meet its conditions.
        next: Cursor of the page that follows; None if this is the last.
    """

    jobs: list[ListedJob]
    total: int | None
    next: str | None


@dataclass(frozen=True, kw_only=True)
class JobReport(Job):
    """Describe a job with its result; metrics by dotted name, which includes the unit.

    Attributes:
        garment: Category of the garment.
        template: Name of the base pattern.
        fabric: Name of the fabric.
        body: Source of the wearer.
        settings: The settings of the job's request, as JSON values.
        version: Version of the program that made the job.
        metrics: Numbers by name; None where one does not apply.
        gates: Verdicts on the metrics.
        warnings: Texts for users.
        stage_seconds: Time of each stage [s].
        cpu_seconds: CPU time of the whole [s].
        peak_mb: Largest memory [MB].
        children: The jobs that it made.
        inputs: Ids of the jobs whose results it reads, by name.
        waits: Ids of the siblings that it waits for.
        tags: Words by which its family can be found.
        details: Fields of its kind, as JSON values.
        redrape: The re-drape of a recovery; None where its method makes none.
        subject: Name of the person who was scanned; None where none was named.
        place: Place of a queued job, 1 is next; None behind the first 500, while it is paused, and in other states.
        expected_start: When a queued job should start [s since 1970], from the times of earlier jobs; None if unknown.
    """

    garment: str | None
    template: str | None
    fabric: str | None
    body: str | None
    settings: dict[str, Any]
    version: str
    metrics: dict[str, float | None]
    gates: list[Gate] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    stage_seconds: dict[str, float] = field(default_factory=dict)
    cpu_seconds: float | None = None
    peak_mb: float | None = None
    children: list[Child]
    inputs: dict[str, JobId]
    waits: list[JobId]
    tags: list[str]
    details: dict[str, Any]
    redrape: Redrape | None = None
    subject: str | None = None
    place: int | None = None
    expected_start: float | None = None

    @classmethod
    def from_row(cls, row: JobRow, **found: Any) -> JobReport:
        """Read a row of the table of jobs; `found` has the fields of other tables."""
        result = row.result or {}
        return JobReport(
            **_read_row(row),
            settings=row.request.get("settings", {}),
            version=row.version,
            **_read_result(result),
            **found,
        )


def _read_row(row: JobRow) -> dict[str, Any]:
    """Return the fields of a `Job` from its row."""
    other_columns = ("error", "progress", "delay", "overall", "created_at", "started_at", "finished_at")
    kept = {item.name: getattr(row, item.name) for item in fields(Job) if item.name not in other_columns}
    error = Failure(row.error_code, row.error_message or "") if row.error_code else None
    rests = row.state == State.QUEUED and row.delay_code is not None and row.not_before is not None
    delay = Delay(row.delay_code or "", row.not_before or 0.0) if rests else None
    shares = {"progress": round(row.progress, 4), "overall": round(row.overall, 4)}
    return {**kept, **shares, "error": error, "delay": delay, "family": row.family or row.id}


def _read_result(found: Json) -> dict[str, Any]:
    """Return the fields of a `JobReport` from a result's JSON; empty for a job without a result."""
    return {
        "gates": [Gate(*(gate[item.name] for item in fields(Gate))) for gate in found.get("gates", [])],
        "warnings": list(found.get("warnings", [])),
        "stage_seconds": dict(found.get("stage_seconds", {})),
        "cpu_seconds": found.get("cpu_seconds"),
        "peak_mb": found.get("peak_mb"),
    }
