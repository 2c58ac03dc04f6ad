"""The area by which sister panels are compared: openings closed, seams straight, hems as they are drawn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..pattern import EdgeRef, Panel, Pattern, polygon_area
from ..pattern.curves import edge_area

STRAIGHT = 1e-3
"""Area beside a row of edges, in squares of the distance between its ends, below which it is straight: a hem that is a
rounding hollow is a hem."""


@dataclass(frozen=True)
class ClosedArea:
    """Compute the area of a panel without what its necklines, armholes and caps add or take.

        A = P(corners) + sum over hems of e |chord|^2

    An opening that cuts into its panel (a neckline, a waist, an armhole without a sleeve) counts as the straight line
    between its ends, for it may be as deep as it is. Seams count as their chords. A hem counts in full: of a circle's
    halves nothing else lies beside the line that their corners are on.

    Notation:
        P: Area of a polygon [m2].
        e: Area between an edge and its chord in squared chords, `edge_area`.

    Attributes:
        panel: The panel's name.
        corners: Its points, those within such openings left out, shape [corner_count].
        hems: Its other open edges.
    """

    panel: str
    corners: np.ndarray
    hems: tuple[int, ...]

    @classmethod
    def of(cls, pattern: Pattern, name: str) -> ClosedArea:
        """Return what counts of a panel."""
        panel, inside, hems = pattern.panel(name), set[int](), list[int]()
        for row in _open_rows(pattern, panel):
            corners = panel.points[[*row, (row[-1] + 1) % len(panel.edges)]]
            outside = polygon_area(corners) + sum(_beside(panel, i) for i in row)
            if outside < -STRAIGHT * float(((corners[-1] - corners[0]) ** 2).sum()):
                inside.update(row[1:])
            else:
                hems += row
        return cls(name, np.array([i for i in range(len(panel.points)) if i not in inside]), tuple(hems))

    def measure(self, pattern: Pattern) -> float:
        """Return the area [m2]."""
        panel = pattern.panel(self.panel)
        return polygon_area(panel.points[self.corners]) + sum(_beside(panel, i) for i in self.hems)

    def rates(self, pattern: Pattern) -> np.ndarray:
        """Return the derivative of the area by all points [m], shape [point_count, 2]."""
        start, panel = pattern.first_points[self.panel], pattern.panel(self.panel)
        rates = np.zeros((len(pattern.points), 2))
        rates[start + self.corners] = polygon_rates(panel.points[self.corners])
        for i in self.hems:
            end = (i + 1) % len(panel.points)
            change = 2.0 * edge_area(panel.edges[i]) * (panel.points[end] - panel.points[i])
            rates[start + end] += change
            rates[start + i] -= change
        return rates

    def curves(self) -> Iterator[EdgeRef]:
        """Yield the edges whose curves count."""
        return (EdgeRef(self.panel, i) for i in self.hems)


def polygon_rates(points: np.ndarray) -> np.ndarray:
    """Return the derivative of a polygon's area by its points [m], shape [point_count, 2]."""
    apart = 0.5 * (np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0))
    return np.column_stack([apart[:, 1], -apart[:, 0]])


def _open_rows(pattern: Pattern, panel: Panel) -> Iterator[list[int]]:
    """Yield the edges of a panel that are sewn to nothing, row by row."""
    sewn = {ref.edge for seam in pattern.seams for ref in (seam.a, seam.b) if ref.panel == panel.name}
    count = len(panel.edges)
    for start in range(count):
        if start not in sewn and (start - 1) % count in sewn:
            row = [start]
            while (row[-1] + 1) % count not in sewn:
                row.append((row[-1] + 1) % count)
            yield row


def _beside(panel: Panel, index: int) -> float:
    """Return the area between an edge and its chord [m2]."""
    chord = panel.points[(index + 1) % len(panel.points)] - panel.points[index]
    return edge_area(panel.edges[index]) * float(chord @ chord)
