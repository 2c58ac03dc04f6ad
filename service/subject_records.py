"""Records of subjects; see `records.py`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from .records import CLOSED, Child, JobId, JsonRecord
from .states import State

if TYPE_CHECKING:
    from .models import SubjectRow


@dataclass(frozen=True)
class SubjectFields:
    """Describe what a user says of a subject; times in s since 1970.

    Attributes:
        name: Its name, the only one of the key.
        note: Any text.
        consented: When the person agreed to be scanned, or None.
        consent: Where that is written: a reference, or the text itself.
        consent_until: Until when the person agreed, or None: without end.
        keep_days: Days after the end of its newest job after which all its data are deleted, or None.
        keep_until: When they are deleted at the latest, or None.
    """

    name: str
    note: str = ""
    consented: float | None = None
    consent: str = ""
    consent_until: float | None = None
    keep_days: float | None = None
    keep_until: float | None = None


@dataclass(frozen=True)
class Subject(JsonRecord):
    """Describe a person who was scanned; times in s since 1970.

    `consented` is when the person agreed, until `consent_until`; `consent` says where that is written. All data of the
    person are deleted `keep_days` after the end of the newest job, or at `keep_until`: at `expires`, null for never.
    """

    id: JobId = field(metadata={"alias": "subject"})
    key: str
    name: str
    note: str
    created: float
    consented: float | None
    consent: str
    consent_until: float | None
    keep_days: float | None
    keep_until: float | None
    expires: float | None
    jobs: int

    @property
    def said(self) -> SubjectFields:
        """Return what the user said of it."""
        return SubjectFields(**{name: getattr(self, name) for name in SubjectFields.__dataclass_fields__})


@dataclass(frozen=True)
class SubjectScan(JsonRecord):
    """Describe a scan of a subject: its hash, name, size [bytes], and when it was stored [s since 1970]."""

    __pydantic_config__: ClassVar = CLOSED
    sha256: str
    name: str
    size: int
    created: float


@dataclass(frozen=True)
class SubjectFamily(JsonRecord):
    """Describe a family of a subject's jobs by its root, with the jobs below that; `created` in s since 1970."""

    __pydantic_config__: ClassVar = CLOSED
    job: JobId
    name: str
    kind: str
    state: State
    verdict: str | None
    garment: str | None
    created: float
    children: tuple[Child, ...] = ()


@dataclass(frozen=True)
class SubjectWearer(JsonRecord):
    """Describe the body of a subject as a job estimated it.

    `measures` are in mm by name, of bodies in a pose that can be measured; `fit_rms` [m] is the distance to the scan.
    """

    __pydantic_config__: ClassVar = CLOSED
    job: JobId
    created: float
    source: str
    fit_rms: float
    measures: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class SubjectReport(Subject):
    """Describe a subject with its scans, families and bodies, each the newest first, at most `MAX_SUBJECT_FAMILIES`."""

    scans: tuple[SubjectScan, ...] = ()
    families: tuple[SubjectFamily, ...] = ()
    wearers: tuple[SubjectWearer, ...] = ()


def read_row(row: SubjectRow, jobs: int, last: float | None) -> dict[str, Any]:
    """Return the fields of a `Subject` from its row, the number of its jobs and the end of the newest."""
    ends = [] if row.keep_until is None else [row.keep_until]
    if row.keep_days is not None:
        ends.append(max(row.created, last or 0.0) + 86400.0 * row.keep_days)
    shown = {name: getattr(row, name) for name in ("id", "key", "created", *SubjectFields.__dataclass_fields__)}
    return {**shown, "expires": min(ends, default=None), "jobs": jobs}
