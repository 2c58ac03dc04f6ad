"""Marks of notches along the edges of a pattern, alike on both sides of a seam."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..curves import edge_length
from ..outline import MIN_NOTCHED_SEAM_LENGTH
from ..panel_parts import Side, find_side
from ..pattern import EdgeRef, Pattern, Seam
from ..seams import find_sewn_partners, seam_lengths
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
    """Return the notches of each edge that has some: those of either side of its seam, at half the length of a long
    seam that has none, and those of gathers. Notches of a seam of the back are double, which distinguishes back from
    front."""
    by_edge: dict[EdgeRef, list[float]] = {}
    for panel in pattern.panels:
        for edge, at in panel.notches:
            by_edge.setdefault(EdgeRef(panel.name, edge), []).append(float(at))
    marks = {ref: tuple(Mark(at, NotchPurpose.MATCH, 1) for at in ats) for ref, ats in by_edge.items()}
    gathers = _find_gather_marks(pattern)
    for seam, lengths in zip(pattern.seams, seam_lengths(pattern), strict=True):
        turned = [1.0 - at if seam.reversed else at for at in by_edge.get(seam.b, [])]
        found = [(at, NotchPurpose.MATCH) for at in (*by_edge.get(seam.a, []), *turned)]
        if seam.gathered:
            found += [(at, NotchPurpose.GATHER) for at in gathers.get(seam.a, [])]
        elif not found and lengths.min() > MIN_NOTCHED_SEAM_LENGTH:
            found.append((0.5, NotchPurpose.MATCH))
        count = 2 if _is_of_back(pattern, seam.a.panel, seam.b.panel) else 1
        kept: list[Mark] = []
        for at, purpose in found:
            if all(abs(at - mark.at) > NOTCH_FRACTION_TOLERANCE for mark in kept):
                kept.append(Mark(at, purpose, count))
        if kept:
            marks[seam.a] = tuple(sorted(kept, key=lambda mark: mark.at))
            marks[seam.b] = turn_marks(marks[seam.a]) if seam.reversed else marks[seam.a]
    return marks


def find_gathered_runs(pattern: Pattern) -> tuple[tuple[Seam, ...], ...]:
    """Return the gathered seams in runs, in order, side `a` of all on one panel and side `b` on another: those of
    consecutive edges that are sewn to consecutive edges of one panel are one run that a file has cut."""
    seams = [seam for seam in pattern.seams if seam.gathered]
    ordered = [seam if seam.a.panel <= seam.b.panel else replace(seam, a=seam.b, b=seam.a) for seam in seams]
    by_side, partners = {seam.a: seam for seam in ordered}, find_sewn_partners(pattern)
    after = {}
    for seam in ordered:
        following = by_side.get(_step(pattern, partners, seam.a, 1))
        if following is not None and following.b == _step(pattern, partners, seam.b, -1 if seam.reversed else 1):
            after[seam] = following
    runs, continued = [], set(after.values())
    for seam in ordered:
        if seam not in continued:
            run = [seam]
            while run[-1] in after:
                run.append(after[run[-1]])
            runs.append(tuple(run))
    return tuple(runs)


def _step(pattern: Pattern, partners: dict[EdgeRef, EdgeRef], ref: EdgeRef, by: int) -> EdgeRef:
    """Return the edge after (by = 1) or before (-1) one of a panel, beyond a dart between."""
    count = len(pattern.panel(ref.panel).edges)
    beside, beyond = (EdgeRef(ref.panel, (ref.edge + k * by) % count) for k in (1, 2))
    return EdgeRef(ref.panel, (ref.edge + 3 * by) % count) if partners.get(beside) == beyond else beside


def _find_gather_marks(pattern: Pattern) -> dict[EdgeRef, list[float]]:
    """Return the fractions of each edge's length at which a quarter of its gathered run ends."""
    found: dict[EdgeRef, list[float]] = {}
    for run in find_gathered_runs(pattern):
        ends = np.cumsum([0.0, *(edge_length(pattern.panel(seam.a.panel), seam.a.edge) for seam in run)])
        for at in ends[-1] * np.array(GATHER_PARTS):
            k = min(int(np.searchsorted(ends, at, side="right")) - 1, len(run) - 1)
            share = float((at - ends[k]) / (ends[k + 1] - ends[k]))
            found.setdefault(run[k].a, []).append(share)
            found.setdefault(run[k].b, []).append(1.0 - share if run[k].reversed else share)
    return found


def turn_marks(marks: tuple[Mark, ...]) -> tuple[Mark, ...]:
    """Return the marks of a reversed edge."""
    return tuple(Mark(1.0 - mark.at, mark.purpose, mark.count) for mark in marks[::-1])


def _is_of_back(pattern: Pattern, *names: str) -> bool:
    """Check whether some of a seam's panels are behind the wearer, and none in front."""
    sides = {find_side(pattern.panel(name)) for name in names}
    return Side.BACK in sides and Side.FRONT not in sides
