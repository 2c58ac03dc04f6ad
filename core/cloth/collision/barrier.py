"""Barrier energy of the distance between two parts of cloth."""

from __future__ import annotations

import math

import numpy as np

from ...run.kernels import kernel
from ..block_pattern import ABSENT_BLOCK_SLOT, add_block
from .closest import EDGE_EDGE, closest_weights, cross_product_hessian, distance_hessian, mollify, pair_distance

COINCIDENT_REACH_SHARE = 1e-4
"""Distance, as a share of its reach, up to which a pair counts as coincident: 0.2 micrometres. Its barrier is ten
thousand times as stiff as at first contact, and each step keeps a fifth of the distance."""


@kernel(inline="always")
def barrier_function(ratio):  # type: ignore[no-untyped-def]
    """Return b = -(1 - s)^2 ln s, b' and b'' at s in 0 .. 1: infinite at 0, twice continuously differentiable at 1."""
    rest, log = 1.0 - ratio, math.log(ratio)
    return (
        -rest * rest * log,
        2.0 * rest * log - rest * rest / ratio,
        -2.0 * log + 4.0 * rest / ratio + rest * rest / (ratio * ratio),
    )


@kernel()
def barrier(x, pairs, pressure, places, order, exact, derivatives):  # type: ignore[no-untyped-def]
    """Add the gradient (order >= 1) and Hessian blocks (order 2) of contact between pairs and return its energy [J].

    E = w K h m b(d / h),  b(s) = -(1 - s)^2 ln s where s < 1, else 0:  the pressure K |b'(d / h)| is 3 K (1 - s)^2 at
    first contact, 12 K at a tenth of h, infinite at 0 (Li et al. 2020, incremental potential contact).

    Notation: `pairs` a `PairElements`: kinds and nodes; weights w [m2], reaches h [m], limits of the mollifier m of
    nearly parallel edges [m4]; d the least distance of the pair; `pressure` K [Pa]; `places`: `slots` [pair_count, 10]
    of the upper blocks, `ABSENT_BLOCK_SLOT` where the matrix has no place, and those of the diagonal blocks
    [node_count].

    The PSD form is E'' grad d grad d^T: it drops the curvatures of d and m, as contact with the body does. Where the
    matrix has no place, the block-diagonal upper bound |w_a| sum_b |w_b| E'' n n^T is added.

    **Deviation**: the law is of the distance, not of its square, so that K is a pressure.
    """
    kinds, nodes, sizes = pairs
    slots, diagonal = places
    gradient, blocks = derivatives
    energy = 0.0
    weights, rates, vector, slope = np.zeros(4), np.zeros((2, 4)), np.zeros(3), np.zeros((4, 3))
    curve, turn, part = np.zeros((4, 4, 3, 3)), np.zeros((4, 4, 3, 3)), np.zeros((3, 3))
    for n in range(len(kinds)):
        pair, area, thick = nodes[n], sizes[n, 0], sizes[n, 1]
        free = closest_weights(x, pair, kinds[n], weights, rates)
        distance = pair_distance(x, pair, weights, vector)
        if distance >= thick:
            continue
        if distance <= 0.0:
            return np.inf
        scale = area * pressure
        value, first, second = barrier_function(distance / thick)
        value, first, second = scale * thick * value, scale * first, scale * second / thick
        soft, soft_first, soft_second = 1.0, 0.0, 0.0
        if kinds[n] == EDGE_EDGE:
            soft, soft_first, soft_second = mollify(x, pair, sizes[n, 2], slope)
        energy += soft * value
        if order == 0:
            continue
        for a in range(4):
            for d in range(3):
                gradient[pair[a], d] += soft * first * weights[a] * vector[d] / distance
                if soft < 1.0:
                    gradient[pair[a], d] += value * soft_first * slope[a, d]
        if order == 1:
            continue
        if slots[n, 0] == ABSENT_BLOCK_SLOT:
            total = abs(weights[0]) + abs(weights[1]) + abs(weights[2]) + abs(weights[3])
            for a in range(4):
                scale = soft * second * abs(weights[a]) * total / (distance * distance)
                for d in range(3):
                    for e in range(3):
                        blocks[diagonal[pair[a]], d, e] += scale * vector[d] * vector[e]
            continue
        if exact:
            distance_hessian(x, pair, weights, rates, free, vector, distance, curve)
            if soft < 1.0:
                cross_product_hessian(x, pair, turn)
        b = 0
        for i in range(4):
            for j in range(i, 4):
                scale = soft * second * weights[i] * weights[j] / (distance * distance)
                for d in range(3):
                    for e in range(3):
                        entry = scale * vector[d] * vector[e]
                        if exact:
                            entry += soft * first * curve[i, j, d, e]
                            if soft < 1.0:
                                entry += value * (
                                    soft_first * turn[i, j, d, e] + soft_second * slope[i, d] * slope[j, e]
                                )
                                entry += (
                                    first
                                    * soft_first
                                    / distance
                                    * (slope[i, d] * weights[j] * vector[e] + weights[i] * vector[d] * slope[j, e])
                                )
                        part[d, e] = entry
                add_block(blocks, slots[n, b], part)
                b += 1
    return energy


@kernel()
def measure_pairs(x, pairs):  # type: ignore[no-untyped-def]
    """Return the distance of each pair at x [m], shape [pair_count], and the four weights, shape [pair_count, 4]."""
    kinds, nodes, _ = pairs
    distances, shares = np.zeros(len(kinds)), np.zeros((len(kinds), 4))
    rates, vector = np.zeros((2, 4)), np.zeros(3)
    for n in range(len(kinds)):
        closest_weights(x, nodes[n], kinds[n], shares[n], rates)
        distances[n] = pair_distance(x, nodes[n], shares[n], vector)
    return distances, shares


def find_coincident_nodes(nodes: np.ndarray, pairs: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """Return the nodes of coincident pairs at nodes [m], shape [node_count, 3], which contact cannot separate. Two
    nodes may coincide without crossing faces, where cloth was projected out of a crease of the body. `pairs` are
    `PairElements`."""
    if not len(pairs[0]):
        return np.zeros(0, np.int64)
    distances, weights = measure_pairs(nodes, pairs)
    is_coincident = distances <= COINCIDENT_REACH_SHARE * pairs[2][:, 1]
    return np.unique(pairs[1][is_coincident][weights[is_coincident] != 0.0])
