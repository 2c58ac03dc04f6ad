"""Marks of notches along the edges of a pattern, alike on both sides of a seam."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ..pattern import EdgeRef, Pattern
from .piece import NotchPurpose

GATHER_PARTS = (0.25, 0.5, 0.75)
"""Fractions at which a gathered seam is matched, so that the fullness is spread evenly."""

NOTCH_FRACTION_TOLERANCE = 1e-6
"""Difference between the fractions of two notches [share of the edge's length] below which they are one."""


@dataclass(frozen=True)
class Mark:
    """Describe a notch of an edge before its placement: fraction of the edge's length, purpose, 1 or 2 cuts."""

    at: float
    purpose: NotchPurpose
    count: int


def collect_marks(pattern: Pattern) -> dict[EdgeRef, tuple[Mark, ...]]:
    """Return the notches of each edge that has some: those of either side of its seam, and those of gathers. Notches of
    a seam of the back are double, which distinguishes back from front."""
    by_edge: dict[EdgeRef, list[float]] = {}
    for panel in pattern.panels:
        for edge, at in panel.notches:
            by_edge.setdefault(EdgeRef(panel.name, edge), []).append(float(at))
    marks = {ref: tuple(Mark(at, NotchPurpose.MATCH, 1) for at in ats) for ref, ats in by_edge.items()}
    for seam in pattern.seams:
        turned = [1.0 - at if seam.reversed else at for at in by_edge.get(seam.b, [])]
        found = [(at, NotchPurpose.MATCH) for at in (*by_edge.get(seam.a, []), *turned)]
        if seam.gathered:
            found += [(at, NotchPurpose.GATHER) for at in GATHER_PARTS]
        count = 2 if _is_of_back(pattern, seam.a.panel, seam.b.panel) else 1
        kept: list[Mark] = []
        for at, purpose in found:
            if all(abs(at - mark.at) > NOTCH_FRACTION_TOLERANCE for mark in kept):
                kept.append(Mark(at, purpose, count))
        if kept:
            marks[seam.a] = tuple(sorted(kept, key=lambda mark: mark.at))
            marks[seam.b] = turn_marks(marks[seam.a]) if seam.reversed else marks[seam.a]
    return marks


def turn_marks(marks: tuple[Mark, ...]) -> tuple[Mark, ...]:
    """Return the marks of a reversed edge."""
    return tuple(Mark(1.0 - mark.at, mark.purpose, mark.count) for mark in marks[::-1])


def _is_of_back(pattern: Pattern, *names: str) -> bool:
    """Return whether some of a seam's panels are named as the back, and none as the front."""
    words = [{*re.split(r"[\W_]+", name.lower())} for name in names]
    return any("back" in one for one in words) and not any("front" in one for one in words)
