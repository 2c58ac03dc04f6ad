"""`/v1/query`: find jobs by their results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query

from ..query import MAX_QUERY_OFFSET, MAX_QUERY_ROWS, JobQuery
from .access import AppStateDependency, Reader
from .answers import Jobs
from .jobs import EXAMPLE, JobFilter, Words, answer_query
from .problems import show_answer

router = APIRouter(tags=["results"])


@dataclass(frozen=True)
class Page:
    """Describe which of the found jobs are returned."""

    limit: Annotated[int, Query(ge=1, le=MAX_QUERY_ROWS)] = 50
    offset: Annotated[int, Query(ge=0, le=MAX_QUERY_OFFSET)] = 0


@router.get("/query", summary="Find jobs by their results.", responses=show_answer({"jobs": [EXAMPLE]}, model=Jobs))
def query_jobs(
    rooms: AppStateDependency,
    caller: Reader,
    job_filter: Annotated[JobFilter, Depends()],
    garment: Words = None,
    fabric: Words = None,
    where: Annotated[list[str], Query(max_length=20, examples=[["surface_rms_mm.t2s < 4"]])] = [],  # noqa: B006
    sort: Annotated[str, Query(max_length=200)] = "-created",
    page: Annotated[Page, Depends()] = Page(),
) -> Any:
    """Return the caller's jobs that meet every condition; names and operators come from lists, values are bound."""
    named = {"garment": garment, "fabric": fabric}
    chosen = job_filter.chosen | {name: value for name, value in named.items() if value is not None}
    return answer_query(rooms, caller, JobQuery(chosen, [text[:1000] for text in where], sort, page.limit, page.offset))
