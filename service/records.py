"""Frozen records that leave the service, the same from a home's database and from a service's JSON response.

Rows of tables do not leave this layer, and dictionaries of responses do not leave the client.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import TYPE_CHECKING, Any, ClassVar, Self

from .states import State

if TYPE_CHECKING:
    from .models import ApiKeyRow, ArtifactRow, EventRow, JobRow

Json = Mapping[str, Any]
"""One object of a JSON response."""

CLOSED = {"extra": "forbid"}
"""OpenAPI configuration of a record that is a response: these fields and no others."""


@dataclass(frozen=True)
class Failure:
    """Describe why a job ended without success."""

    __pydantic_config__: ClassVar = CLOSED
    code: str
    message: str


@dataclass(frozen=True)
class Gate:
    """Describe the verdict on one metric of a result: `verdict` is pass, doubtful or fail."""

    __pydantic_config__: ClassVar = CLOSED
    name: str
    verdict: str
    value: float | None
    limit: float | None
    message: str


@dataclass(frozen=True)
class Child:
    """Describe a job that another one made."""

    __pydantic_config__: ClassVar = CLOSED
    job: str
    name: str
    kind: str
    state: State

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's response."""
        return cls(check_id(found["job"]), str(found["name"]), str(found["kind"]), State(found["state"]))


@dataclass(frozen=True)
class Artifact:
    """Describe one file of a job: its name, sha256 (hex) and size [bytes]."""

    __pydantic_config__: ClassVar = CLOSED
    name: str
    sha256: str
    size: int

    @classmethod
    def from_row(cls, row: ArtifactRow) -> Self:
        """Read a row of the table of artifacts."""
        return cls(row.name, row.sha256, row.size)

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's response."""
        return cls(str(found["name"]), str(found["sha256"]), int(found["size"]))


@dataclass(frozen=True)
class Event:
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
        whole = (read_optional(self.data.get(name)) for name in ("overall", "left_seconds"))
        return Progress(str(self.data["stage"]), float(self.data["fraction"]), str(self.data["message"]), *whole)

    @classmethod
    def from_row(cls, row: EventRow) -> Self:
        """Read a row of the table of events."""
        return cls(row.id, row.job, row.at, row.kind, row.data)

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's response."""
        return cls(int(found["id"]), str(found["job"]), float(found["at"]), str(found["kind"]), dict(found["data"]))


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

    __pydantic_config__: ClassVar = CLOSED
    state: State
    events: list[Event]


@dataclass(frozen=True)
class Key:
    """Describe an API key, without its token: at most `quota` jobs open at a time, none of a higher `priority`.

    Times in s since 1970; `used` has a resolution of `keys.USED_SECONDS`.
    """

    id: str
    name: str
    scopes: list[str]
    quota: int
    created: float
    revoked: float | None
    priority: int = 0
    expires: float | None = None
    used: float | None = None

    @classmethod
    def from_row(cls, row: ApiKeyRow) -> Self:
        """Read a row of the table of keys."""
        life = (row.created, row.revoked, row.priority, row.expires, row.used)
        return cls(row.id, row.name, list(row.scopes), row.quota, *life)

    @classmethod
    def from_json(cls, found: Json) -> Self:
        """Read a service's response."""
        return cls(
            id=str(found["key"]),
            name=str(found["name"]),
            scopes=[str(scope) for scope in found["scopes"]],
            quota=int(found["quota"]),
            created=float(found["created"]),
            revoked=read_optional(found["revoked"]),
            priority=int(found.get("priority", 0)),
            expires=read_optional(found.get("expires")),
            used=read_optional(found.get("used")),
        )

    def as_json(self) -> dict[str, Any]:
        """Return the key as JSON values."""
        return {"key": self.id, **{n: v for n, v in asdict(self).items() if n != "id"}}


@dataclass(frozen=True)
class Delay:
    """Describe why a queued job is paused: an outage's code, and until when [s since 1970]."""

    __pydantic_config__: ClassVar = CLOSED
    code: str
    until: float


@dataclass(frozen=True)
class Job:
    """Describe the progress of a job: `progress` of its stage, `overall` of the whole, 0..1; times in s since 1970.

    `expected_end` is when a running job should end, estimated from earlier jobs of its kind.
    `family` is the id of the root job, its own for a root, which has no `parent`; `verdict` is the worst of its gates,
    `pass`, `doubtful` or `fail`, and None without gates.
    """

    id: str
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
    kind: str = "recover"
    family: str = ""
    parent: str | None = None
    verdict: str | None = None
    delay: Delay | None = None
    overall: float = 0.0
    expected_end: float | None = None

    @classmethod
    def from_row(cls, row: JobRow) -> Job:
        """Read a row of the table of jobs."""
        return Job(**_read_row(row))

    @classmethod
    def from_json(cls, found: Json) -> Job:
        """Read a service's response.

        Raises:
            ValueError: if the id may not be printed or used in a path.
        """
        return Job(**_read_job(found))

    def as_json(self) -> dict[str, Any]:
        """Return the job as JSON values, the same keys for every state."""
        shown = {item.name: getattr(self, item.name) for item in fields(Job) if item.name != "id"}
        failed, rests = (None if one is None else asdict(one) for one in (self.error, self.delay))
        return {"job": self.id, **shown, "error": failed, "delay": rests}


