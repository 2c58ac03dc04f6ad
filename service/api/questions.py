"""`/v1/query`: find jobs by their results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query

from ..query import MAX_QUERY_ROWS, JobQuery
from .access import AppStateDependency, Reader
from .answers import Jobs
from .jobs import PAGE, JobFilter, Paging, Words, answer_query
from .problems import show_answer

router = APIRouter(tags=["results"])


@dataclass(frozen=True)
class QueryFilter(JobFilter):
    """Describe a filter of jobs by their fields and by what was made."""

    garment: Words = None
    fabric: Words = None


@router.get("/query", summary="Find jobs by their results.", responses=show_answer(PAGE, model=Jobs))
def query_jobs(
    rooms: AppStateDependency,
    caller: Reader,
    job_filter: Annotated[QueryFilter, Depends()],
    where: Annotated[list[str], Query(max_length=20, examples=[["surface_rms_mm.t2s < 4"]])] = [],  # noqa: B006
    sort: Annotated[str, Query(max_length=200)] = "-created",
    limit: Annotated[int, Query(ge=1, le=MAX_QUERY_ROWS)] = 50,
    *,
    paging: Annotated[Paging, Depends()],
) -> Any:
    """Return a page of the caller's jobs that meet every condition; jobs that are added shift no page."""
    wheres = [text[:1000] for text in where]
    query = JobQuery(job_filter.chosen, wheres, sort, limit, paging.offset, paging.cursor)
    return answer_query(rooms, caller, query, paging.detail == "full")
