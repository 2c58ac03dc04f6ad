"""`/results/ID`: what a job found, in 3D beside its pattern."""

from __future__ import annotations

from fastapi import Response

from ..api.access import RoomsOf, find_own
from .markup import html
from .page_route import make_router
from .session import VisitorOf
from .shell import draw_shell

router = make_router()


@router.get("/results/{job}")
def show_result(job: str, rooms: RoomsOf, visitor: VisitorOf) -> Response:
    """Return the page of one result."""
    row = find_own(rooms, visitor.caller, job)
    content = html('<h1>{}</h1><div id="result" data-job="{}"></div>', row.name, row.id)
    return draw_shell(row.name, content, visitor, ["result.js"])
