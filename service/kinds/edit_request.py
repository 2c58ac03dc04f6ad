"""What an edit is asked for; light, since the limited process that reads its file imports it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from ..models import ArtifactRow, JobRow
from .request import FileRef, RequestBad

PATTERN = "pattern.npz"
"""Holds what was read of the edited pattern's file, beside its folder."""

FILE = "pattern.json"
"""Name of the file in a result that holds its pattern."""


@dataclass(frozen=True)
class EditRequest:
    """Ask for a stored result with another pattern.

    Attributes:
        pattern: The file of the edited pattern.
        recovered: The file of the pattern that was recovered, which every version is compared with; the service adds
            it.
    """

    pattern: FileRef
    recovered: FileRef | None = None


def add_recovered(session: Session, request: dict[str, Any], row: JobRow) -> dict[str, Any]:
    """Return a request with the recovered pattern: of the result that is edited, or the one that this is a version of.

    Raises:
        RequestBad: where the request names one itself.
    """
    if "recovered" in request:
        raise RequestBad("the recovered pattern is that of the result; leave it out.")
    if "recovered" in row.request:
        return request | {"recovered": row.request["recovered"]}
    named = (ArtifactRow.job == row.id) & (ArtifactRow.kind == "result") & (ArtifactRow.name == FILE)
    key = session.scalars(select(ArtifactRow.sha256).where(named)).one_or_none()
    return request if key is None else request | {"recovered": {"sha256": key, "name": FILE}}
