"""Panels that a maker cuts in proportion: a front and its back, whose side seam no scan shows."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from ..pattern import Pattern, panel_area

ALIKE = 0.6
"""Least ratio of areas of panels that belong together; backs are up to 1.5 times their fronts (trousers)."""


@dataclass(frozen=True)
class Proportions:
    """Hold the ratios of area that grading a garment keeps.

    Attributes:
        pairs: Names of panels that are sewn together along two seams or more.
        ratios: ln of the area of the first by that of the second, shape [pair_count].
    """

    pairs: tuple[tuple[str, str], ...]
    ratios: np.ndarray

    def linearise(self, pattern: Pattern) -> tuple[np.ndarray, np.ndarray]:
        """Give what each ratio misses, shape [pair_count], and its rates, shape [pair_count, 2 point_count].

        The rates are those of the polygons of control points: curves follow their chords.
        """
        missing = np.zeros(len(self.pairs))
        rates = np.zeros((len(self.pairs), 2 * len(pattern.points)))
        for i, (first, second) in enumerate(self.pairs):
            areas = [panel_area(pattern.panel(name)) for name in (first, second)]
            missing[i] = self.ratios[i] - np.log(areas[0] / areas[1])
            rates[i] = _area_rate(pattern, first) - _area_rate(pattern, second)
        return missing, rates


def find_proportions(like: Pattern) -> Proportions:
    """Find the panels of a base pattern that are cut in proportion, and their ratios of area.

    Front and back are sewn along two seams or more and are alike in area. Where a smooth surface hides the seam
    between them the scan cannot say how its girth is shared out; the base pattern can, and grading keeps it.
    """
    seams = Counter(tuple(sorted((s.a.panel, s.b.panel))) for s in like.seams if s.a.panel != s.b.panel)
    pairs, ratios = [], []
    for (first, second), count in sorted(seams.items()):
        ratio = panel_area(like.panel(first)) / panel_area(like.panel(second))
        if count >= 2 and ALIKE < ratio < 1.0 / ALIKE:
            pairs.append((first, second))
            ratios.append(float(np.log(ratio)))
    return Proportions(tuple(pairs), np.array(ratios))


def _area_rate(pattern: Pattern, name: str) -> np.ndarray:
    """Give d ln A / d(x0, y0, x1, ...) of a panel's polygon of control points [1/m], shape [2 point_count]."""
    start = dict(zip((panel.name for panel in pattern.panels), pattern.point_starts, strict=False))[name]
    points = pattern.panel(name).points
    after, before = np.roll(points, -1, axis=0), np.roll(points, 1, axis=0)
    rates = np.zeros((len(pattern.points), 2))
    turned = np.stack([after[:, 1] - before[:, 1], before[:, 0] - after[:, 0]], axis=1)
    rates[int(start) : int(start) + len(points)] = 0.5 * turned / panel_area(pattern.panel(name))
    return rates.ravel()