@dataclass(frozen=True)
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
    """

    garment: str | None = None
    template: str | None = None
    fabric: str | None = None
    body: str | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    version: str = ""
    metrics: dict[str, float | None] = field(default_factory=dict)
    gates: list[Gate] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    stage_seconds: dict[str, float] = field(default_factory=dict)
    cpu_seconds: float | None = None
    peak_mb: float | None = None
    children: list[Child] = field(default_factory=list)
    inputs: dict[str, str] = field(default_factory=dict)
    waits: list[str] = field(default_factory=list)
    tags: list[str] = field(default_factory=list)
    details: dict[str, Any] = field(default_factory=dict)

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

    @classmethod
    def from_json(cls, found: Json) -> JobReport:
        """Read a service's response.

        Raises:
            ValueError: if the id may not be printed or used in a path.
        """
        return JobReport(
            **_read_job(found),
            garment=found["garment"],
            template=found["template"],
            fabric=found["fabric"],
            body=found["body"],
            settings=dict(found["settings"]),
            version=str(found["version"]),
            metrics={str(name): read_optional(value) for name, value in found["metrics"].items()},
            children=[Child.from_json(child) for child in found["children"]],
            inputs={str(name): check_id(job) for name, job in found["inputs"].items()},
            waits=[check_id(job) for job in found["waits"]],
            tags=[str(tag) for tag in found["tags"]],
            details=dict(found["details"]),
            **_read_result(found),
        )

    def as_json(self) -> dict[str, Any]:
        """Return the job and its result as JSON values, the same keys for every state."""
        mine = {item.name for item in fields(JobReport)} - {item.name for item in fields(Job)}
        found = {item.name: getattr(self, item.name) for item in fields(JobReport) if item.name in mine}
        children = [asdict(child) for child in self.children]
        return {**super().as_json(), **found, "gates": [asdict(gate) for gate in self.gates], "children": children}


def _read_row(row: JobRow) -> dict[str, Any]:
    """Return the fields of a `Job` from its row."""
    own = ("error", "progress", "delay", "overall")
    kept = {item.name: getattr(row, item.name) for item in fields(Job) if item.name not in own}
    error = Failure(row.error_code, row.error_message or "") if row.error_code else None
    rests = row.state == State.QUEUED and row.delay_code is not None and row.not_before is not None
    delay = Delay(row.delay_code or "", row.not_before or 0.0) if rests else None
    shares = {"progress": round(row.progress, 4), "overall": round(row.overall, 4)}
    return {**kept, **shares, "error": error, "delay": delay, "family": row.family or row.id}


def _read_job(found: Json) -> dict[str, Any]:
    """Return the fields of a `Job` from a service's response."""
    error = found["error"]
    return {
        "id": check_id(found["job"]),
        "name": str(found["name"]),
        "kind": str(found["kind"]),
        "family": check_id(found["family"]),
        "parent": check_id(found["parent"]) if found["parent"] else None,
        "state": State(found["state"]),
        "stage": str(found["stage"]),
        "progress": float(found["progress"]),
        "attempts": int(found["attempts"]),
        "created": float(found["created"]),
        "started": read_optional(found["started"]),
        "finished": read_optional(found["finished"]),
        "error": Failure(str(error["code"]), str(error["message"])) if error else None,
        "bad_input": bool(found["bad_input"]),
        "queue": str(found["queue"]),
        "priority": int(found["priority"]),
        "verdict": str(found["verdict"]) if found["verdict"] else None,
        "overall": float(found.get("overall", 0.0)),
        "expected_end": read_optional(found.get("expected_end")),
        "delay": Delay(str(delay["code"]), float(delay["until"])) if (delay := found.get("delay")) else None,
    }


def _read_result(found: Json) -> dict[str, Any]:
    """Return the fields of a `JobReport` from a result's JSON; empty for a job without a result."""
    return {
        "gates": [Gate(*(gate[item.name] for item in fields(Gate))) for gate in found.get("gates", [])],
        "warnings": list(found.get("warnings", [])),
        "stage_seconds": dict(found.get("stage_seconds", {})),
        "cpu_seconds": found.get("cpu_seconds"),
        "peak_mb": found.get("peak_mb"),
    }


def check_id(job: str) -> str:
    """Return an id if it may be printed and used in a path.

    Raises:
        ValueError: if it may not.
    """
    if not (job.isascii() and job.isalnum() and len(job) <= 16):
        raise ValueError("a job's id is made of at most 16 letters and digits")
    return job


def read_optional(value: float | None) -> float | None:
    """Return a number that may be missing."""
    return None if value is None else float(value)
