"""Judge the outcome of one raw scan: the right garments, a refusal, a doubt, or a wrong result without a warning."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum

from ...core.people.part import Part

MIN_FOUND_OVERLAP = 0.5
"""Least share of its true points (intersection over union) at which a garment counts as found. Below it most of what is
recovered is not the garment."""


class Outcome(Enum):
    """Outcome of a scan; only `WRONG` misleads."""

    RIGHT = "right"
    DOUBTFUL = "doubtful"
    REFUSED = "refused"
    WRONG = "wrong"


def judge_outcome(
    truth: Mapping[Part, str], found: Mapping[Part, str], overlaps: Mapping[str, float], code: str | None, refused: bool
) -> Outcome:
    """Judge one labelling.

    Args:
        truth: Category of each garment that is worn.
        found: Category of each garment that was found.
        overlaps: Intersection over union of each part by its word.
        code: Code of the refusal, or of the labelling's own doubt; None if it is sure.
        refused: Whether nothing was delivered.
    """
    if refused:
        return Outcome.REFUSED
    if code is not None:
        return Outcome.DOUBTFUL
    right = dict(truth) == dict(found) and all(overlaps.get(part.word, 0.0) >= MIN_FOUND_OVERLAP for part in truth)
    return Outcome.RIGHT if right else Outcome.WRONG
