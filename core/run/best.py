"""Choose the best of several candidates."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TypeVar

from .finding import Finding, FindingKind
from .hooks import Hooks

T = TypeVar("T")

Score = float | tuple[float, ...]
"""A score; tuples are compared by their first difference, as Python does."""


def choose_best(question: str, candidates: Mapping[str, T], score: Callable[[T], Score], hooks: Hooks) -> T:
    """Return the candidate with the lowest score, the first of equal ones, and report all scores.

    A single candidate is returned without computing its score.

    Args:
        question: What is chosen, as named in the manifest.
        candidates: By their names in the manifest.
        score: Computes the score of one of them; smaller is better.
        hooks: Receive the finding.

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
    """Return a score with four digits, as JSON values: None where it is not finite."""
    if isinstance(score, tuple):
        return [_round_one(one) for one in score]
    return _round_one(score)


def _round_one(value: float) -> float | None:
    return float(f"{value:.4g}") if math.isfinite(value) else None
