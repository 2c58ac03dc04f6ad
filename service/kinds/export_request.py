"""The request of an export: its options, and the scan of the result if its colours are needed."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from ...core.deliver.formats.options import ExportOptions
from ..models import ArtifactRow, JobInputRow, JobRow
from .recover_request import PERSON, READING
from .request import FileRef, RequestBad

COLOURED = ("texture",)
"""Formats that use the scan's colours."""


@dataclass(frozen=True)
class ExportRequest(ExportOptions):
    """Describe a stored result in a production format.

    Attributes:
        scan: The scan of the result, or the reading of a garment of a person; the service adds it for `COLOURED`.
        made: Day on which the result was made, for the titles of printed files; the service adds it.
    """

    scan: FileRef | None = None
    made: str | None = None


def find_scan(session: Session, row: JobRow) -> dict[str, Any] | None:
    """Return the stored file of a recovery's scan as JSON values, or None if it is not known.

    For a garment of a person it is the reading in the result of the person's job.
    """
    scan, part = row.request.get("scan"), row.request.get("part")
    if scan is not None:
        return dict(scan)
    if part is None:
        return None
    person = select(JobInputRow.input).where(JobInputRow.job == row.id, JobInputRow.name == PERSON)
    named = (ArtifactRow.kind == "result") & (ArtifactRow.name == f"{part}/{READING}")
    key = session.scalars(
        select(ArtifactRow.sha256).where(ArtifactRow.job.in_(person.scalar_subquery()), named)
    ).one_or_none()
    return None if key is None else {"sha256": key, "name": READING}


def add_day(request: dict[str, Any], row: JobRow) -> dict[str, Any]:
    """Return a request with the day on which the result was ordered, in UTC.

    Raises:
        RequestBad: if the request itself names a day.
    """
    if request.get("made"):
        raise RequestBad("the day of an export is that of its result; leave it out.")
    return request | {"made": datetime.fromtimestamp(row.created, UTC).date().isoformat()}


def add_scan(session: Session, request: dict[str, Any], row: JobRow) -> dict[str, Any]:
    """Return a request with the scan of the result, if its format uses the colours.

    Raises:
        RequestBad: if the request itself names a scan.
    """
    if "scan" in request:
        raise RequestBad("the scan of an export is that of its result; leave it out.")
    if request.get("format") not in COLOURED:
        return request
    scan = find_scan(session, row)
    return request if scan is None else request | {"scan": scan}
