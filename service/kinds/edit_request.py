"""The request of an edit; the module is light, because the limited process that reads its file imports it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from ..models import ArtifactRow, JobRow
from .request import FileRef, RequestBad

PATTERN = "pattern.npz"
"""File with the arrays of the edited pattern, beside its folder."""

FILE = "pattern.json"
"""Name of a result's pattern file."""


@dataclass(frozen=True)
class EditRequest:
    """Describe a stored result with an edited pattern.

    Attributes:
        pattern: The file of the edited pattern.
        recovered: The file of the recovered pattern, which every version is compared with; the service adds it.
    """

    pattern: FileRef
    recovered: FileRef | None = None


def add_recovered(session: Session, request: dict[str, Any], row: JobRow) -> dict[str, Any]:
    """Return a request with the recovered pattern: that of the edited result, or the one of which this is a version.

    Raises:
        RequestBad: if the request itself names one.
    """
    if "recovered" in request:
        raise RequestBad("the recovered pattern is that of the result; leave it out.")
    if "recovered" in row.request:
        return request | {"recovered": row.request["recovered"]}
    named = (ArtifactRow.job == row.id) & (ArtifactRow.kind == "result") & (ArtifactRow.name == FILE)
    key = session.scalars(select(ArtifactRow.sha256).where(named)).one_or_none()
    return request if key is None else request | {"recovered": {"sha256": key, "name": FILE}}
