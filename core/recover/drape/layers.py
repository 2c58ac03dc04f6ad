"""Define half-space constraints of one step: layers of cloth stay apart, and faces stay out of the body."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...run.kernels import kernel

LAYER_MOVE_SHARE = 0.45
"""Share of the distance between two layers by which each may move: less than half."""


class HalfSpaces(NamedTuple):
    """Describe linear constraints on points of cloth: normal . sum_k weights_k x_k >= offset.

    Attributes:
        corners: The nodes that a constraint moves, shape [count, 4].
        weights: Their weights, shape [count, 4].
        normals: Unit length, shape [count, 3].
        offsets: Least value [m], shape [count].
    """

    corners: np.ndarray
    weights: np.ndarray
    normals: np.ndarray
    offsets: np.ndarray

    @classmethod
    def none(cls) -> HalfSpaces:
        """Return no constraints."""
        return cls(np.zeros((0, 4), np.int64), np.zeros((0, 4)), np.zeros((0, 3)), np.zeros(0))

    def room(self, nodes: np.ndarray, reach: float) -> np.ndarray:
        """Return how far each node may move without crossing a layer [m], shape [node_count].

        Two layers at a distance that both move by less than half of it do not meet.

        Args:
            nodes: Positions [m] for which these constraints were found.
            reach: Distance up to which pairs were found [m].
        """
        between = np.einsum("cd,ck,ckd->c", self.normals, self.weights, nodes[self.corners])
        nearest = np.full(len(nodes), reach)
        np.minimum.at(nearest, self.corners.reshape(-1), np.repeat(between, 4))
        return LAYER_MOVE_SHARE * nearest

    def joined(self, other: HalfSpaces) -> HalfSpaces:
        """Return these constraints followed by the others."""
        return HalfSpaces(
            np.concatenate([self.corners, other.corners]),
            np.concatenate([self.weights, other.weights]),
            np.concatenate([self.normals, other.normals]),
            np.concatenate([self.offsets, other.offsets]),
        )


def find_layer_constraints(
    nodes: np.ndarray, faces: np.ndarray, edges: np.ndarray, crossed: np.ndarray, gap: float, reach: float
) -> HalfSpaces:
    """Find near pairs of node and face, and of two edges, and constrain them to their sides of each other.

    Where no two faces cross, the direction between the two nearest points gives the sides. A pair nearer than the gap
    may stay at its distance plus a tenth of the gap, so that layers part without a jerk. Faces that already cross are
    left out: their positions do not show on which side they belong.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        faces: Shape [face_count, 3].
        edges: Each edge of the mesh once, shape [edge_count, 2].
        crossed: Indices of faces that cross others.
        gap: Distance to keep [m].
        reach: Distance up to which pairs are found [m].
    """
    lost_faces, lost_nodes = np.zeros(len(faces), dtype=np.bool_), np.zeros(len(nodes), dtype=np.bool_)
    lost_faces[crossed] = True
    lost_nodes[faces[crossed]] = True
    nodes = np.ascontiguousarray(nodes, dtype=np.float64)
    single = np.arange(len(nodes))[~lost_nodes]
    sheets = np.ascontiguousarray(faces[~lost_faces], dtype=np.int64)
    sides = np.ascontiguousarray(edges[~lost_nodes[edges].all(1)], dtype=np.int64)
    pairs = [_near_faces(nodes, single, sheets, reach), _near_edges(nodes, sides, reach)]
    corners, weights, normals, distances = (np.concatenate(columns) for columns in zip(*pairs, strict=True))
    return HalfSpaces(corners, weights, normals, np.minimum(gap, distances + 0.1 * gap))


@kernel()
def _boxes(nodes, groups):  # type: ignore[no-untyped-def]
    """Return the lowest and highest corners [m] of groups of nodes."""
    low, high = np.zeros((len(groups), 3)), np.zeros((len(groups), 3))
    for g in range(len(groups)):
        for d in range(3):
            low[g, d] = high[g, d] = nodes[groups[g, 0], d]
            for k in range(1, groups.shape[1]):
                low[g, d] = min(low[g, d], nodes[groups[g, k], d])
                high[g, d] = max(high[g, d], nodes[groups[g, k], d])
    return low, high


@kernel()
def _near_faces(nodes, single, faces, reach):  # type: ignore[no-untyped-def]
    """Return pairs of a node and a face within reach; faces are sorted by their lowest y."""
    low, high = _boxes(nodes, faces)
    order = np.argsort(low[:, 1], kind="mergesort")
    low, high, faces = low[order], high[order], faces[order]  # read one by one
    tall = (high[:, 1] - low[:, 1]).max() if len(faces) else 0.0
    found, table, values = 0, np.zeros((64, 4), np.int64), np.zeros((64, 8))
    for i in single:
        x, y, z = nodes[i, 0], nodes[i, 1], nodes[i, 2]
        for f in range(np.searchsorted(low[:, 1], y - reach - tall), len(order)):
            if low[f, 1] > y + reach:
                break
            if (
                (high[f, 1] < y - reach)
                | (low[f, 0] > x + reach)
                | (high[f, 0] < x - reach)
                | (low[f, 2] > z + reach)
                | (high[f, 2] < z - reach)
            ):
                continue
            if i == faces[f, 0] or i == faces[f, 1] or i == faces[f, 2]:
                continue
            if found == len(table):
                table = np.concatenate((table, np.zeros_like(table)))
                values = np.concatenate((values, np.zeros_like(values)))
            table[found, 0] = i
            table[found, 1:] = faces[f]
            if _node_face(nodes, table[found], values[found]) and 1e-9 < values[found, 7] < reach:
                found += 1
    return table[:found], values[:found, :4], values[:found, 4:7], values[:found, 7]


@kernel()
def _near_edges(nodes, edges, reach):  # type: ignore[no-untyped-def]
    """Return pairs of edges within reach that share no node, sorted by their lowest y."""
    low, high = _boxes(nodes, edges)
    order = np.argsort(low[:, 1], kind="mergesort")
    low, high, edges = low[order], high[order], edges[order]  # read one by one
    found, table, values = 0, np.zeros((64, 4), np.int64), np.zeros((64, 8))
    for a in range(len(order)):
        p, q = edges[a]
        west, east, back, front = low[a, 0] - reach, high[a, 0] + reach, low[a, 2] - reach, high[a, 2] + reach
        top = high[a, 1] + reach
        for b in range(a + 1, len(order)):
            if low[b, 1] > top:
                break
            if (low[b, 0] > east) | (high[b, 0] < west) | (low[b, 2] > front) | (high[b, 2] < back):
                continue
            r, s = edges[b]
            if p == r or p == s or q == r or q == s:
                continue
            if found == len(table):
                table = np.concatenate((table, np.zeros_like(table)))
                values = np.concatenate((values, np.zeros_like(values)))
            table[found, 0], table[found, 1], table[found, 2], table[found, 3] = p, q, r, s
            if _edge_edge(nodes, table[found], values[found]) and 1e-9 < values[found, 7] < reach:
                found += 1
    return table[:found], values[:found, :4], values[:found, 4:7], values[:found, 7]


@kernel()
def _finish(nodes, pair, value):  # type: ignore[no-untyped-def]
    """Write the unit vector between the two nearest points and their distance [m] after their four weights."""
    total = 0.0
    for d in range(3):
        part = 0.0
        for k in range(4):
            part += value[k] * nodes[pair[k], d]
        value[4 + d] = part
        total += part * part
    value[7] = np.sqrt(total)
    for d in range(3):
        value[4 + d] /= max(value[7], 1e-300)


@kernel()
def _node_face(nodes, pair, value):  # type: ignore[no-untyped-def]
    """Find the point of a triangle nearest to a node; false where it is on an edge, which `_near_edges` handles."""
    p, a, b, c = pair[0], pair[1], pair[2], pair[3]
    d00, d01, d11, d20, d21 = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        u, v, w = nodes[b, k] - nodes[a, k], nodes[c, k] - nodes[a, k], nodes[p, k] - nodes[a, k]
        d00 += u * u
        d01 += u * v
        d11 += v * v
        d20 += w * u
        d21 += w * v
    area = d00 * d11 - d01 * d01
    if area <= 1e-12 * d00 * d11:
        return False
    s = (d11 * d20 - d01 * d21) / area
    t = (d00 * d21 - d01 * d20) / area
    if s < 0.0 or t < 0.0 or s + t > 1.0:
        return False
    value[0], value[1], value[2], value[3] = 1.0, s + t - 1.0, -s, -t
    _finish(nodes, pair, value)
    return True


@kernel()
def _edge_edge(nodes, pair, value):  # type: ignore[no-untyped-def]
    """Find the nearest points of two segments (Ericson 2005, 5.1.9)."""
    p, q, r, s = pair[0], pair[1], pair[2], pair[3]
    a, e, f, c, b = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        u, v, w = nodes[q, k] - nodes[p, k], nodes[s, k] - nodes[r, k], nodes[p, k] - nodes[r, k]
        a += u * u
        e += v * v
        f += v * w
        c += u * w
        b += u * v
    if a <= 1e-18 or e <= 1e-18:
        return False
    area = a * e - b * b
    one = 0.5
    if area > 1e-12 * a * e:
        one = min(1.0, max(0.0, (b * f - c * e) / area))
    two = (b * one + f) / e
    if two < 0.0:
        two, one = 0.0, min(1.0, max(0.0, -c / a))
    elif two > 1.0:
        two, one = 1.0, min(1.0, max(0.0, (b - c) / a))
    value[0], value[1], value[2], value[3] = 1.0 - one, one, two - 1.0, -two
    _finish(nodes, pair, value)
    return True
