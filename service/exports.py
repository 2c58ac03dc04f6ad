"""Files of exports, found by the exported job."""

from __future__ import annotations

from sqlalchemy import select

from .database import Database
from .models import ArtifactRow, JobInputRow, JobRow, OwnerRow
from .records import Artifact
from .results import RESULT, ResultMissing
from .states import State


def find_export(database: Database, job: str, name: str, key: str = "") -> Artifact:
    """Return a file by name from the newest successful export of a job that has it; with a key, only from its exports.

    Raises:
        ResultMissing: if there is none.
    """
    statement = (
        select(ArtifactRow)
        .join(JobRow, JobRow.id == ArtifactRow.job)
        .join(JobInputRow, JobInputRow.job == JobRow.id)
        .where(JobInputRow.input == job, JobRow.kind == "export", JobRow.state == State.SUCCEEDED)
        .where(ArtifactRow.kind == RESULT, ArtifactRow.name == name)
        .order_by(JobRow.finished.desc(), JobRow.id)
        .limit(1)
    )
    if key:
        statement = statement.join(OwnerRow, OwnerRow.job == JobRow.id).where(OwnerRow.key == key)
    with database.read() as session:
        row = session.scalars(statement).first()
    if row is None:
        raise ResultMissing(
            f"no export of job {job} has a file '{name[:80]}'; start one: POST /v1/jobs with kind export, or "
            f"`garmentq export {job} --as FORMAT`."
        )
    return Artifact.from_row(row)
