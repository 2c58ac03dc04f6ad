"""Verdicts on results: each gate judges one number, and a result is as good as its worst gate."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Describe what a result may be used for, from best to worst."""

    PASS = "pass"
    """As it is."""
    DOUBTFUL = "doubtful"
    """After somebody looked at it."""
    FAIL = "fail"
    """Not before what the message names was mended."""


@dataclass(frozen=True)
class Gate:
    """Judge one quality of a result.

    Attributes:
        name: Stable name, `penetration`.
        verdict: What the value means.
        value: What was measured.
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
