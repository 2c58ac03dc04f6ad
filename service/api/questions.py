"""`/v1/query`: find jobs by what they found."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query

from ..query import MOST, Condition, find_jobs, parse_conditions
from .access import Reader, RoomsOf
from .answers import Jobs
from .jobs import EXAMPLE, show_job
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
    given = {"garment": garment, "state": state, "fabric": fabric}
    conditions = [Condition(name, "=", value) for name, value in given.items() if value is not None]
    for text in where:
        conditions += parse_conditions(text[:1000])
    owner = None if caller.sees_all else caller.key
    rows = find_jobs(rooms.database, conditions, sort, limit, owner=owner)
    return {"jobs": [show_job(rooms, row) for row in rows]}
