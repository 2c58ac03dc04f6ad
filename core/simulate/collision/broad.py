"""Pairs of boxes that overlap, found on a uniform grid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

_CELLS = 2**18
"""Most cells of a grid: 2 MB, cleared in a tenth of a millisecond; wider cloth gets larger ones."""

_SIDE = 1.5
"""Side of a cell in mean extents of a box. Smaller cells hold each box more often, larger ones test more pairs: at 4000
nodes 0.5 to 1.5 took 9.3, 5.7, 4.1 and 3.5 ms."""


class Boxes(NamedTuple):
    """Boxes around groups of nodes: lowest and highest corners [m], [box_count, 6], and the nodes, [box_count, k]."""

    bounds: np.ndarray
    nodes: np.ndarray


class Cells(NamedTuple):
    """Boxes by the cells of a grid: where each cell begins, and its boxes and their bounds, in ascending order."""

    starts: np.ndarray
    members: np.ndarray
    bounds: np.ndarray


class Grid(NamedTuple):
    """A uniform grid: lowest corner [m], shape [3], side [m] and cells along each axis, shape [3]."""

    origin: np.ndarray
    side: float
    counts: np.ndarray

    @classmethod
    def of(cls, boxes: Boxes) -> Grid:
        """Lay a grid over boxes, of cells that suit their size."""
        low, high = boxes.bounds[:, :3], boxes.bounds[:, 3:]
        origin, side = low.min(axis=0), _SIDE * float((high - low).mean())
        extent = np.maximum(high.max(axis=0) - origin, side)
        side = max(side, float(np.cbrt(extent.prod() / _CELLS)))
        return cls(origin, side, np.floor(extent / side).astype(np.int64) + 1)


EVERYWHERE = np.zeros(0, np.int64)
"""Tells `fill_cells` to fill all cells."""


def pair_boxes(boxes: Boxes, others: Boxes | None) -> np.ndarray:
    """Return the indices of boxes and others that overlap and share no node, [pair_count, 2], each pair once.

    Where `others` is None the boxes are paired among themselves. The cells are those of the boxes: where there are few
    of them, the others elsewhere cost next to nothing.
    """
    if not len(boxes.nodes) or (others is not None and not len(others.nodes)):
        return np.zeros((0, 2), np.int64)
    grid = Grid.of(boxes)
    cells = fill_cells(boxes, grid, EVERYWHERE)
    if others is None:
        return np.asarray(find_overlaps(boxes, boxes, (cells, cells), grid, True))
    return np.asarray(find_overlaps(boxes, others, (cells, fill_cells(others, grid, cells[0])), grid, False))


@njit(cache=True)
def wrap_boxes(path, groups, inflation):  # type: ignore[no-untyped-def]
    """Return the bounds [m] of groups of nodes on a path [place_count, node_count, 3], inflated [m]; see `Boxes`."""
    bounds = np.zeros((len(groups), 6))
    for g in range(len(groups)):
        for d in range(3):
            least, most = np.inf, -np.inf
            for k in range(groups.shape[1]):
                for p in range(len(path)):
                    value = path[p, groups[g, k], d]
                    least, most = min(least, value), max(most, value)
            bounds[g, d], bounds[g, 3 + d] = least - inflation, most + inflation
    return bounds


@njit(cache=True)
def fill_cells(boxes, grid, wanted):  # type: ignore[no-untyped-def]
    """Return the `Cells` of boxes in a grid; what of a box is outside it is left out.

    `wanted` is where the cells of other boxes begin: cells that hold none of those stay empty. No entries: all cells.
    """
    bounds, _ = boxes
    origin, side, counts = grid
    span = np.zeros((len(bounds), 6), np.int64)
    starts = np.zeros(counts[0] * counts[1] * counts[2] + 1, np.int64)
    for g in range(len(bounds)):
        for d in range(3):
            span[g, d] = max(0, int(np.floor((bounds[g, d] - origin[d]) / side)))
            span[g, 3 + d] = min(counts[d] - 1, int(np.floor((bounds[g, 3 + d] - origin[d]) / side)))
        for i in range(span[g, 0], span[g, 3] + 1):
            for j in range(span[g, 1], span[g, 4] + 1):
                for k in range(span[g, 2], span[g, 5] + 1):
                    c = (i * counts[1] + j) * counts[2] + k
                    if len(wanted) == 0 or wanted[c + 1] > wanted[c]:
                        starts[c + 1] += 1
    for c in range(len(starts) - 1):
        starts[c + 1] += starts[c]
    ends = starts.copy()
    members, copies = np.zeros(starts[-1], np.int64), np.zeros((starts[-1], 6))
    for g in range(len(bounds)):
        for i in range(span[g, 0], span[g, 3] + 1):
            for j in range(span[g, 1], span[g, 4] + 1):
                for k in range(span[g, 2], span[g, 5] + 1):
                    c = (i * counts[1] + j) * counts[2] + k
                    if len(wanted) == 0 or wanted[c + 1] > wanted[c]:
                        members[ends[c]] = g
                        copies[ends[c]] = bounds[g]
                        ends[c] += 1
    return starts, members, copies


@njit(cache=True)
def find_overlaps(boxes, others, cells, grid, same):  # type: ignore[no-untyped-def]
    """Return the indices of all boxes and others that overlap and share no node, [pair_count, 2], each pair once.

    Args:
        boxes, others: `Boxes` of k and of any nodes.
        cells: What `fill_cells` gave for the boxes and for the others.
        grid: The `Grid` of both.
        same: Both are the same boxes: a box is not paired with itself, and with each other one once.
    """
    (starts, members, bounds), (other_starts, other_members, other_bounds) = cells
    nodes, other_nodes = boxes[1], others[1]
    origin, side, counts = grid
    pairs, found = np.zeros((1024, 2), np.int64), 0
    for c in range(len(starts) - 1):
        i, j, k = c // (counts[1] * counts[2]), c // counts[2] % counts[1], c % counts[2]
        for m in range(starts[c], starts[c + 1]):
            a = members[m]
            x0, y0, z0 = bounds[m, 0], bounds[m, 1], bounds[m, 2]
            x1, y1, z1 = bounds[m, 3], bounds[m, 4], bounds[m, 5]
            for n in range(m + 1 if same else other_starts[c], other_starts[c + 1]):
                if (
                    other_bounds[n, 0] > x1
                    or other_bounds[n, 3] < x0
                    or other_bounds[n, 1] > y1
                    or other_bounds[n, 4] < y0
                    or other_bounds[n, 2] > z1
                    or other_bounds[n, 5] < z0
                ):
                    continue
                # the pair belongs to the cell of the lowest corner of what both share
                if (
                    max(0, int(np.floor((max(x0, other_bounds[n, 0]) - origin[0]) / side))) != i
                    or max(0, int(np.floor((max(y0, other_bounds[n, 1]) - origin[1]) / side))) != j
                    or max(0, int(np.floor((max(z0, other_bounds[n, 2]) - origin[2]) / side))) != k
                ):
                    continue
                b, shared = other_members[n], False
                for p in range(nodes.shape[1]):
                    for q in range(other_nodes.shape[1]):
                        shared = shared or nodes[a, p] == other_nodes[b, q]
                if shared:
                    continue
                if found == len(pairs):
                    pairs = np.concatenate((pairs, np.zeros_like(pairs)))
                pairs[found, 0], pairs[found, 1] = a, b
                found += 1
    return pairs[:found]
