"""Compare a version of a pattern with the recovered one, panel by panel and seam by seam."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from ...garment.pattern import Pattern, Seam
from ...garment.seams import seam_lengths
from ...judge.comparison import Comparison, compare_patterns
from ...run.units import MM_PER_M


@dataclass(frozen=True)
class SeamChange:
    """Describe the change of a seam that both versions have.

    Attributes:
        seam: Its number in the version.
        was: Its number in the recovered pattern.
        a, b: Panel and number of the edge of both sides, in the version.
        change_mm: Increase in length of each side [mm].
    """

    seam: int
    was: int
    a: tuple[str, int]
    b: tuple[str, int]
    change_mm: tuple[float, float]


@dataclass(frozen=True)
class PatternDifference:
    """Describe the difference of a version of a pattern from the recovered one.

    Attributes:
        panels: Panel by panel, the version first; panels of one name are pairs.
        seams: The seams of both.
        seams_added, seams_removed: Numbers of the seams only in the version, and only in the recovered pattern.
    """

    panels: Comparison
    seams: tuple[SeamChange, ...]
    seams_added: tuple[int, ...]
    seams_removed: tuple[int, ...]


def compare_versions(version: Pattern, recovered: Pattern) -> PatternDifference:
    """Compare a version of a pattern with the recovered one.

    Seams correspond where they join edges of the same panels with the same labels, repeated ones in their order. Edges
    without labels are compared by their numbers, which is correct unless a point was added or removed before them.

    Args:
        version: The edited pattern.
        recovered: The recovered pattern.
    """
    now, was = ([seam_key(pattern, seam) for seam in pattern.seams] for pattern in (version, recovered))
    lengths = [MM_PER_M * seam_lengths(pattern) for pattern in (version, recovered)]
    places = {key: number for number, key in enumerate(_number_repeats(was))}
    changes, added = [], []
    for number, key in enumerate(_number_repeats(now)):
        if key not in places:
            added.append(number)
            continue
        old = places.pop(key)
        seam, change = version.seams[number], lengths[0][number] - lengths[1][old]
        a, b = ((ref.panel, ref.edge) for ref in (seam.a, seam.b))
        changes.append(SeamChange(number, old, a, b, (float(change[0]), float(change[1]))))
    panels = compare_patterns(version, recovered)
    return PatternDifference(panels, tuple(changes), tuple(added), tuple(sorted(places.values())))


def seam_key(pattern: Pattern, seam: Seam) -> tuple[tuple[str, str], ...]:
    """Return the key of a seam: for both sides the panel, and the edge's label or else its number."""
    sides = []
    for ref in (seam.a, seam.b):
        label = pattern.panel(ref.panel).edges[ref.edge].label
        sides.append((ref.panel, label or str(ref.edge)))
    return tuple(sides)


def _number_repeats(keys: list[tuple[tuple[str, str], ...]]) -> list[tuple[object, int]]:
    """Return keys each with the number of equal ones before it."""
    seen: Counter[object] = Counter()
    found: list[tuple[object, int]] = []
    for key in keys:
        found.append((key, seen[key]))
        seen[key] += 1
    return found
