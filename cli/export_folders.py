"""The garments of a person, or of a tag, and the folder of each."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..service.backend import Backend
    from ..service.records import Job, JobReport

RECOVER = "recover"
"""Kind of the jobs that recover a garment."""


def find_tagged(backend: Backend, tag: str) -> dict[str, str]:
    """Return the recovered garments with a tag: their jobs by folders."""
    from ..service.query import MAX_QUERY_ROWS, JobQuery
    from ..service.states import State
    from .terminal import print_note

    terms = {"tag": tag, "kind": RECOVER, "state": State.SUCCEEDED.value}
    found = backend.find_jobs(JobQuery(terms, sort="created", limit=MAX_QUERY_ROWS))
    if not found:
        print_note(f"no recovered garment has the tag {tag}.")
    return name_folders(backend, found)


def find_garments(backend: Backend, job: JobReport) -> dict[str, str]:
    """Return the recovered garments of a person's job by folders; none if it has none below it."""
    from ..service.states import State

    below = backend.find_jobs_by_id([child.job for child in job.children])
    done = [one for one in below if one.kind == RECOVER and one.state == State.SUCCEEDED]
    return name_folders(backend, done)


def name_folders(backend: Backend, jobs: Iterable[Job]) -> dict[str, str]:
    """Return jobs by names of folders: person and garment, with the job's id where two would be alike."""
    from ..service.submission import own_name

    ordered = list(jobs)
    roots = {one.id: one.name for one in backend.find_jobs_by_id(sorted({one.family for one in ordered}))}
    found: dict[str, str] = {}
    for one in ordered:
        root = roots.get(one.family, "")
        name = own_name(f"{root}_{one.name}.job" if one.parent else f"{one.name}.job")
        found[f"{name}_{one.id}" if name in found else name] = one.id
    return found
