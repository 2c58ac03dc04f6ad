"""Compute the area by which sister panels are compared: between their corners, plus that of hems."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from ...garment.curves import chord, edge_area
from ...garment.pattern import EdgeRef, Panel, Pattern
from ...garment.polygon import polygon_area
from .parts import edges_until

MAX_STRAIGHT_AREA_RATIO = 1e-3
"""Ratio of the area beside a row of edges to the square of the distance between its ends, below which the row counts as
straight: a hem that is concave by rounding is a hem."""


@dataclass(frozen=True)
class ComparedArea:
    """Compute the area of a panel without that of the curves of necklines, armholes and caps.

        A = P(corners) + sum over hems of e |chord|^2
    The curves of seams, and of openings that cut into their panel (a neckline, a waist, an armhole without a sleeve),
    may have any depth. A hem counts in full: in half a circle there is no other area beside the line of its corners.

    Notation:
        P: Area of a polygon [m2].
        e: Area between an edge and its chord in squared chords, `edge_area`.

    Attributes:
        panel: The panel's name.
        hems: Its open edges that do not belong to an opening that cuts in.
    """

    panel: str
    hems: tuple[int, ...]

    @classmethod
    def of(cls, pattern: Pattern, name: str) -> ComparedArea:
        """Return the compared area of a panel."""
        panel, hems = pattern.panel(name), list[int]()
        for row in _open_rows(pattern, panel):
            corners = panel.points[[*row, (row[-1] + 1) % len(panel.edges)]]
            outside = polygon_area(corners) + sum(_segment_area(panel, i) for i in row)
            if outside >= -MAX_STRAIGHT_AREA_RATIO * float(((corners[-1] - corners[0]) ** 2).sum()):
                hems += row
        return cls(name, tuple(hems))

    def measure(self, pattern: Pattern) -> float:
        """Return the area [m2]."""
        panel = pattern.panel(self.panel)
        return polygon_area(panel.points) + sum(_segment_area(panel, i) for i in self.hems)

    def rates(self, pattern: Pattern) -> np.ndarray:
        """Return the derivative of the area by all points [m], shape [point_count, 2]."""
        return area_rates_by_points(pattern, self.panel, self.hems)

    def curves(self) -> Iterator[EdgeRef]:
        """Yield the edges whose curves count."""
        return (EdgeRef(self.panel, i) for i in self.hems)


def area_rates_by_points(pattern: Pattern, name: str, curves: Iterable[int]) -> np.ndarray:
    """Return the derivative of a panel's area by all points [m], shape [point_count, 2].

    Args:
        pattern: The pattern.
        name: The panel's name.
        curves: Its edges whose curves count and grow with their chords; the others count as their chords.
    """
    start, points = pattern.first_points[name], pattern.panel(name).points
    count = len(points)
    apart = 0.5 * (np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0))
    normal_rates = np.column_stack([apart[:, 1], -apart[:, 0]])
    for i in curves:
        change = 2.0 * edge_area(pattern.panel(name).edges[i]) * (points[(i + 1) % count] - points[i])
        normal_rates[(i + 1) % count] += change
        normal_rates[i] -= change
    rates = np.zeros((len(pattern.points), 2))
    rates[start : start + count] = normal_rates
    return rates


def _open_rows(pattern: Pattern, panel: Panel) -> Iterator[list[int]]:
    """Yield the unsewn edges of a panel, row by row."""
    sewn = {ref.edge for seam in pattern.seams for ref in (seam.a, seam.b) if ref.panel == panel.name}
    count = len(panel.edges)
    for before in sorted(sewn, key=lambda edge: (edge + 1) % count):
        row = edges_until(before, count, 1, sewn)
        if row:
            yield row


def _segment_area(panel: Panel, index: int) -> float:
    """Return the area between an edge and its chord [m2]."""
    start, end = chord(panel, index)
    return edge_area(panel.edges[index]) * float((end - start) @ (end - start))
