"""Request models: what a client may send, validated before a route uses it."""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated, Any, Literal, get_type_hints

from fastapi import Query
from pydantic import BaseModel, ConfigDict, Discriminator, Field, JsonValue, StringConstraints, create_model
from pydantic import Tag as Choice

from ...core.body.spec import BUILTIN
from ...core.people.part import GARMENTS
from ...core.recover.settings import LATER, METHODS, PRESETS, QUALITIES, REDRAPES, RecoverySettings, complete_by_quality
from ...core.run.units import UNITS
from ..keys import MAX_GRACE_HOURS
from ..order import GIVEN_AS
from ..share_records import DEFAULT_SHARE_DAYS, SHARE_DAYS
from ..states import QUEUES

Text = Annotated[str, StringConstraints(max_length=255, pattern=r"^[^\x00-\x1f\x7f]*$")]
Sha256 = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]
BodySource = Annotated[
    str, StringConstraints(max_length=255, pattern=rf"^([0-9a-f]{{64}}|{BUILTIN}[A-Za-z0-9_=.,-]*)$")
]
TemplateName = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9_.-]{0,63}$")]
FabricName = TemplateName
Number = Annotated[float, Field(allow_inf_nan=False)]
GraceHours = Annotated[
    float, Query(ge=0, le=MAX_GRACE_HOURS, description="How long the one before stays valid [h]; 0: it ends at once.")
]
Tag = Annotated[str, StringConstraints(min_length=1, max_length=64, pattern=r"^[^\x00-\x1f\x7f]*$")]
Name = Annotated[str, StringConstraints(min_length=1, max_length=255, pattern=r"^[^\x00-\x1f\x7f]+$")]
SUBJECT = "Id or name of the person who was scanned; a new name creates a subject."
MAX_RANDOM_SEED = 2**31 - 1
"""Largest number for a seed: the largest integer of every client."""
WORDS = tuple(part.word for part in GARMENTS)
"""The garments of a person."""
MAX_JOBS_PER_REQUEST = 1000
"""Largest number of jobs in one request; a larger batch takes more than one."""
MAX_ORDERS_PER_REQUEST = 100
"""Largest number of orders in one request; each takes about 10 ms, and an answer has 120 s to begin."""


ALLOWED = {
    "method": METHODS, "preset": PRESETS, "units": tuple(UNITS), "up": ("y", "z", "-y", "-z"),
    "free": ("symmetry",), "redrape": REDRAPES,
}  # fmt: skip
"""Closed sets of values in the OpenAPI document; `RecoverySettings` refuses other values, by its own code."""


DEFAULTS = {"redrape": LATER}
"""Defaults that differ from those of `RecoverySettings`: a service hands a result out before its re-drape."""


def _field(name: str, hint: Any) -> Any:
    if name in DEFAULTS:
        hint = str
    if name in ALLOWED:
        known: list[JsonValue] = [*ALLOWED[name], *([None] if hint == (str | None) else [])]
        return Annotated[Text if hint is str else Text | None, Field(json_schema_extra={"enum": known})]
    if name == "seed":
        return Annotated[int, Field(ge=0, le=MAX_RANDOM_SEED)]
    if hint is str:
        return Text
    return Text | None if hint == (str | None) or name == "fabric" else hint  # a fabric by its name only


class QualityIn(BaseModel):
    """Describe the quality of a recovery, which stands for some of its settings."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"quality": "preview", "fabric": "denim"}})
    quality: Annotated[Text | None, Field(json_schema_extra={"enum": [*QUALITIES, None]})] = Field(
        None, description="Method and vertex_count, unless they are given; null: standard."
    )

    def complete(self) -> dict[str, Any]:
        """Return the fields of `RecoverySettings`.

        Raises:
            SettingsBad: if there is no such quality.
        """
        left = {"method", "vertex_count"} - self.model_fields_set
        return complete_by_quality(self.quality, self.model_dump(exclude={"quality", *left}))


_HINTS = get_type_hints(RecoverySettings)
SettingsIn: Any = create_model(
    "Settings",
    __doc__="Describe how a garment is recovered; defaults are those of `garmentq submit` (docs/reference/cli.md).",
    __base__=QualityIn,
    **{  # type: ignore[call-overload]
        f.name: (_field(f.name, _HINTS[f.name]), DEFAULTS.get(f.name, f.default))
        for f in fields(RecoverySettings)
        if f.name != "template"
    },
)
"""A quality, and the fields of `RecoverySettings` except the template, which a job names beside its files."""


class PartIn(BaseModel):
    """Describe how one garment of a person is recovered; defaults are the choices for all garments."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"fabric": "denim"}})
    pattern: Sha256 | None = Field(None, description="Hash of an upload to /v1/patterns: the base pattern.")
    template: TemplateName | None = Field(None, description="Name of a template, instead of a pattern.")
    garment: Text | None = None
    fabric: Text | None = None
    lock: Text | None = None
    cut: Text | None = Field(
        None, description="Choices of parts of the cut, neckline=v,sleeve=long; they override those for all."
    )


