"""`/v1/scans/{sha256}/inspection`: what is detected in an uploaded scan, before a job is created."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, Query, Request

from ...core.recover.settings import STATURE_RANGE
from ...core.run.sandbox import IsStopped
from ...core.run.units import UnitName
from ..inspection import inspect_scan
from ..submission import clean_name
from ..uploads import find_upload
from .access import AppStateDependency, Submitter
from .answers import Inspection
from .problems import show_answer
from .schemas import Sha256

router = APIRouter(tags=["files"])

EXAMPLE = {
    "as": "person",
    "is_sure": True,
    "scan": {
        "name": "anna", "units": "m", "up": "y", "is_cloud": False, "vertex_count": 30587, "face_count": 59882,
        "file_count": 30589, "extent_m": [1.201, 1.668, 0.3149], "has_colours": True, "has_labels": False,
        "notes": ["Dropped 7 points as flyers."],
    },
    "body": {"source": "scan:anna", "height_m": 1.663, "skin_rms_mm": 2.95},
    "category": None,
    "contours_m": None,
    "remarks": [],
    "needs": None,
}  # fmt: skip


@dataclass(frozen=True)
class InspectionQuery:
    """Describe options of an order that change how a scan is read."""

    given_as: Annotated[Literal["person", "garment"] | None, Query(alias="as")] = None
    body: Annotated[str | None, Query(max_length=200, examples=["builtin:female,height=1.70"])] = None
    units: UnitName | None = None
    up: Literal["y", "z", "-y", "-z", "x", "-x"] | None = None
    height: Annotated[float | None, Query(ge=STATURE_RANGE[0], le=STATURE_RANGE[1], examples=[1.70])] = None
    is_quick: Annotated[bool, Query(alias="quick")] = False


@router.get(
    "/scans/{sha256}/inspection", name="inspect_scan", summary="Show what is detected in an uploaded scan.",
    responses=show_answer(EXAMPLE, model=Inspection),
)  # fmt: skip
async def inspect(
    sha256: Sha256,
    request: Request,
    rooms: AppStateDependency,
    caller: Submitter,
    query: Annotated[InspectionQuery, Depends()],
) -> Any:
    """Read a scan as a job's first stage does; nothing is queued or stored.

    With `quick` only the file is read (2 s of CPU time), a person is recognised by the height, and `is_sure` may be
    false. Otherwise the wearer is fitted too (7 s). `needs` has the code of what is missing for a job.
    """
    options: dict[str, Any] = {"given_as": query.given_as, "body": query.body, "units": query.units, "up": query.up}
    options |= {"height": query.height, "is_quick": query.is_quick}

    def work(is_stopped: IsStopped) -> Any:
        row = find_upload(rooms.database, caller.key, sha256, "scans")
        with rooms.copying() as folder:
            path = rooms.store.copy(row.sha256, folder / clean_name(row.name))
            return inspect_scan(path, options, is_stopped)

    return await rooms.limited.run(request, caller.key, work)
