"""Sample a scan in strips along a drafted garment's seams: rows of points across each, to find where the seam is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...garment.garment import Garment
from ...garment.pieces.pattern_lines import PatternLine, list_lines
from ...geometry.geometry import unit, vertex_normals
from ...geometry.surface import ClosestPoints, TriangleSurface

SEARCH_REACH = 0.04
"""Distance from a drafted seam within which it is searched [m]: twice by which an armhole was misplaced."""

SEARCH_STEP = 0.002
"""Step of the search [m]: the distance of a scan's vertices."""

ROW_SPACING = 0.015
"""Distance of the places along a seam from which it is searched [m]."""

POOLED_ROW_COUNT = 7
"""Number of neighbouring places that are compared together [1]: 10 cm of a seam, more than prints repeat."""

MIN_SEEN_ROWS = 4
"""Number of places that must show a seam for it to be seen [1]: fewer may be a badge or a button."""

MAX_SURFACE_DISTANCE = 0.015
"""Distance from the scan beyond which a searched point is beside it [m]: half a fold."""


@dataclass(frozen=True)
class SeamTrace:
    """Describe what a scan shows of a seam.

    Attributes:
        nodes: Nodes of the seam next to which it shows, shape [n].
        across: Unit directions across the seam, in the cloth, shape [n, 3].
        places: Points at which it shows [m], shape [n, 3].
    """

    nodes: np.ndarray
    across: np.ndarray
    places: np.ndarray

    def is_at(self, nodes: np.ndarray, distance: float) -> bool:
        """Check whether most of its nodes lie within a distance [m] of what shows, given all nodes [m]."""
        off = ((nodes[self.nodes] - self.places) * self.across).sum(axis=1)
        return bool((np.abs(off) < distance).mean() > 0.5)


@dataclass(frozen=True)
class SeamStrip:
    """Describe a strip of a scan along a seam.

    Attributes:
        line: The seam.
        nodes: Its inner nodes on the garment's mesh, shape [n].
        positions: Of these [m], shape [n, 3].
        row_of_node: The row next to each, shape [n].
        across: Unit direction of each row, across the seam in the cloth, shape [row_count, 3].
        closest: The scan's closest points to those of the rows, one row after the other.
        near: Whether each is on the scan, shape [row_count, column_count].
    """

    line: PatternLine
    nodes: np.ndarray
    positions: np.ndarray
    row_of_node: np.ndarray
    across: np.ndarray
    closest: ClosestPoints
    near: np.ndarray

    def interpolate(self, values: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Return values of the scan's vertices, shape [vertex_count, k], in the rows, [row_count, column_count, k]."""
        return self.closest.interpolate(values, faces).reshape(*self.near.shape, -1)

    def trace(self, columns: np.ndarray, is_seen: np.ndarray) -> SeamTrace | None:
        """Return the seam's trace from the column and whether it is seen of each row; None where most do not see it."""
        if is_seen.sum() < MIN_SEEN_ROWS or is_seen.mean() <= 0.5:
            return None
        shows = is_seen[self.row_of_node]
        row = self.row_of_node[shows]
        shift = SEARCH_STEP * columns[row] - SEARCH_REACH
        across = self.across[row]
        return SeamTrace(self.nodes[shows], across, self.positions[shows] + shift[:, None] * across)


def sample_strips(garment: Garment, surface: TriangleSurface, rows_per_place: int = 1) -> Iterator[SeamStrip]:
    """Yield a strip along each of a garment's seams.

    Args:
        garment: The garment, its nodes on the scan [m].
        surface: The scan's.
        rows_per_place: Number of rows in each `ROW_SPACING` along a seam.
    """
    normals = vertex_normals(garment.nodes, garment.faces)
    offsets = np.linspace(-SEARCH_REACH, SEARCH_REACH, 1 + round(2.0 * SEARCH_REACH / SEARCH_STEP))
    for line in list_lines(garment.pattern):
        if line.is_open:
            continue
        nodes, row_of_node, starts, across = _walk(line, garment, normals, rows_per_place)
        points = starts[:, None] + offsets[None, :, None] * across[:, None]
        closest = surface.closest(points.reshape(-1, 3))
        near = closest.distance.reshape(points.shape[:2]) < MAX_SURFACE_DISTANCE
        yield SeamStrip(line, nodes, garment.nodes[nodes], row_of_node, across, closest, near)


def pool_rows(values: np.ndarray) -> np.ndarray:
    """Return the mean of each row's values and those of `POOLED_ROW_COUNT` rows about it, at the ends fewer."""
    reach = POOLED_ROW_COUNT // 2
    sums = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), values]), axis=0)
    ends = np.arange(len(values))
    first, last = np.maximum(ends - reach, 0), np.minimum(ends + reach + 1, len(values))
    counts = (last - first).reshape(-1, *(1,) * (values.ndim - 1))
    return np.asarray((sums[last] - sums[first]) / counts)


def _walk(
    line: PatternLine, garment: Garment, normals: np.ndarray, rows_per_place: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return a seam's inner nodes, shape [n], and the row next to each; of each row the place on the seam and the unit
    direction across it, shape [m, 3] each."""
    nodes, rows, starts, across = [], [], [], []
    count = 0
    for ref in line.edges:
        path = garment.uv_node[garment.edge_uv[ref]]
        points = garment.nodes[path]
        pieces = np.linalg.norm(np.diff(points, axis=0), axis=1)
        arc = np.concatenate([[0.0], np.cumsum(pieces)])
        number = max(int(arc[-1] / ROW_SPACING), 1) * rows_per_place
        at = (np.arange(number) + 0.5) * arc[-1] / number
        ahead, behind = (
            _interpolate(np.clip(at + way, 0.0, arc[-1]), arc, points) for way in (ROW_SPACING, -ROW_SPACING)
        )
        starts.append(_interpolate(at, arc, points))
        across.append(unit(np.cross(_interpolate(at, arc, normals[path]), ahead - behind)))
        nodes.append(path[1:-1])
        rows.append(count + np.abs(arc[1:-1, None] - at).argmin(axis=1))
        count += number
    return np.concatenate(nodes), np.concatenate(rows), np.concatenate(starts), np.concatenate(across)


def _interpolate(at: np.ndarray, arc: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.stack([np.interp(at, arc, column) for column in values.T], axis=1)
