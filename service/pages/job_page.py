"""`/jobs/ID`: how far a job is."""

from __future__ import annotations

from fastapi import Response

from ..api.access import RoomsOf, find_own
from .markup import html
from .page_route import make_router
from .session import VisitorOf
from .shell import draw_shell

router = make_router()


@router.get("/jobs/{job}")
def show_job(job: str, rooms: RoomsOf, visitor: VisitorOf) -> Response:
    """Return the page of one job."""
    row = find_own(rooms, visitor.caller, job)
    content = html('<h1>{}</h1><div id="job" data-job="{}"></div>', row.name, row.id)
    return draw_shell(row.name, content, visitor, ["job.js"])
