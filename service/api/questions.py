"""`/v1/query`: find jobs by what they found."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query

from ..query import MOST, JobQuery, find_jobs
from .access import Reader, RoomsOf
from .answers import Jobs
from .jobs import EXAMPLE, show_jobs
from .problems import show_answer
from .schemas import Text

router = APIRouter(tags=["results"])

Words = Annotated[Text | None, Query(max_length=255)]


@router.get("/query", summary="Find jobs by what they found.", responses=show_answer({"jobs": [EXAMPLE]}, model=Jobs))
def query(
    rooms: RoomsOf,
    caller: Reader,
    garment: Words = None,
    state: Words = None,
    fabric: Words = None,
    where: Annotated[list[str], Query(max_length=20, examples=[["surface_rms_mm.t2s < 4"]])] = [],  # noqa: B006
    sort: Annotated[str, Query(max_length=200)] = "-created",
    limit: Annotated[int, Query(ge=1, le=MOST)] = 50,
) -> Any:
    """Give the caller's jobs that meet every condition; names and operators come from lists, values are bound."""
    named = {"garment": garment, "state": state, "fabric": fabric}
    given = {name: value for name, value in named.items() if value is not None}
    wanted = JobQuery(given, [text[:1000] for text in where], sort, limit)
    owner = None if caller.sees_all else caller.key
    return show_jobs(rooms, find_jobs(rooms.database, wanted.conditions, sort, limit, owner))
