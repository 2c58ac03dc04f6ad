"""Find overlapping boxes on a uniform grid, and overlapping parts of two patches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...run.kernels import kernel

_MAX_BOX_CELL_COUNT = 2**18
"""Largest number of cells of a grid: 2 MB, cleared in 0.1 ms. Larger cloth gets larger cells."""

_GRID_CELL_SIZE_RATIO = 1.5
"""Side of a grid cell [mean extents of a box]. Smaller cells list each box more often, larger ones test more pairs: at
4000 nodes 0.5 to 1.5 took 9.3, 5.7, 4.1 and 3.5 ms."""


_MAX_BRUTE_FORCE_TESTS = 2**16
"""Largest number of pairs of boxes that are all tested: as fast as filling a grid."""


class Grid(NamedTuple):
    """Uniform grid: lowest corner [m], shape [3], side [m] and cells along each axis, shape [3]."""

    origin: np.ndarray
    side: float
    counts: np.ndarray

    @classmethod
    def of(cls, bounds: np.ndarray) -> Grid:
        """Return a grid over boxes, with cells that suit their size."""
        low, high = bounds[:, :3], bounds[:, 3:]
        origin, side = low.min(axis=0), _GRID_CELL_SIZE_RATIO * float((high - low).mean())
        extent = np.maximum(high.max(axis=0) - origin, side)
        side = max(side, float(np.cbrt(extent.prod() / _MAX_BOX_CELL_COUNT)))
        return cls(origin, side, np.floor(extent / side).astype(np.int64) + 1)


def pair_boxes(bounds: np.ndarray, inflation: float, active: np.ndarray) -> np.ndarray:
    """Return the indices of each two boxes that overlap, each pair once, shape [pair_count, 2].

    Args:
        bounds: Lowest and highest corners [m], shape [box_count, 6].
        inflation: Distance by which each box is enlarged [m].
        active: Boxes of which every pair has one or both, shape [box_count].
    """
    if int(active.sum()) * len(bounds) <= _MAX_BRUTE_FORCE_TESTS:
        return np.asarray(_test_all(bounds, 2.0 * inflation, active))
    bounds = np.ascontiguousarray(bounds + inflation * np.repeat([-1.0, 1.0], 3))
    return np.asarray(_find_overlaps(bounds, Grid.of(bounds), active))


@kernel(inline="always")
def _inflate_box(boxes, m, need):  # type: ignore[no-untyped-def]
    """Return the lowest and the highest corner of a box that is enlarged by `need` [m]."""
    low = (boxes[m, 0] - need, boxes[m, 1] - need, boxes[m, 2] - need)
    return low, (boxes[m, 3] + need, boxes[m, 4] + need, boxes[m, 5] + need)


@kernel(inline="always")
def _is_beside_box(boxes, m, low, high):  # type: ignore[no-untyped-def]
    """Check whether a box and the one between two corners [m] do not overlap."""
    return (
        boxes[m, 0] > high[0]
        or boxes[m, 3] < low[0]
        or boxes[m, 1] > high[1]
        or boxes[m, 4] < low[1]
        or boxes[m, 2] > high[2]
        or boxes[m, 5] < low[2]
    )


@kernel()
def _test_all(bounds, need, active):  # type: ignore[no-untyped-def]
    """Return the pairs of boxes, of which one is active, that are within `need` [m] of each other, [pair_count, 2]."""
    pairs, found, whole = np.zeros((1024, 2), np.int64), 0, active.all()
    for a in np.flatnonzero(active):
        low, high = _inflate_box(bounds, a, need)
        for b in range(a + 1 if whole else 0, len(bounds)):
            if _is_beside_box(bounds, b, low, high) or (b <= a and active[b]):
                continue
            if found == len(pairs):
                pairs = np.concatenate((pairs, np.zeros_like(pairs)))
            pairs[found, 0], pairs[found, 1] = a, b
            found += 1
    return pairs[:found]


@kernel()
def _find_overlaps(bounds, grid, active):  # type: ignore[no-untyped-def]
    """Return the pairs of overlapping boxes, of which one is active, each pair once, [pair_count, 2]."""
    starts, members, copies = _fill_cells(bounds, grid)
    origin, side, counts = grid
    pairs, found = np.zeros((1024, 2), np.int64), 0
    for c in range(len(starts) - 1):
        i, j, k = c // (counts[1] * counts[2]), c // counts[2] % counts[1], c % counts[2]
        for m in range(starts[c], starts[c + 1]):
            low, high = _inflate_box(copies, m, 0.0)
            for n in range(m + 1, starts[c + 1]):
                if _is_beside_box(copies, n, low, high):
                    continue
                # the pair belongs to the cell of the lowest corner of what both share
                if (
                    max(0, int(np.floor((max(low[0], copies[n, 0]) - origin[0]) / side))) != i
                    or max(0, int(np.floor((max(low[1], copies[n, 1]) - origin[1]) / side))) != j
                    or max(0, int(np.floor((max(low[2], copies[n, 2]) - origin[2]) / side))) != k
                ):
                    continue
                if not (active[members[m]] or active[members[n]]):
                    continue
                if found == len(pairs):
                    pairs = np.concatenate((pairs, np.zeros_like(pairs)))
                pairs[found, 0], pairs[found, 1] = members[m], members[n]
                found += 1
    return pairs[:found]


@kernel()
def _fill_cells(bounds, grid):  # type: ignore[no-untyped-def]
    """Return where each cell of a grid begins, its boxes in ascending order, and their bounds."""
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
                    starts[(i * counts[1] + j) * counts[2] + k + 1] += 1
    for c in range(len(starts) - 1):
        starts[c + 1] += starts[c]
    ends = starts.copy()
    members, copies = np.zeros(starts[-1], np.int64), np.zeros((starts[-1], 6))
    for g in range(len(bounds)):
        for i in range(span[g, 0], span[g, 3] + 1):
            for j in range(span[g, 1], span[g, 4] + 1):
                for k in range(span[g, 2], span[g, 5] + 1):
                    c = (i * counts[1] + j) * counts[2] + k
                    members[ends[c]] = g
                    copies[ends[c]] = bounds[g]
                    ends[c] += 1
    return starts, members, copies


@kernel()
def pair_parts(spans, close, lists, groups, chosen, need):  # type: ignore[no-untyped-def]
    """Return the indices of parts of two patches whose boxes overlap and that share no node, [pair_count, 2].

    Args:
        spans: Lowest and highest corner of each node's positions [m], shape [node_count, 6].
        close: The pairs of patches, shape [close_count, 2].
        lists: The parts of each patch, of the first kind and of the second: `RaggedLists` both.
        groups: The nodes of each part of either kind, shape [part_count, k].
        chosen: Which parts of either kind are tested, [part_count] each, and the nodes of which each pair has one or
            more, [node_count], or no entries.
        need: Distance below which two boxes overlap [m].
    """
    (starts, members), (other_starts, other_members) = lists
    nodes, others = groups
    first, second, moved = chosen
    same = nodes.shape[1] == others.shape[1]
    # in the order of the lists, so that the boxes of a patch are contiguous
    boxes = np.zeros((len(members), 6))
    other_boxes = boxes if same else np.zeros((len(other_members), 6))
    wholes, other_wholes = np.zeros((len(starts) - 1, 6)), np.zeros((len(starts) - 1, 6))
    known, other_known = np.zeros(len(starts), np.bool_), np.zeros(len(starts), np.bool_)
    pairs, found = np.zeros((256, 2), np.int64), 0
    for n in range(len(close)):
        for turn in range(1 if same or close[n, 0] == close[n, 1] else 2):
            c, d = close[n, turn], close[n, 1 - turn]
            if not known[c]:
                _fill_boxes(spans, nodes, members, (starts[c], starts[c + 1]), boxes, wholes[c])
                known[c] = True
            if same and not known[d]:
                _fill_boxes(spans, nodes, members, (starts[d], starts[d + 1]), boxes, wholes[d])
                known[d] = True
            if not same and not other_known[d]:
                _fill_boxes(
                    spans, others, other_members, (other_starts[d], other_starts[d + 1]), other_boxes, other_wholes[d]
                )
                other_known[d] = True
            around = wholes if same else other_wholes
            for m in range(starts[c], starts[c + 1]):
                a = members[m]
                low, high = _inflate_box(boxes, m, need)
                if not first[a] or _is_beside_box(around, d, low, high):
                    continue
                for k in range(m + 1 if same and c == d else other_starts[d], other_starts[d + 1]):
                    if _is_beside_box(other_boxes, k, low, high):
                        continue
                    b = other_members[k]
                    shared, touched = not second[b], len(moved) == 0
                    for p in range(nodes.shape[1]):
                        touched = touched or moved[nodes[a, p]]
                        for q in range(others.shape[1]):
                            shared = shared or nodes[a, p] == others[b, q]
                    if shared:
                        continue
                    for q in range(others.shape[1]):
                        touched = touched or moved[others[b, q]]
                    if not touched:
                        continue
                    if found == len(pairs):
                        pairs = np.concatenate((pairs, np.zeros_like(pairs)))
                    pairs[found, 0], pairs[found, 1] = a, b
                    found += 1
    return pairs[:found]


@kernel()
def _fill_boxes(spans, groups, members, run, boxes, whole):  # type: ignore[no-untyped-def]
    """Fill the boxes [m] of a run of groups of nodes, and the box around all of them, from the nodes' boxes."""
    whole[:3], whole[3:] = np.inf, -np.inf
    for m in range(run[0], run[1]):
        for d in range(3):
            least, most = np.inf, -np.inf
            for k in range(groups.shape[1]):
                v = groups[members[m], k]
                least, most = min(least, spans[v, d]), max(most, spans[v, 3 + d])
            boxes[m, d], boxes[m, 3 + d] = least, most
            whole[d], whole[3 + d] = min(whole[d], least), max(whole[3 + d], most)
