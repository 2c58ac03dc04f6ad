"""What the service answers, as the OpenAPI page describes it; a test holds every answer against this."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from ..states import State
from .schemas import Sha256


class _Answer(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Problem(_Answer):
    """Tell what is wrong (RFC 9457): `code` is stable, `detail` names the next step."""

    type: str
    title: str
    status: int
    code: str
    detail: str


class Upload(_Answer):
    """Name a file that was uploaded: its hash, cleaned name, and size [bytes]."""

    sha256: Sha256
    name: str
    size: int


class Asked(_Answer):
    """Answer a request for a recovery; `is_new` is false where an equal job existed."""

    job: str
    state: State
    is_new: bool


class Changed(_Answer):
    """Give a job's state after what was asked."""

    job: str
    state: State


class Failure(_Answer):
    """Tell why a job ended badly."""

    code: str
    message: str


class Brief(_Answer):
    """Tell how far a job is; `progress` of the stage in 0..1, times in seconds since 1970."""

    job: str
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


class Gate(_Answer):
    """Judge one metric."""

    name: str
    verdict: str
    value: float | None
    limit: float | None
    message: str


class Job(Brief):
    """Show a job and what it found; metrics by dotted name, each with its unit in it."""

    garment: str | None
    template: str | None
    fabric: str | None
    body: str | None
    settings: dict[str, Any]
    version: str
    metrics: dict[str, float | None]
    gates: list[Gate]
    warnings: list[str]
    stage_seconds: dict[str, float]
    cpu_seconds: float | None
    peak_mb: float | None


class File(_Answer):
    """Name one file of a job, with its hash and size [bytes]."""

    name: str
    sha256: Sha256
    size: int


class Result(Job):
    """Show an ended job with its files."""

    files: list[File]


class Jobs(_Answer):
    """List jobs."""

    jobs: list[Job]


class Briefs(_Answer):
    """List how far some jobs are; those that are unknown, or another key's, are left out."""

    jobs: list[Brief]


class Files(_Answer):
    """List the files of a job."""

    files: list[File]


class Event(_Answer):
    """Tell one thing that happened to a job."""

    id: int
    at: float
    kind: str
    data: dict[str, Any]


class Events(_Answer):
    """List events in order, and the job's state before they were read."""

    events: list[Event]
    state: State


class Wearer(_Answer):
    """Show the wearer as a job saw it: joints [m] by name."""

    job: str
    source: str
    fit_rms: float
    joints: dict[str, list[float]]
    parameters: dict[str, Any]


class Worker(_Answer):
    """Tell of a living worker; its name is shown to the scope `admin` only."""

    name: str
    queues: str
    concurrency: int
    started: float
    seen: float


class Queue(_Answer):
    """Count the caller's jobs by state, and list the living workers."""

    states: dict[State, int]
    workers: list[Worker]


class Template(_Answer):
    """Name a base pattern."""

    name: str
    category: str
    source: Literal["shipped", "imported"]
    title: str


class Templates(_Answer):
    """List base patterns."""

    templates: list[Template]


class Imported(_Answer):
    """Tell what was understood of an imported pattern."""

    name: str
    panels: int
    seams: int
    category: str


class Material(BaseModel):
    """Show a fabric: H [N/m], k [N m], density [kg/m2], thickness [m], and where each number comes from."""

    name: str
    title: str
    density: float
    thickness: float
    friction: float
    H00: float
    H01: float
    H11: float
    H22: float
    k: float
    sources: dict[str, str]


class Materials(_Answer):
    """List fabrics."""

    materials: list[Material]


class Key(_Answer):
    """Show an API key."""

    key: str
    name: str
    scopes: list[Literal["read", "submit", "admin"]]
    quota: int
    created: float
    revoked: float | None


class NewKey(Key):
    """Show a new API key, with its token this once."""

    token: str


class Keys(_Answer):
    """List API keys."""

    keys: list[Key]


class Health(_Answer):
    """Tell that the process lives, and its version."""

    status: Literal["ok"]
    version: str


class Readiness(_Answer):
    """Tell `ok` of database and store; otherwise the answer is a problem."""

    database: str
    store: str
