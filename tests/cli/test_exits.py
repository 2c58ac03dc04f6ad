"""What a script learns from an exit status."""

from __future__ import annotations

from itertools import pairwise

import pytest
from garmentq.cli import exits
from garmentq.service.records import Failure, Job
from garmentq.service.states import State


def make_job(state: State, verdict: str | None = None, bad_input: bool = False) -> Job:
    """Return a job that ended so."""
    error = Failure("x", "x") if state == State.FAILED else None
    return Job("a", "a", state, "", 1.0, 1, 0.0, 0.0, 1.0, error, bad_input, "cpu", 0, "recover", "a", None, verdict)


@pytest.mark.parametrize(
    ("verdict", "status", "lenient"), [("pass", 0, 0), ("doubtful", 0, 0), ("fail", 10, 0), (None, 0, 0)]
)
def test_only_a_failed_check_shows(verdict: str | None, status: int, lenient: int) -> None:
    """Fails if a doubtful result stopped a script, or one that must not be used passed for good."""
    job = make_job(State.SUCCEEDED, verdict)
    assert (exits.job_status(job), exits.job_status(job, is_lenient=True)) == (status, lenient)


def test_a_job_without_a_result_counts_more_than_a_failed_check() -> None:
    """Fails if statuses were compared as numbers: 10 is larger than 4, and milder."""
    poor, refused = make_job(State.SUCCEEDED, "fail"), make_job(State.FAILED, bad_input=True)
    assert exits.worst(exits.job_status(job) for job in (poor, refused)) == exits.BAD_INPUT
    assert exits.worst([exits.OK, exits.FAILED_CHECK]) == exits.FAILED_CHECK
    assert exits.worst([]) == exits.OK


def test_the_order_names_every_status_once() -> None:
    """Fails if a status were added without its place."""
    known = {value for name, value in vars(exits).items() if name.isupper() and isinstance(value, int)}
    assert set(exits.SEVERITY) == known and len(exits.SEVERITY) == len(known)
    assert all(exits.worst(pair) == pair[1] for pair in pairwise(exits.SEVERITY))