class JobIn(BaseModel):
    """Describe a recovery of one garment, or of all garments of a person, from uploaded files."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "scan": "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08",
                "body": "builtin:female,height=1.70",
                "template": "skirt",
                "settings": {"quality": "preview", "fabric": "denim"},
                "subject": "Anna Müller",
            }
        },
    )
    scan: Sha256 = Field(description="Hash of an upload to /v1/scans.")
    body: BodySource | None = Field(None, description="Hash of an upload to /v1/bodies, or builtin:female,height=1.70.")
    labels: Sha256 | None = Field(None, description="Hash of an upload to /v1/labels.")
    pattern: Sha256 | None = Field(None, description="Hash of an upload to /v1/patterns: the base pattern.")
    template: TemplateName | None = Field(None, description="Name of a template, instead of a pattern.")
    given_as: Literal[GIVEN_AS] | None = Field(None, alias="as", description="What the scan is; null: detected.")  # type: ignore[valid-type]
    wearing: Text | None = Field(None, description="Exactly what a person wears: upper,lower; null: detected.")
    marks: list[Text] = Field(default=[], max_length=100, description="Part of a point: upper=0.1,1.2,0.05.")
    parts: dict[Literal[WORDS], PartIn] = Field(default={}, description="Choices for single garments of a person.")  # type: ignore[valid-type]
    settings: SettingsIn = Field(default_factory=SettingsIn)
    priority: int = Field(0, ge=-100, le=100)
    queue: Literal[QUEUES] = QUEUES[0]  # type: ignore[valid-type]
    force: bool = False
    name: Text = Field("", description="Name of the family; by default the scan's name.")
    tags: list[Tag] = Field(default=[], max_length=20, description="Words by which it can be found.")
    subject: Name | None = Field(None, description=SUBJECT)
    check: bool = Field(False, description="Read the files before the job is queued, and refuse unusable ones.")


JobId = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{12}$")]
FieldName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z_]{0,31}$")]


class DerivedIn(BaseModel):
    """Describe a job that works on a stored result."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "kind": "dress",
                "result": "3685ecfd4f81",
                "options": {"body": "builtin:male,height=1.85,weight=85", "pose": "A"},
            }
        },
    )
    kind: Annotated[str, StringConstraints(pattern=r"^[a-z][a-z_]{0,31}$")] = Field(description="dress, for example.")
    result: JobId = Field(description="The job whose result it works on.")
    over: JobId | None = Field(None, description="dress: the job whose garment it is worn over; null: none.")
    options: dict[FieldName, Any] = Field(default={}, max_length=50, description="See docs/reference/http.md.")
    files: dict[FieldName, Sha256] = Field(default={}, max_length=10, description="Hashes of uploads, by field.")
    priority: int = Field(0, ge=-100, le=100)
    queue: Literal[QUEUES] = QUEUES[0]  # type: ignore[valid-type]
    force: bool = False
    name: Text = Field("", description="Name of the job; by default that of the result's job.")
    tags: list[Tag] = Field(default=[], max_length=20, description="Words by which it can be found.")
    subject: Name | None = Field(None, description=SUBJECT)


class RenamingIn(BaseModel):
    """Describe another name, other tags or another priority of a family."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"name": "Anna", "tags": ["spring"]}})
    name: Text | None = Field(None, min_length=1, description="The new name; null: as it is.")
    tags: list[Tag] | None = Field(None, max_length=20, description="All tags from now on; null: as they are.")
    priority: int | None = Field(None, ge=-100, le=100, description="A larger one goes first; null: as it is.")


def _tag(value: Any) -> str:
    return "derived" if isinstance(value, DerivedIn) or (isinstance(value, dict) and "kind" in value) else "scan"


AnyJobIn = Annotated[Annotated[JobIn, Choice("scan")] | Annotated[DerivedIn, Choice("derived")], Discriminator(_tag)]
"""A request for a job; a `kind` marks one that works on a stored result."""


class OrdersIn(BaseModel):
    """Describe several jobs, each as a request for one describes it."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "orders": [
                    {"scan": "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08", "tags": ["march"]},
                    {"kind": "export", "result": "3685ecfd4f81", "options": {"format": "pdf"}},
                ]
            }
        },
    )
    orders: list[AnyJobIn] = Field(min_length=1, max_length=MAX_ORDERS_PER_REQUEST)


SQUARE: dict[str, JsonValue] = {
    "pattern": {
        "panels": {
            "square": {
                "vertices": [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]],
                "edges": [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}, {"endpoints": [3, 0]}],
            }
        },
        "stitches": [],
    },
    "properties": {"units_in_meter": 100},
}
"""The smallest document of a pattern."""


class PanelsIn(BaseModel):
    """Describe the panels and seams of a document."""

    model_config = ConfigDict(extra="allow")
    panels: dict[str, dict[str, Any]] = Field(min_length=1)


class DocumentIn(BaseModel):
    """Describe a GarmentCode or NeuralTailor pattern; docs/reference/pattern-documents.md."""

    model_config = ConfigDict(extra="allow", json_schema_extra={"example": SQUARE})
    pattern: PanelsIn
    properties: dict[str, Any] = Field(min_length=1, description="units_in_meter at least.")


