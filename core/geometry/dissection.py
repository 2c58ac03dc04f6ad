"""Order a mesh's nodes for elimination: nested dissection along bisectors between far nodes (after George 1973)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..run.kernels import kernel

MAX_LEAF_NODE_COUNT = 24
"""Largest number of nodes of a part that is not cut further: from 72 rows, three a node, dense algebra is faster."""

PERIPHERAL_NODE_COUNT = 6
"""Number of pseudo-peripheral (far) nodes whose bisectors are tried as separators. Level sets around one node (George
1973) cost 13 to 24 % more arithmetic in the factor, on sheets and on garments; 4 nodes up to 17 % more than 6 and 8."""


@dataclass(frozen=True)
class Supernode:
    """Describe a set of nodes that are eliminated together, and the rows that their elimination updates.

    Attributes:
        nodes: Their old numbers, in order, shape [own_count].
        first: New number of the first; they are consecutive.
        boundary: New numbers of later nodes that are coupled by the elimination, ascending, shape [boundary_count].
        parent: Index of the part that receives the update, or -1.
    """

    nodes: np.ndarray
    first: int
    boundary: np.ndarray
    parent: int


def dissect(indptr: np.ndarray, indices: np.ndarray, leaf: int = MAX_LEAF_NODE_COUNT) -> list[Supernode]:
    """Cut a symmetric graph (rows of neighbours) into parts of at most `leaf` nodes, children before parents."""
    count = len(indptr) - 1
    groups: list[np.ndarray] = []
    parents: list[int] = []
    mark = np.zeros(count, dtype=np.int64)
    level = np.full(count, -1, dtype=np.int64)
    # a stack of (nodes, index of the parent group); groups are created parents first and reversed at the end
    stack = [(np.arange(count), -1)]
    token = 0
    while stack:
        nodes, above = stack.pop()
        token += 1
        mark[nodes] = token
        pieces = [nodes] if len(nodes) <= leaf else _bisect(indptr, indices, nodes, mark, token, level)
        groups.append(pieces[0])
        parents.append(above)
        number = len(groups) - 1
        if not len(pieces[0]):  # several components without a separator: attach to the parent above
            groups.pop()
            parents.pop()
            number = above
        stack.extend((piece, number) for piece in pieces[1:] if len(piece))
    return _build_supernodes(
        indptr, indices, groups[::-1], [len(groups) - 1 - p if p >= 0 else -1 for p in parents[::-1]]
    )


def _bisect(
    indptr: np.ndarray, indices: np.ndarray, nodes: np.ndarray, mark: np.ndarray, token: int, level: np.ndarray
) -> list[np.ndarray]:
    """Return [separator, side, other side]; [nodes] where no cut helps; [empty, component, rest] if not connected."""
    queue = np.zeros(len(nodes), dtype=np.int64)
    start = nodes[0]
    distances = np.zeros((PERIPHERAL_NODE_COUNT, len(nodes)), dtype=np.int64)
    for n in range(
        -1, PERIPHERAL_NODE_COUNT
    ):  # once from anywhere, to find a far end; then from each node that is far from all before
        level[nodes] = -1
        reached = _spread_levels(indptr, indices, start, mark, token, level, queue)
        if reached < len(nodes):
            return [nodes[:0], queue[:reached].copy(), nodes[level[nodes] < 0]]
        if n >= 0:
            distances[n] = level[nodes]
        start = nodes[np.argmax(distances[: n + 1].min(axis=0) if n >= 0 else level[nodes])]
    place = level  # of a node in `nodes`
    place[nodes] = np.arange(len(nodes))
    one, other, cut = _cheapest_cut(indptr, indices, nodes, mark, token, place, distances)
    if one == other:
        return [nodes]
    field = distances[one] - distances[other] - cut
    between = _touches(indptr, indices, nodes, mark, token, place, field)
    return [nodes[between], nodes[(field <= 0) & ~between], nodes[field > 0]]


@kernel()
def _spread_levels(indptr, indices, start, mark, token, level, queue):  # type: ignore[no-untyped-def]
    """Number nodes by their distance from `start` within the marked set; return how many were reached."""
    level[start] = 0
    queue[0] = start
    head, tail = 0, 1
    while head < tail:
        node = queue[head]
        head += 1
        for at in range(indptr[node], indptr[node + 1]):
            other = indices[at]
            if mark[other] == token and level[other] < 0:
                level[other] = level[node] + 1
                queue[tail] = other
                tail += 1
    return tail


@kernel()
def _cheapest_cut(indptr, indices, nodes, mark, token, place, distances):  # type: ignore[no-untyped-def]
    """Find the pair of far nodes with the cheapest cut between two levels of the difference of distances to them. The
    separator of a level m are the nodes up to m with a neighbour above m; its cost is its size over the product of the
    sizes of both sides (ratio cut, Wei and Cheng 1989). Both are the same node where no level has two sides."""
    first, beside = _links_within(indptr, indices, nodes, mark, token, place)
    costs = np.full((len(distances), len(distances)), np.inf)
    levels = np.zeros(costs.shape, np.int64)
    for one in range(len(distances)):
        for other in range(one + 1, len(distances)):
            field = distances[one] - distances[other]
            lowest, highest = field.min(), field.max()
            size = highest - lowest + 1
            rising, falling = np.zeros(size + 1, np.int64), np.zeros(size + 1, np.int64)
            below = np.zeros(size, np.int64)
            for n in range(len(nodes)):
                node_level = field[n]
                top, bottom = node_level, node_level
                for at in range(first[n], first[n + 1]):
                    top, bottom = max(top, field[beside[at]]), min(bottom, field[beside[at]])
                rising[node_level - lowest] += 1
                rising[top - lowest] -= 1
                falling[highest - node_level] += 1
                falling[highest - bottom] -= 1
                below[node_level - lowest] += 1
            costs[one, other], level = _cheapest_level(rising, below, len(nodes))
            levels[one, other] = lowest + level
            costs[other, one], level = _cheapest_level(falling, below[::-1], len(nodes))
            levels[other, one] = level - highest
    best, found = np.inf, (0, 0, 0)
    for one in range(len(distances)):
        for other in range(len(distances)):
            if costs[one, other] < best:
                best, found = costs[one, other], (one, other, levels[one, other])
    return found


@kernel()
def _links_within(indptr, indices, nodes, mark, token, place):  # type: ignore[no-untyped-def]
    """Return the graph within the marked set: start of each node's neighbours, and these by their place in `nodes`."""
    first, beside = np.zeros(len(nodes) + 1, np.int64), np.zeros((indptr[nodes + 1] - indptr[nodes]).sum(), np.int64)
    count = 0
    for n in range(len(nodes)):
        for at in range(indptr[nodes[n]], indptr[nodes[n] + 1]):
            if mark[indices[at]] == token:
                beside[count] = place[indices[at]]
                count += 1
        first[n + 1] = count
    return first, beside


