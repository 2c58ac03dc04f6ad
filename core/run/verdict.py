"""Verdicts on results: each gate judges one number, and a result is as good as its worst gate."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Describe whether a result may be used, from best to worst."""

    PASS = "pass"
    """May be used as it is."""
    DOUBTFUL = "doubtful"
    """May be used after a check by a person."""
    FAIL = "fail"
    """Must not be used before the problem in the message is solved."""


@dataclass(frozen=True)
class Gate:
    """Describe the verdict on one quality of a result.

    Attributes:
        name: Stable name, `penetration`.
        verdict: The verdict on the value.
        value: The measured value.
        limit: Where `fail` begins.
        message: One sentence with the next step.
    """

    name: str
    verdict: Verdict
    value: float
    limit: float
    message: str


def worst_verdict(verdicts: Iterable[Verdict]) -> Verdict:
    """Return the worst of some verdicts; `pass` where there is none."""
    order = list(Verdict)
    return max(verdicts, key=order.index, default=Verdict.PASS)