class PatternEditIn(BaseModel):
    """Describe operations that are applied to a pattern's document."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "pattern": SQUARE, "operations": [{"op": "split", "panel": "square", "edge": 0, "at": 0.5}]
            }
        },
    )  # fmt: skip
    pattern: DocumentIn
    operations: list[dict[str, Any]] = Field(max_length=1000, description="Operations, each with `op` and its fields.")


class LabelsIn(BaseModel):
    """Describe corrected labels of a person's scan."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"example": {"points": "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"}},
    )
    points: Sha256 = Field(
        description="Hash of an upload to /v1/labels: an .npy file, uint8, a part's number for each point of the "
        "result's segmented.ply."
    )


class WearingIn(BaseModel):
    """Describe what a person wears."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"wearing": "upper,lower"}})
    wearing: Text = Field(description="Exactly these garments: some of upper, lower, one-piece, outer; or nothing.")


class JobsIn(BaseModel):
    """List jobs by their ids."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"jobs": ["3685ecfd4f81", "5f1d0c9b7a3e"]}})
    jobs: list[JobId] = Field(min_length=1, max_length=MAX_JOBS_PER_REQUEST)
    below: bool = Field(False, description="Also return all jobs below them.")


FABRIC: Any = {
    "name": "mine", "title": "our poplin", "density": 0.12, "thickness": 0.00025, "friction": 0.6, "H00": 800.0,
    "H01": 60.0, "H11": 1200.0, "H22": 120.0, "k": 1.6e-5,
    "sources": {
        "density": "measured: by our scales", "thickness": "measured: under 100 Pa", "friction": "assumed: 0.3 to 0.9",
        "H00": "measured: on our bench", "H01": "assumed: 5 to 20 % of H00", "H11": "measured: on our bench",
        "H22": "measured: on our bench", "k": "derived: from a cantilever",
    },
}  # fmt: skip
"""Example of a user's fabric."""


class FabricIn(BaseModel):
    """Describe a fabric in SI units: H [N/m], k [N m], density [kg/m2], thickness [m], and each number's source."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": FABRIC})
    name: FabricName
    title: Text = ""
    density: Number
    thickness: Number
    friction: Number
    H00: Number
    H01: Number
    H11: Number
    H22: Number
    k: Number
    sources: dict[Text, Annotated[str, StringConstraints(max_length=1100)]] = Field(max_length=8)


class ShareIn(BaseModel):
    """Describe a link to a result."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"days": 7}})
    days: Literal[SHARE_DAYS] = Field(DEFAULT_SHARE_DAYS, description="How long it is valid.")  # type: ignore[valid-type]


class WebhookIn(BaseModel):
    """Describe a webhook that receives a message when jobs end."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"example": {"url": "https://studio.example/garmentq", "states": ["succeeded", "failed"]}},
    )
    url: Annotated[str, StringConstraints(min_length=1, max_length=2000, pattern=r"^[!-~]+$")]
    states: list[Literal["succeeded", "failed", "dead", "cancelled"]] = Field(
        default=[], max_length=4, description="End states that it receives messages about; none: all."
    )


class KeyIn(BaseModel):
    """Describe a new key."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"example": {"name": "atelier", "scopes": ["read", "submit"], "quota": 100}}
    )
    name: Annotated[str, StringConstraints(min_length=1, max_length=255, pattern=r"^[^\x00-\x1f\x7f]+$")]
    scopes: list[Annotated[str, StringConstraints(pattern="^(read|submit|metrics|admin)$")]] = Field(
        default=["read", "submit"], min_length=1, max_length=4
    )
    quota: int = Field(100, ge=1, le=1_000_000)
    priority: int = Field(0, ge=0, le=100, description="Highest priority that its jobs may have.")
    days: float | None = Field(None, gt=0, le=36500, description="Time until it expires [d]; null: never.")


Time = Annotated[float, Field(ge=0.0, lt=1e11, allow_inf_nan=False)]


class SubjectIn(BaseModel):
    """Describe a person who was scanned; times in s since 1970."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "example": {
                "name": "Anna Müller", "note": "customer 4711", "consented": 1795219200.0,
                "consent": "form 2026-11-22, folder A", "keep_days": 90,
            }
        },
    )  # fmt: skip
    name: Name
    note: Annotated[str, StringConstraints(max_length=10_000)] = ""
    consented: Time | None = Field(None, description="When the person agreed to be scanned; null: unknown.")
    consent: Text = Field("", description="Where that is written: a reference, or the text itself.")
    consent_until: Time | None = Field(None, description="Until when the person agreed; null: without end.")
    keep_days: float | None = Field(
        None, gt=0, le=36500, description="Days after the end of its newest job after which all its data are deleted."
    )
    keep_until: Time | None = Field(None, description="When all its data are deleted at the latest.")


class SubjectJobsIn(BaseModel):
    """List the jobs that are to be a subject's."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"example": {"jobs": ["3685ecfd4f81"]}})
    jobs: list[JobId] = Field(min_length=1, max_length=MAX_JOBS_PER_REQUEST)
