"""Order a mesh's nodes for elimination: nested dissection by breadth-first level sets (George 1973)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

LEAF = 24
"""Most nodes that are not cut any further: fronts of 72 rows, where dense algebra begins to pay."""


@dataclass(frozen=True)
class Part:
    """Hold one set of nodes that are eliminated together, and what their elimination touches.

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


def dissect(indptr: np.ndarray, indices: np.ndarray) -> list[Part]:
    """Cut a symmetric graph (rows of neighbours) into parts, children before parents."""
    count = len(indptr) - 1
    groups: list[np.ndarray] = []
    parents: list[int] = []
    mark = np.zeros(count, dtype=np.int64)
    level = np.full(count, -1, dtype=np.int64)
    # a stack of (nodes, index of the parent group); groups are made parents first and turned round at the end
    stack = [(np.arange(count), -1)]
    token = 0
    while stack:
        nodes, above = stack.pop()
        token += 1
        mark[nodes] = token
        pieces = _cut(indptr, indices, nodes, mark, token, level)
        groups.append(pieces[0])
        parents.append(above)
        here = len(groups) - 1
        if not len(pieces[0]):  # several components without a separator: hang them on the parent above
            groups.pop()
            parents.pop()
            here = above
        stack.extend((piece, here) for piece in pieces[1:] if len(piece))
    return _link(indptr, indices, groups[::-1], [len(groups) - 1 - p if p >= 0 else -1 for p in parents[::-1]])


def _cut(
    indptr: np.ndarray, indices: np.ndarray, nodes: np.ndarray, mark: np.ndarray, token: int, level: np.ndarray
) -> list[np.ndarray]:
    """Give [separator, one side, other side]; [nodes] where they are few; [nothing, component, rest] where apart."""
    if len(nodes) <= LEAF:
        return [nodes]
    queue = np.zeros(len(nodes), dtype=np.int64)
    start = nodes[0]
    for _ in range(3):  # to a node at the far end, so that the level sets are short
        level[nodes] = -1
        reached = _spread_levels(indptr, indices, start, mark, token, level, queue)
        if reached < len(nodes):
            return [nodes[:0], queue[:reached].copy(), nodes[level[nodes] < 0]]
        start = queue[reached - 1]
    depth = level[nodes]
    sizes = np.bincount(depth)
    before = np.cumsum(sizes) - sizes
    after = len(nodes) - before - sizes
    # of the levels that leave at least 30 % on either side the shortest; else the most balanced
    fair = np.minimum(before, after) >= 0.3 * len(nodes)
    if not fair.any():
        best = int(np.argmax(np.minimum(before, after) - 0.5 * sizes))
        if min(before[best], after[best]) == 0:
            return [nodes]
    else:
        best = int(np.flatnonzero(fair)[np.argmin(sizes[fair])])
    low, cut, high = nodes[depth < best], nodes[depth == best], nodes[depth > best]
    loose = ~_touches(indptr, indices, cut, mark, token, level, best + 1)
    return [cut[~loose], np.concatenate([low, cut[loose]]), high]


@njit(cache=True)
def _spread_levels(indptr, indices, start, mark, token, level, queue):  # type: ignore[no-untyped-def]
    """Number nodes by their distance from `start` within the marked set; give how many were reached."""
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


@njit(cache=True)
def _touches(indptr, indices, nodes, mark, token, level, wanted):  # type: ignore[no-untyped-def]
    """Tell which nodes have a neighbour of the wanted level in the marked set."""
    found = np.zeros(len(nodes), dtype=np.bool_)
    for n in range(len(nodes)):
        for at in range(indptr[nodes[n]], indptr[nodes[n] + 1]):
            if mark[indices[at]] == token and level[indices[at]] == wanted:
                found[n] = True
                break
    return found


def _link(indptr: np.ndarray, indices: np.ndarray, groups: list[np.ndarray], parents: list[int]) -> list[Part]:
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
        near = np.concatenate([indices[indptr[n] : indptr[n + 1]] for n in nodes] + [nodes[:0]])
        reach = np.unique(np.concatenate([new[near], *passed[g]]))
        boundary = reach[reach >= firsts[g] + sizes[g]]
        # the update goes to the part that eliminates its first node; that is the parent or one further up
        parent = int(owner[boundary[0]]) if len(boundary) else -1
        if parent >= 0:
            passed[parent].append(boundary)
        parts.append(Part(nodes, int(firsts[g]), boundary, parent))
    return parts
