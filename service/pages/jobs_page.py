"""`/`: the jobs, and a place to drop a scan."""

from __future__ import annotations

from fastapi import Response

from .markup import html
from .page_route import make_router
from .session import VisitorOf
from .shell import draw_shell

router = make_router()


@router.get("/")
def show_jobs(visitor: VisitorOf) -> Response:
    """Return the page of all jobs."""
    return draw_shell("Jobs", html('<h1>Jobs</h1><div id="jobs"></div>'), visitor, ["jobs.js"], "/")
