"""Coulomb friction of cloth on cloth, as a potential with lagged normal forces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...run.kernels import kernel
from ..block_pattern import ABSENT_BLOCK_SLOT, add_block
from ..friction import mobilise
from .barrier import barrier_function, measure_pairs
from .near_pairs import NearPairs
from .self_contact import SelfContact


@dataclass(frozen=True)
class ClothFriction:
    """Describe the state of cloth-on-cloth friction that is constant during a solve.

    Attributes:
        keys: Kind and nodes of each pair in contact, shape [pair_count, 5].
        weights: Of r = sum_k w_k x_k, the vector between the closest points, shape [pair_count, 4].
        normals: Its direction, shape [pair_count, 3].
        limits: Coefficient times normal force [N], shape [pair_count].
        anchors: The r at which each pair sticks [m], shape [pair_count, 3].
        slip: Displacement at which friction is fully mobilised [m].
    """

    keys: np.ndarray
    weights: np.ndarray
    normals: np.ndarray
    limits: np.ndarray
    anchors: np.ndarray
    slip: float

    @property
    def elements(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
        """Return the arrays of the kernel."""
        return self.keys, self.weights, self.normals, self.limits, self.anchors, self.slip

    def strain(self, nodes: np.ndarray) -> np.ndarray:
        """Return the tangential displacement of each pair from its anchor [m], at most `slip`, [pair_count, 3]."""
        drawn = np.einsum("nk,nkd->nd", self.weights, nodes[self.keys[:, 1:]]) - self.anchors
        drawn -= (drawn * self.normals).sum(1, keepdims=True) * self.normals
        length = np.sqrt((drawn**2).sum(1, keepdims=True))
        return np.asarray(drawn * np.minimum(1.0, self.slip / np.maximum(length, 1e-300)))


def lag_cloth_friction(
    cloth: SelfContact, near_pairs: NearPairs, nodes: np.ndarray, before: ClothFriction | None
) -> ClothFriction | None:
    """Compute the friction of the near pairs in contact at nodes [m], shape [node_count, 3]; None without any. A pair
    that was in contact before keeps its displacement, up to `slip`; any other sticks where it is."""
    pairs = near_pairs.within(nodes, 0.0)
    if cloth.settings.friction <= 0 or not len(pairs.kinds):
        return None
    distances, weights = measure_pairs(nodes, pairs)
    vectors = np.einsum("nk,nkd->nd", weights, nodes[pairs.nodes])
    normals = vectors / distances[:, None]
    slopes = np.array([barrier_function(ratio)[1] for ratio in distances / pairs.sizes[:, 1]])
    limits = -cloth.settings.friction * cloth.settings.stiffness * pairs.sizes[:, 0] * slopes
    keys = np.column_stack([pairs.kinds, pairs.nodes])
    drawn = np.zeros_like(vectors)
    if before is not None:
        drawn = _inherit(keys, before, before.strain(nodes))
        drawn -= (drawn * normals).sum(1, keepdims=True) * normals
    return ClothFriction(keys, weights, normals, limits, vectors - drawn, cloth.settings.slip)


def _inherit(keys: np.ndarray, before: ClothFriction, strain: np.ndarray) -> np.ndarray:
    """Return the displacement [m] that each pair had before, shape [pair_count, 3]; zero for new pairs."""
    _, where, inverse = np.unique(np.concatenate([before.keys, keys]), axis=0, return_index=True, return_inverse=True)
    first = where[inverse.ravel()[len(before.keys) :]]
    known = first < len(before.keys)
    found = np.zeros((len(keys), 3))
    found[known] = strain[first[known]]
    return found


@kernel()
def cloth_friction(x, elements, places, order, derivatives):  # type: ignore[no-untyped-def]
    """Add the friction's gradient (order >= 1) and Hessian blocks (order 2) and return its energy [J].

    E = L f(|u|),  u = (I - n n^T)(sum_k w_k x_k - a), f as in `friction`: the force on node k is w_k L f'(|u|) u / |u|,
    equal and opposite on both sides. `places` as in `barrier`; `elements` a `ClothFriction`'s `elements`.
    """
    keys, weights, normals, limits, anchors, slip = elements
    slots, diagonal = places
    gradient, blocks = derivatives
    energy = 0.0
    u, turn, part = np.zeros(3), np.zeros((3, 3)), np.zeros((3, 3))
    for n in range(len(limits)):
        limit, pair = limits[n], keys[n, 1:]
        along = 0.0
        for d in range(3):
            u[d] = -anchors[n, d]
            for k in range(4):
                u[d] += weights[n, k] * x[pair[k], d]
            along += u[d] * normals[n, d]
        square = 0.0
        for d in range(3):
            u[d] -= along * normals[n, d]
            square += u[d] * u[d]
        y = np.sqrt(square)
        value, over, second = mobilise(y, square, slip)
        energy += limit * value
        if order == 0:
            continue
        for k in range(4):
            for d in range(3):
                gradient[pair[k], d] += weights[n, k] * limit * over * u[d]
        if order == 1:
            continue
        for d in range(3):
            for e in range(3):
                value = -over * normals[n, d] * normals[n, e]
                if d == e:
                    value += over
                if y > 0.0:
                    value += (second - over) * (u[d] / y) * (u[e] / y)
                turn[d, e] = limit * value
        if slots[n, 0] == ABSENT_BLOCK_SLOT:
            total = np.abs(weights[n]).sum()
            for k in range(4):
                blocks[diagonal[pair[k]]] += abs(weights[n, k]) * total * turn
            continue
        b = 0
        for i in range(4):
            for j in range(i, 4):
                part[:] = weights[n, i] * weights[n, j] * turn
                add_block(blocks, slots[n, b], part)
                b += 1
    return energy