@kernel()
def _cheapest_level(starts, below, count):  # type: ignore[no-untyped-def]
    """Return the least cost of a cut between two levels, and the lower one; infinite where no cut has two sides."""
    best, found, separator, size = np.inf, 0, 0, 0
    for m in range(len(below)):
        separator += starts[m]
        size += below[m]
        sides = (size - separator) * (count - size)
        if sides > 0 and separator / sides < best:
            best, found = separator / sides, m
    return best, found


@kernel()
def _touches(indptr, indices, nodes, mark, token, place, field):  # type: ignore[no-untyped-def]
    """Find the nodes of levels up to 0 with a neighbour above 0 in the marked set."""
    found = np.zeros(len(nodes), dtype=np.bool_)
    for n in range(len(nodes)):
        if field[n] <= 0:
            for at in range(indptr[nodes[n]], indptr[nodes[n] + 1]):
                if mark[indices[at]] == token and field[place[indices[at]]] > 0:
                    found[n] = True
                    break
    return found


def _build_supernodes(
    indptr: np.ndarray, indices: np.ndarray, groups: list[np.ndarray], parents: list[int]
) -> list[Supernode]:
    """Number the nodes and find each part's boundary; children come before their parents."""
    count = len(indptr) - 1
    order = np.concatenate(groups)
    new = np.zeros(count, dtype=np.int64)
    new[order] = np.arange(count)
    sizes = np.array([len(g) for g in groups])
    firsts = np.cumsum(sizes) - sizes
    owner = np.repeat(np.arange(len(groups)), sizes)
    passed: list[list[np.ndarray]] = [[] for _ in groups]
    parts = []
    for g, nodes in enumerate(groups):
        neighbours = np.concatenate([indices[indptr[n] : indptr[n + 1]] for n in nodes] + [nodes[:0]])
        reach = np.unique(np.concatenate([new[neighbours], *passed[g]]))
        boundary = reach[reach >= firsts[g] + sizes[g]]
        # the update goes to the part that eliminates its first row: the parent or one further up
        parent = int(owner[boundary[0]]) if len(boundary) else -1
        if parent >= 0:
            passed[parent].append(boundary)
        parts.append(Supernode(nodes, int(firsts[g]), boundary, parent))
    return parts
