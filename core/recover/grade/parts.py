"""Find which panels of a pattern belong together, and count seams regardless of how edges are split."""

from __future__ import annotations

from collections import Counter
from itertools import takewhile

import numpy as np

from ...garment.curves import edge_length
from ...garment.pattern import Panel, Pattern
from ...geometry.connectivity import find_components
from .flattening import MIN_GRADED_EDGE_LENGTH

MIN_MIRROR_LENGTH_RATIO = 0.99
"""Smallest ratio of lengths that mirror each other: equal up to the author's rounding."""


def count_seams(pattern: Pattern) -> Counter[tuple[str, str]]:
    """Count the seams between each two panels, by their names in order.

    Edges sewn to the same other panel with only darts or edges shorter than `MIN_GRADED_EDGE_LENGTH` between them are
    one seam: programs split a waist seam at each of its darts.
    """
    partner = _partners(pattern)
    sides: dict[tuple[str, str], list[int]] = {}
    for panel in pattern.panels:
        for other, count in _count_around(panel, partner).items():
            first, second = sorted((panel.name, other))
            sides.setdefault((first, second), []).append(count)
    return Counter({pair: min(counts) for pair, counts in sides.items()})


def find_parts(pattern: Pattern) -> np.ndarray:
    """Return each panel's part number, shape [panel_count]: panels sewn along two seams or more are graded as one."""
    at = {panel.name: i for i, panel in enumerate(pattern.panels)}
    pairs = [(at[a], at[b]) for (a, b), count in count_seams(pattern).items() if count >= 2]
    rows = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return find_components(len(at), rows[:, 0], rows[:, 1])[1]


def find_armhole_pairs(pattern: Pattern) -> tuple[tuple[tuple[int, int], tuple[int, int]], ...]:
    """Find the pairs of control points across from each other at both ends of a panel's two armholes.

    A panel of a part of several, such as front with back, has armholes if it is sewn to other parts along two stretches
    that mirror each other: one pair is across the shoulders, one across the chest. Numbers count the pattern's points.
    """
    part = dict(zip((panel.name for panel in pattern.panels), find_parts(pattern), strict=True))
    members = Counter(part.values())
    partner = _partners(pattern)
    found = []
    for panel, first in zip(pattern.panels, pattern.point_starts, strict=False):
        if members[part[panel.name]] < 2:
            continue
        sewn = [partner.get((panel.name, i)) for i in range(len(panel.edges))]
        differs = [name is not None and part[name] != part[panel.name] for name in sewn]
        stretches = _stretches(differs, [name == panel.name for name in sewn])
        for n, (start, end) in enumerate(stretches):
            for begin, close in stretches[n + 1 :]:
                if are_mirrored(panel.points, (start, end), (begin, close)):
                    at = int(first)
                    found.append(((at + end, at + begin), (at + close, at + start)))
    return tuple(found)


def _partners(pattern: Pattern) -> dict[tuple[str, int], str]:
    """Return the panel to which each sewn edge, by panel and number, is sewn."""
    partner = {}
    for seam in pattern.seams:
        partner[seam.a.panel, seam.a.edge] = seam.b.panel
        partner[seam.b.panel, seam.b.edge] = seam.a.panel
    return partner


def _stretches(differs: list[bool], dart: list[bool]) -> list[tuple[int, int]]:
    """Return first and last point of each run of edges sewn to other parts; darts within a run do not end it."""
    count = len(differs)
    runs = [differs[i] or dart[i] for i in range(count)]
    found = []
    for start in (i for i in range(count) if runs[i] and not runs[i - 1]):
        run = list(takewhile(lambda i: runs[i % count], range(start, start + count)))
        if any(differs[i % count] for i in run):
            found.append((start, (run[-1] + 1) % count))
    return found


def are_mirrored(points: np.ndarray, one: tuple[int, int], other: tuple[int, int]) -> bool:
    """Return whether two chords, traversed in turn, are the legs of an isosceles trapezium."""

    def alike(a: tuple[int, int], b: tuple[int, int]) -> bool:
        lengths = [float(np.linalg.norm(points[end] - points[start])) for start, end in (a, b)]
        return min(lengths) > MIN_MIRROR_LENGTH_RATIO * max(lengths)

    return alike(one, other) and alike((one[0], other[0]), (one[1], other[1]))


def _count_around(panel: Panel, partner: dict[tuple[str, int], str]) -> Counter[str]:
    """Count a panel's edges sewn to each other panel, those joined across darts or short edges as one."""
    sewn = [
        (i, partner.get((panel.name, i)))
        for i in range(len(panel.edges))
        if edge_length(panel, i) >= MIN_GRADED_EDGE_LENGTH
    ]
    sewn = [(i, name) for i, name in sewn if name != panel.name]
    count: Counter[str] = Counter()
    for n, (i, name) in enumerate(sewn):
        before, last = sewn[n - 1]
        bridged = last == name and (i - before) % len(panel.edges) != 1
        if name is not None:
            count[name] += 0 if bridged else 1
    return Counter({name: max(number, 1) for name, number in count.items()})


def edges_until(start: int, count: int, turn: int, stops: set[int]) -> list[int]:
    """Return the edges after one up to the next stop, forwards or backwards."""
    found, at = [], (start + turn) % count
    while at not in stops:
        found.append(at)
        at = (at + turn) % count
    return found
