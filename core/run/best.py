"""Choose between alternatives that were all tried."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TypeVar

from .finding import Finding, FindingKind
from .hooks import Hooks

T = TypeVar("T")

Score = float | tuple[float, ...]
"""Scores are compared as Python compares them: of tuples the first difference decides."""


def choose_best(question: str, candidates: Mapping[str, T], score: Callable[[T], Score], hooks: Hooks) -> T:
    """Return the candidate with the lowest score, the first of equal ones, and report all scores.

    A candidate that stands alone is taken without its score being computed.

    Args:
        question: What is chosen, as the manifest names it.
        candidates: By the names that the manifest shows.
        score: Measures one of them; smaller is better.
        hooks: Take the finding.

    Raises:
        ValueError: where there is no candidate.
    """
    if not candidates:
        raise ValueError(f"no candidate for {question}")
    if len(candidates) == 1:
        return next(iter(candidates.values()))
    scores = {name: score(one) for name, one in candidates.items()}
    taken = min(scores, key=scores.__getitem__)
    rounded = {name: _round(value) for name, value in scores.items()}
    hooks.report(Finding(FindingKind.CHOICE, evidence={"of": question, "taken": taken, "scores": rounded}))
    return candidates[taken]


def _round(score: Score) -> float | list[float | None] | None:
    """Return a score with four digits, as JSON values: what is not finite as None."""
    if isinstance(score, tuple):
        return [_round_one(one) for one in score]
    return _round_one(score)


def _round_one(value: float) -> float | None:
    return float(f"{value:.4g}") if math.isfinite(value) else None
