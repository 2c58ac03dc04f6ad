"""Define what grading moves in a pattern: its control points and, where its curves are free, their handles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...garment.control import map_controls
from ...garment.fairness import SmoothJoin, find_smooth_joins, measure_corner
from ...garment.garment import Garment
from ...garment.handles import (
    corner_rates,
    find_free_handles,
    follow_handles,
    handles_of,
    length_rates,
    with_handles,
)
from ...garment.pattern import EdgeRef, Pattern
from ...garment.symmetry import find_symmetry
from .flattening import seam_rows
from .parts import find_parts

CURVE_HANDLE_STD = 0.3
"""Standard deviation of a handle from the base pattern's [chords]: one maker's armhole is cut out where another's runs
straight down, with handles 0.3 to 0.6 of a chord apart. With 1 the panels of GarmentCode's drapes are 0.2 % nearer in
area, and those of a T-shirt whose cloth is strained by 3 % are 2.4 % further off."""

SMOOTH_CORNER_STD = np.radians(1.0)
"""Standard deviation of a corner from a smooth place of the base pattern [rad]; 5 degrees are lost in cutting."""

FIXED_CONTOUR_PREFIXES = ("neck", "armhole")
"""Beginnings of the names of open contours whose shape is measured on the contour itself."""


@dataclass(frozen=True)
class PatternParameters:
    """Describe the free parameters: effective control points [m], then effective handles [chords].

    Attributes:
        points: All control points (x0, y0, ...) by the parameters of points, shape [2 point_count, a].
        handles: All handles by the parameters of handles, shape [2 handle_count, b]; b is 0 where curves are not free.
        shapes: The base pattern's handles, shape [2 handle_count].
        joins: Where the base pattern is smooth, with its corner [rad]; empty where curves are not free.
    """

    points: np.ndarray
    handles: np.ndarray
    shapes: np.ndarray
    joins: tuple[tuple[SmoothJoin, float], ...]

    @classmethod
    def of(cls, base: Pattern, curves: bool) -> PatternParameters:
        """Return the parameters that a base pattern's symmetry leaves free, with its curves' handles or without."""
        points, shapes = find_symmetry(base).matrix.toarray(), handles_of(base).ravel()
        if not curves:
            return cls(points, np.zeros((len(shapes), 0)), shapes, ())
        joins = tuple((join, measure_corner(base, join)) for join in find_smooth_joins(base))
        return cls(points, find_free_handles(base, _find_fixed_curves(base)), shapes, joins)

    @property
    def has_curves(self) -> bool:
        """Return whether curves are free."""
        return bool(self.handles.shape[1] > 0)

    def combine(self, by_points: np.ndarray, by_handles: np.ndarray) -> np.ndarray:
        """Return rates by the parameters, given those by all points and by all handles, shape [..., a + b]."""
        return np.concatenate([by_points @ self.points, by_handles @ self.handles], axis=-1)

    def rates(self, garment: Garment) -> np.ndarray:
        """Return the rates of a flat mesh, shape [uv_count, 2, a + b]."""
        followed = (map_controls(garment).matrix @ self.points).reshape(len(garment.uv), 2, -1)
        if not self.has_curves:
            return np.asarray(followed)
        return np.concatenate([followed, follow_handles(garment) @ self.handles], axis=-1)

    def seam_rows(self, pattern: Pattern) -> np.ndarray:
        """Return the rates of the difference in length of each ungathered seam's sides, shape [count, a + b]."""
        rows = seam_rows(pattern, pattern.points)
        by_handles = np.zeros((len(rows), len(self.handles)))
        if self.has_curves:
            sewn = [seam for seam in pattern.seams if not seam.gathered]
            for row, seam in zip(by_handles, sewn, strict=True):
                row[:] = length_rates(pattern, {seam.a: 1.0, seam.b: -1.0})
        return self.combine(rows, by_handles)

    def shape_rules(self, pattern: Pattern) -> tuple[np.ndarray, np.ndarray]:
        """Return the deviation of free curves from the base pattern's, shape [n], and its rates, shape [n, a + b].

        Both in standard deviations: each effective handle, and each corner where the base pattern is smooth.
        """
        if not self.has_curves:
            return np.zeros(0), np.zeros((0, self.points.shape[1]))
        delta = self.handles.T @ (self.shapes - handles_of(pattern).ravel())
        missing = [delta / CURVE_HANDLE_STD]
        by_points, by_handles = [np.zeros((len(delta), len(self.points)))], [self.handles.T / CURVE_HANDLE_STD]
        for join, corner in self.joins:
            off = (corner - measure_corner(pattern, join) + np.pi) % (2.0 * np.pi) - np.pi
            missing.append(np.array([off / SMOOTH_CORNER_STD]))
            of_points, of_handles = corner_rates(pattern, join)
            by_points.append(of_points.reshape(1, -1) / SMOOTH_CORNER_STD)
            by_handles.append(of_handles.reshape(1, -1) / SMOOTH_CORNER_STD)
        return np.concatenate(missing), self.combine(np.concatenate(by_points), np.concatenate(by_handles))

    def move(self, pattern: Pattern, change: np.ndarray) -> Pattern:
        """Return a pattern with changed parameters, seams not yet equal."""
        split = self.points.shape[1]
        moved = pattern.with_points(pattern.points + (self.points @ change[:split]).reshape(-1, 2))
        if not self.has_curves:
            return moved
        return with_handles(moved, handles_of(pattern) + (self.handles @ change[split:]).reshape(-1, 2))

    def difference(self, pattern: Pattern, start: Pattern) -> np.ndarray:
        """Return the difference of a pattern's parameters from another's, shape [a + b]."""
        points = np.linalg.lstsq(self.points, (pattern.points - start.points).ravel(), rcond=None)[0]
        return np.concatenate([points, self.handles.T @ (handles_of(pattern) - handles_of(start)).ravel()])


def _find_fixed_curves(base: Pattern) -> set[EdgeRef]:
    """Return the edges whose curves stay: seams within a part, such as front with back, necklines and open armholes.

    A side seam follows the girths, and its place on a smooth side is not visible: free, it bends with the strain that a
    missing dart leaves there. A neckline is chosen by its contour (`neckline.py`): free, the sides of a V, or an open
    armhole, bow with the strain of the cloth beside. A hem's curve follows from the flare above it.
    """
    part = dict(zip((panel.name for panel in base.panels), find_parts(base), strict=True))
    within = [seam for seam in base.seams if part[seam.a.panel] == part[seam.b.panel]]
    upper = {
        EdgeRef(panel.name, i)
        for panel in base.panels
        for i, edge in enumerate(panel.edges)
        if edge.contour.startswith(FIXED_CONTOUR_PREFIXES)
    }
    return upper | {ref for seam in within for ref in (seam.a, seam.b)}
