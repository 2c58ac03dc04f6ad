"""Pairs of boxes that overlap, found on a uniform grid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

_CELLS = 2**18
"""Most cells of a grid: 2 MB, cleared in a tenth of a millisecond; wider cloth gets larger ones."""


class Boxes(NamedTuple):
    """Boxes around groups of nodes: lowest and highest corners [m], [box_count, 3], and the nodes, [box_count, k]."""

    low: np.ndarray
    high: np.ndarray
    nodes: np.ndarray


@njit(cache=True)
def wrap_boxes(start, end, groups, inflation):  # type: ignore[no-untyped-def]
    """Return the lowest and highest corners [m] of groups of nodes on their way, [group_count, 3], inflated [m]."""
    low, high = np.zeros((len(groups), 3)), np.zeros((len(groups), 3))
    for g in range(len(groups)):
        for d in range(3):
            least, most = np.inf, -np.inf
            for k in range(groups.shape[1]):
                i = groups[g, k]
                least = min(least, start[i, d], end[i, d])
                most = max(most, start[i, d], end[i, d])
            low[g, d], high[g, d] = least - inflation, most + inflation
    return low, high


def choose_cells(boxes: Boxes, size: float) -> tuple[np.ndarray, float, np.ndarray]:
    """Return origin [m], side [m] and counts of a grid of cells of about this size [m] over boxes [box_count, 3]."""
    floor, top = boxes.low.min(axis=0), boxes.high.max(axis=0)
    extent = np.maximum(top - floor, size)
    size = max(size, float(np.cbrt(extent.prod() / _CELLS)))
    return floor, size, np.floor(extent / size).astype(np.int64) + 1


@njit(cache=True)
def fill_cells(boxes, grid):  # type: ignore[no-untyped-def]
    """Return where each cell's boxes begin, shape [cell_count + 1], and the boxes, in ascending order in each cell."""
    low, high, _ = boxes
    origin, size, counts = grid
    starts = np.zeros(counts[0] * counts[1] * counts[2] + 1, np.int64)
    for turn in range(2):
        if turn == 1:
            total = 0
            for c in range(len(starts)):
                total, starts[c] = total + starts[c], total
            members = np.zeros(total, np.int64)
        for g in range(len(low)):
            i0, i1 = int((low[g, 0] - origin[0]) / size), int((high[g, 0] - origin[0]) / size)
            j0, j1 = int((low[g, 1] - origin[1]) / size), int((high[g, 1] - origin[1]) / size)
            k0, k1 = int((low[g, 2] - origin[2]) / size), int((high[g, 2] - origin[2]) / size)
            for i in range(i0, i1 + 1):
                for j in range(j0, j1 + 1):
                    for k in range(k0, k1 + 1):
                        c = (i * counts[1] + j) * counts[2] + k
                        if turn == 1:
                            members[starts[c]] = g
                        starts[c] += 1
    for c in range(len(starts) - 1, 0, -1):
        starts[c] = starts[c - 1]
    starts[0] = 0
    return starts, members


@njit(cache=True)
def find_overlaps(boxes, others, cells, grid, same):  # type: ignore[no-untyped-def]
    """Return the nodes of all boxes and others that overlap and share no node, [pair_count, 4], each pair once.

    Args:
        boxes, others: `Boxes` of k and 4 - k nodes.
        cells: What `fill_cells` gave for the others.
        grid: Origin, side and counts of the cells.
        same: Both are the same boxes: a box is not paired with itself, and with each other one once.
    """
    low, high, nodes = boxes
    other_low, other_high, other_nodes = others
    first_count, second_count = nodes.shape[1], other_nodes.shape[1]
    starts, members = cells
    origin, size, counts = grid
    pairs, found = np.zeros((256, 4), np.int64), 0
    first, last = np.zeros(3, np.int64), np.zeros(3, np.int64)
    for a in range(len(low)):
        for d in range(3):
            first[d] = max(0, int((low[a, d] - origin[d]) / size))
            last[d] = min(counts[d] - 1, int((high[a, d] - origin[d]) / size))
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                for k in range(first[2], last[2] + 1):
                    c = (i * counts[1] + j) * counts[2] + k
                    for m in range(starts[c], starts[c + 1]):
                        b = members[m]
                        if same and b <= a:
                            continue
                        if (
                            other_low[b, 0] > high[a, 0]
                            or other_high[b, 0] < low[a, 0]
                            or other_low[b, 1] > high[a, 1]
                            or other_high[b, 1] < low[a, 1]
                            or other_low[b, 2] > high[a, 2]
                            or other_high[b, 2] < low[a, 2]
                        ):
                            continue
                        # the pair belongs to the cell of the lowest corner of what both share
                        if (
                            int((max(low[a, 0], other_low[b, 0]) - origin[0]) / size) != i
                            or int((max(low[a, 1], other_low[b, 1]) - origin[1]) / size) != j
                            or int((max(low[a, 2], other_low[b, 2]) - origin[2]) / size) != k
                        ):
                            continue
                        shared = False
                        for p in range(first_count):
                            for q in range(second_count):
                                shared = shared or nodes[a, p] == other_nodes[b, q]
                        if shared:
                            continue
                        if found == len(pairs):
                            pairs = np.concatenate((pairs, np.zeros_like(pairs)))
                        for p in range(first_count):
                            pairs[found, p] = nodes[a, p]
                        for q in range(second_count):
                            pairs[found, first_count + q] = other_nodes[b, q]
                        found += 1
    return pairs[:found]
