"""Choose between alternatives that were all tried."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

from .finding import Finding, FindingKind
from .hooks import Hooks

T = TypeVar("T")

Score = float | tuple[float, ...]
"""Scores are compared as Python compares them: of tuples the first difference decides."""


def best(question: str, candidates: Mapping[str, T], score: Callable[[T], Score], hooks: Hooks) -> T:
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
    if len(candidates) == 1:
        return next(iter(candidates.values()))
    scores = {name: score(one) for name, one in candidates.items()}
    taken = min(scores, key=scores.__getitem__)
    rounded = {name: _round(value) for name, value in scores.items()}
    hooks.report(Finding(FindingKind.CHOICE, evidence={"of": question, "taken": taken, "scores": rounded}))
    return candidates[taken]


def _round(score: Score) -> float | list[float]:
    """Return a score with four digits, as JSON values."""
    return [float(f"{one:.4g}") for one in score] if isinstance(score, tuple) else float(f"{score:.4g}")
