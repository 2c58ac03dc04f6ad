"""`/v1/jobs/{job}/labels`: label a person's scan again with labels that were corrected by hand."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Response

from ..mending import RelabelOrder, submit_relabelling
from ..uploads import find_upload
from .access import AppStateDependency, Submitter, find_own
from .jobs import find_realm, show_created
from .schemas import LabelsIn

router = APIRouter(tags=["jobs"])


@router.post(
    "/jobs/{job}/labels", status_code=202, summary="Label a person again with corrected labels.",
    responses=show_created(),
)  # fmt: skip
def mend_labels(job: str, payload: LabelsIn, response: Response, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Queue a new job for the same scan, with labels for the points of the job's `segmented.ply`; the old job stays.

    The same labels again are the same job: 200, not 202.
    """
    row = find_own(rooms, caller, job)
    kept = find_upload(rooms.database, caller.key, payload.points, "labels")
    with rooms.copying() as folder:
        points = rooms.store.copy(kept.sha256, folder / "points.npy")
        done = submit_relabelling(rooms, row, RelabelOrder(points, caller.key, caller.quota, find_realm(rooms, caller)))
    response.headers["location"] = f"/v1/jobs/{done.job}"
    response.status_code = 202 if done.is_new else 200
    return {"job": done.job, "state": done.state, "is_new": done.is_new}
