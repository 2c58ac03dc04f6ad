"""`/v1/jobs/{job}/labels` and `/wearing`: label a person's scan again, with corrected labels or in another outfit."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Response

from ..mending import submit_corrected, submit_in_outfit
from ..uploads import find_upload
from .access import AppStateDependency, Submitter, find_own
from .jobs import answer_submission, make_owner_terms, show_created
from .schemas import LabelsIn, WearingIn

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
        done = submit_corrected(rooms, row, points, make_owner_terms(rooms, caller))
    return answer_submission(response, done)


@router.post(
    "/jobs/{job}/wearing", status_code=202, summary="Label a person again in another outfit.",
    responses=show_created(),
)  # fmt: skip
def set_wearing(job: str, payload: WearingIn, response: Response, rooms: AppStateDependency, caller: Submitter) -> Any:
    """Queue a new job for the same scan that finds exactly these garments; the old job stays.

    `details.outfits` of the old job has the readings of the outfit, the likeliest first. The same outfit again is the
    same job: 200, not 202.
    """
    row, owner = find_own(rooms, caller, job), make_owner_terms(rooms, caller)
    return answer_submission(response, submit_in_outfit(rooms, row, payload.wearing, owner))
