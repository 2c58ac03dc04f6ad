"""Response models of the service, as the OpenAPI document has them; a test checks every response against them."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Literal, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, create_model

from .. import records, subject_records
from ..batch_records import Batch
from ..catalogue import Template
from ..records import Artifact, Event, get_json_name
from ..share_records import Share as ShareRecord
from ..states import State
from ..versions import Version
from ..webhook_records import Webhook as WebhookRecord
from .schemas import Sha256


class Answer(BaseModel):
    """Define a response model that has its own fields only."""

    model_config = ConfigDict(extra="forbid")


def _make_model(record: type) -> Any:
    """Return the model of a record whose `id` has another name in JSON."""
    hints = get_type_hints(record)
    names = {get_json_name(item): (hints[item.name], ...) for item in fields(record)}
    return create_model(record.__name__, __base__=Answer, __doc__=record.__doc__, **names)  # type: ignore[call-overload]


Brief: Any = _make_model(records.Job)
Listed: Any = _make_model(records.ListedJob)
Job: Any = _make_model(records.JobReport)
Key: Any = _make_model(records.Key)
Subject: Any = _make_model(subject_records.Subject)
SubjectReport: Any = _make_model(subject_records.SubjectReport)


class Whole(Answer):
    """Describe a list that is returned at once: `total` counts it, and no page follows."""

    total: int
    next: None


class Place(Answer):
    """Describe a place of a pattern by the document's numbers; `point` is in its unit and the panel's axes."""

    panel: str
    edge: int | None
    vertex: int | None
    point: tuple[float, float] | None


class Finding(Answer):
    """Describe one fault of a pattern; `code` is stable."""

    code: str
    severity: Literal["error", "warning"]
    message: str
    seam: int | None
    places: list[Place]


class Problem(Answer):
    """Describe an error (RFC 9457): `code` is stable, `detail` names the next step.

    `findings` are the faults of a pattern that cannot be draped.
    """

    type: str
    title: str
    status: int
    code: str
    detail: str
    findings: list[Finding] = []


class Upload(Answer):
    """Describe an uploaded file: its hash, cleaned name, and size [bytes]."""

    sha256: Sha256
    name: str
    size: int


class ScanRead(Answer):
    """Describe a scan as it was read; `file_count` is the number of points in the file before cleaning."""

    name: str
    units: str
    up: str
    is_cloud: bool
    vertex_count: int
    face_count: int
    file_count: int
    extent_m: tuple[float, float, float]
    has_colours: bool
    has_labels: bool
    notes: list[str]


class Need(Answer):
    """Describe what a job needs beside the scan."""

    code: str
    message: str


class Inspection(BaseModel):
    """Describe what was detected in a scan; `is_sure` is false if only the job can distinguish person and garment."""

    model_config = ConfigDict(extra="forbid", populate_by_name=True, serialize_by_alias=True)

    given_as: Literal["person", "garment"] = Field(alias="as")
    is_sure: bool
    scan: ScanRead
    body: dict[str, Any] | None
    category: str | None
    contours_m: dict[str, float] | None
    remarks: list[str]
    needs: Need | None


class Asked(Answer):
    """Answer a request for a job; `is_new` is false if an equal job existed.

    `understood` is what the check of the files found; null if the job checks them.
    """

    job: str
    state: State
    is_new: bool
    understood: dict[str, Any] | None = None


class Refusal(Answer):
    """Describe why one of several orders was refused, as a problem does."""

    status: int
    code: str
    detail: str


class OrderResult(Answer):
    """Describe what became of one of several orders: `job`, or the `error` if it was refused."""

    job: Asked | None
    error: Refusal | None


class Ordered(Answer):
    """List what became of several orders, in their order."""

    results: list[OrderResult]


class Changed(Answer):
    """Describe a job's state after the request."""

    job: str
    state: State


class Result(Job):
    """Describe an ended job with its files."""

    files: list[Artifact]


class Jobs(Answer):
    """List a page of jobs; `next` is the `cursor` of the page that follows, null on the last one.

    `total` counts the whole list; null if more than 1000 jobs meet its conditions.
    """

    jobs: list[Job | Listed]
    total: int | None
    next: str | None


