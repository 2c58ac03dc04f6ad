"""Symmetry of a pattern: pairs of panels that are mirror images, and panels that are their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, lil_matrix

from .memo import memoise
from .mirrors import Mirror, find_mirrors
from .pattern import Pattern


@dataclass(frozen=True)
class Symmetry:
    """Describe the effective control points of a pattern and the affine map back to all of them.

        points = matrix @ K + offset,    stacked as x0, y0, x1, y1, ...

    Thesis 3.2.2 and algorithm 2. Deviations of the drawn pattern from exact symmetry (at most the tolerance) are in the
    offset, so `expand(reduce(points))` gives the pattern back exactly. A point on its own panel's axis stays on it.

    Attributes:
        effective: Indices into all control points, shape [effective_count].
        matrix: Shape [2 point_count, 2 effective_count].
        offset: Shape [2 point_count].
    """

    effective: np.ndarray
    matrix: csr_matrix
    offset: np.ndarray
    mirrors: tuple[Mirror, ...]

    def expand(self, effective: np.ndarray) -> np.ndarray:
        """Return all control points [m], shape [point_count, 2], from effective ones, shape [effective_count, 2]."""
        found: np.ndarray = (self.matrix @ np.asarray(effective, float).ravel() + self.offset).reshape(-1, 2)
        return found

    def reduce(self, points: np.ndarray) -> np.ndarray:
        """Return the effective control points [m], shape [effective_count, 2], out of all, shape [point_count, 2]."""
        found: np.ndarray = np.asarray(points, float)[self.effective]
        return found

    def pull_back(self, gradient: np.ndarray) -> np.ndarray:
        """Return the derivative by the effective points from that by all, shape [point_count, 2]."""
        found: np.ndarray = (self.matrix.T @ np.asarray(gradient, float).ravel()).reshape(-1, 2)
        return found


@memoise
def find_symmetry(pattern: Pattern) -> Symmetry:
    """Find the left-right symmetry of a pattern (thesis algorithm 2).

    Each pair of panels is compared, and each panel with itself, by `find_mirrors`. A pattern with `Pattern.symmetric`
    False has no symmetry: every control point is effective.

    **Deviation** Algorithm 2 accepts any congruent pair. On a T-shirt that ties all four half sleeves together, and a
    skirt's back to its front, which grading then cannot distinguish. So where the file places the panels, a mirror
    image must also be across the garment's middle plane; the placement also decides between several fitting shifts.
    """
    return _assemble(pattern, find_mirrors(pattern) if pattern.symmetric else [])


def _assemble(pattern: Pattern, mirrors: list[Mirror]) -> Symmetry:
    """Return the effective points and the map back."""
    starts = pattern.point_starts
    dependent: dict[int, tuple[int, Mirror, np.ndarray]] = {}
    on_axis: dict[int, Mirror] = {}
    for mirror in mirrors:
        for j, i in enumerate(mirror.order.tolist()):
            point, image = int(starts[mirror.target] + j), int(starts[mirror.source] + i)
            if point == image:
                on_axis[point] = mirror
            elif mirror.source != mirror.target or image < point:
                dependent[point] = (image, mirror, mirror.rest[j])
    points = pattern.points
    effective = np.array([k for k in range(len(points)) if k not in dependent], dtype=np.int64)
    column = {int(k): n for n, k in enumerate(effective)}
    matrix = lil_matrix((2 * len(points), 2 * len(effective)))
    offset = np.zeros((len(points), 2))
    for k in range(len(points)):
        block, source = np.eye(2), k
        if k in on_axis:
            # Points of the axis satisfy p = Rp + t; (I + R) / 2 projects onto it.
            block = (np.eye(2) + on_axis[k].rotation) / 2.0
            offset[k] = points[k] - block @ points[k]
        elif k in dependent:
            source, mirror, _ = dependent[k]
            block = mirror.rotation
            offset[k] = points[k] - block @ points[source]
        n = column[source]
        matrix[2 * k : 2 * k + 2, 2 * n : 2 * n + 2] = block
    return Symmetry(effective, csr_matrix(matrix), offset.ravel(), tuple(mirrors))
