"""What an export is asked for: what may be chosen, and the scan of the result where its colours are needed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from ...core.deliver.formats.options import ExportOptions
from ..models import ArtifactRow, JobInputRow, JobRow
from .recover_request import PERSON, READING
from .request import FileRef, RequestBad

COLOURED = ("texture",)
"""Formats that take the scan's colours."""


@dataclass(frozen=True)
class ExportRequest(ExportOptions):
    """Ask for a stored result in a format.

    Attributes:
        scan: The scan of the result, or the reading of a garment of a person; the service adds it for `COLOURED`.
    """

    scan: FileRef | None = None


def find_scan(session: Session, row: JobRow) -> dict[str, Any] | None:
    """Return the stored file of a recovery's scan as JSON values, or None where it is not known.

    Of a garment of a person that is the reading in the result of the job that took the person apart.
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


def add_scan(session: Session, request: dict[str, Any], row: JobRow) -> dict[str, Any]:
    """Return a request with the scan of the result, where its format takes the colours.

    Raises:
        RequestBad: where the request names a scan itself.
    """
    if "scan" in request:
        raise RequestBad("the scan of an export is that of its result; leave it out.")
    if request.get("format") not in COLOURED:
        return request
    scan = find_scan(session, row)
    return request if scan is None else request | {"scan": scan}