class Briefs(Answer):
    """List the progress of some jobs; unknown jobs and jobs of other keys are left out."""

    jobs: list[Brief]


class Events(Answer):
    """List events of a job after one: an ended `state` with `next` null comes with all of them.

    `next` is the `after` of the events that follow, null if there are none yet; `total` counts all of the job.
    """

    state: State
    events: list[Event]
    total: int
    next: int | None


class Files(Whole):
    """List the files of a job."""

    files: list[Artifact]


class Versions(Whole):
    """List the versions of a result."""

    versions: list[Version]


class Wearer(Answer):
    """Describe the wearer as the job estimated it: joints [m] by name."""

    job: str
    source: str
    fit_rms: float
    joints: dict[str, list[float]]
    parameters: dict[str, Any]


class Templates(Whole):
    """List base patterns."""

    templates: list[Template]


class Material(BaseModel):
    """Describe a fabric: H [N/m], k [N m], density [kg/m2], thickness [m], and the source of each number."""

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


class Materials(Whole):
    """List fabrics."""

    materials: list[Material]


class NewKey(Key):
    """Describe a new API key with its token, which is shown only here."""

    token: str


class Keys(Whole):
    """List API keys."""

    keys: list[Key]


Share: Any = _make_model(ShareRecord)


class NewShare(Share):
    """Describe a new link to a result; `path` with its token is returned only here."""

    path: str


class Shares(Whole):
    """List links to a result."""

    shares: list[Share]


Webhook: Any = _make_model(WebhookRecord)


class NewWebhook(Webhook):
    """Describe a new webhook with its secret, which is shown only here."""

    secret: str


class Webhooks(Whole):
    """List webhooks."""

    webhooks: list[Webhook]


class Subjects(Answer):
    """List subjects."""

    subjects: list[Subject]


class Batches(Answer):
    """List batches."""

    batches: list[Batch]


class Pair(Answer):
    """Describe how two panels differ: pairing, turning distance [rad], area of the first over the second's.

    In the best fit the first panel is mirrored (x becomes -x) if `turned_over`, then rotated by `angle` and moved by
    `shift`.
    """

    first: str
    second: str
    paired_by: Literal["given", "name", "shape"]
    turning: float
    area_percent: float
    outline_mm: float
    turned_over: bool
    angle: float
    shift: tuple[float, float]


class Match(Answer):
    """Describe how two patterns differ: their pairs of panels, and the panels that have no counterpart."""

    pairs: list[Pair]
    only_first: list[str]
    only_second: list[str]
    first_outlines: dict[str, list[tuple[float, float]]] | None = None
    second_outlines: dict[str, list[tuple[float, float]]] | None = None


class EdgeOf(Answer):
    """Describe an edge by panel and number."""

    panel: str
    edge: int


class PanelMeasures(Answer):
    """Describe the area and edge lengths of a panel, in the document's order."""

    panel: str
    area_cm2: float
    edges_mm: list[float]


class SeamMeasures(Answer):
    """Describe the lengths of both sides of a seam; the mismatch is the first less the second."""

    a: EdgeOf
    b: EdgeOf
    lengths_mm: tuple[float, float]
    mismatch_mm: float
    is_gathered: bool


class MirrorImage(Answer):
    """Describe control points of two mirrored panels; `matrix` maps a move of the source to one of the target."""

    source: str
    target: str
    vertices: list[tuple[int, int]]
    matrix: list[tuple[float, float]]


class PatternCheck(Answer):
    """Describe the faults of a pattern and its measures."""

    is_sound: bool
    findings: list[Finding]
    panels: list[PanelMeasures]
    seams: list[SeamMeasures]
    mirrors: list[MirrorImage]


class PatternEdited(PatternCheck):
    """Describe a changed pattern: its document, its faults and its measures."""

    pattern: dict[str, Any]


class Health(Answer):
    """Report that the process is alive, and its version."""

    status: Literal["ok"]
    version: str


class Readiness(Answer):
    """Report that database and store are `ok`; otherwise the answer is a problem.

    `troubles` lists what keeps accepted jobs from running: no worker, a silent dispatcher, an outage.
    """

    database: str
    store: str
    troubles: list[str]
