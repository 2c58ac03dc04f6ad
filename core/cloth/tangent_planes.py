"""Contact with a moving body by tangent planes at the skin nearest to each node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..body.signed_distance import SignedDistance
from ..run.kernels import kernel

ABSENT_PLANE_OFFSET = -1e9
"""Offset of a plane that no node comes near [m]."""

REMEASURE_MARGIN = 1e-6
"""Distance beyond reach at which a node is not measured again [m]: far above rounding."""

OPPOSING_PLANE_COSINE = 0.5
"""Cosine between two planes' normals below which they belong to two surfaces: the sides of a crease or of a gap."""


class PlaneArrays(NamedTuple):
    """Planes as `plane_contact` takes them; see `TangentPlanes`."""

    normals: np.ndarray
    offsets: np.ndarray


@dataclass(frozen=True)
class TangentPlanes:
    """Describe a body near cloth for a few steps: planes through the feet of the nodes on the skin.

        d_vk(x) = n_vk . x - o_vk

    Exact where it was measured; after a slide by s along skin of radius R the distance is s^2 / 2R too large, 0.25 mm
    for 5 mm on a limb of 5 cm. Only a search of each node's foot is needed; a distance grid takes over a second per
    pose.

    Attributes:
        normals: Unit normals of the plane nearest last and of one that faces it, shape [2, node_count, 3].
        offsets: Offsets [m], `ABSENT_PLANE_OFFSET` where a node has no plane, shape [2, node_count].
        places: Position of each node when its distance was measured last [m], shape [node_count, 3].
        distances: The distance then [m], shape [node_count].
    """

    normals: np.ndarray
    offsets: np.ndarray
    places: np.ndarray
    distances: np.ndarray

    @classmethod
    def none(cls, count: int) -> TangentPlanes:
        """Return no plane for any node."""
        return cls(
            np.zeros((2, count, 3)), np.full((2, count), ABSENT_PLANE_OFFSET), np.zeros((count, 3)), np.zeros(count)
        )

    def renewed(self, nodes: np.ndarray, body: SignedDistance, reach: float) -> TangentPlanes:
        """Return the planes of nodes [m], shape [node_count, 3], that are nearer to a body than a reach [m]. Of the
        planes before, one that faces the new one is kept while it is within reach: in a crease, where the nearest side
        changes with every move, the node then stays off both sides. A node without a plane that cannot have come within
        reach is not measured again, since a distance changes by at most the node's displacement."""
        shift = np.sqrt(((nodes - self.places) ** 2).sum(axis=1))
        moved = np.flatnonzero(
            (self.distances - shift < reach + REMEASURE_MARGIN) | (self.offsets > ABSENT_PLANE_OFFSET).any(axis=0)
        )
        distance, normals = self.distances.copy(), np.zeros_like(nodes)
        places = self.places.copy()
        if len(moved):
            places[moved] = nodes[moved]
            distance[moved], normals[moved] = body.measure(nodes[moved])
        offsets = np.where(distance < reach, (normals * nodes).sum(axis=1) - distance, ABSENT_PLANE_OFFSET)
        second, plane_offsets = np.zeros_like(normals), np.full(len(nodes), ABSENT_PLANE_OFFSET)
        for each, offset in zip(self.normals[::-1], self.offsets[::-1], strict=True):
            faces = ((each * normals).sum(axis=1) < OPPOSING_PLANE_COSINE) & (
                (each * nodes).sum(axis=1) - offset < reach
            )
            second, plane_offsets = np.where(faces[:, None], each, second), np.where(faces, offset, plane_offsets)
        return TangentPlanes(np.stack([normals, second]), np.stack([offsets, plane_offsets]), places, distance)

    @property
    def arrays(self) -> PlaneArrays:
        """Return the planes as the kernel takes them."""
        return PlaneArrays(self.normals, self.offsets)


@kernel()
def plane_contact(x, planes, nodes, law, order, exact, derivatives, forces):  # type: ignore[no-untyped-def]
    """Add the contact's gradient (order >= 1) and Hessian blocks (order 2) and return its energy [J].

    E_v = sum_k a_v c / 3 (delta - d_vk(x_v))^3 where d_vk < delta: the law of `contact`, with planes for the grid. The
    Hessian is exact in both forms, since planes have no curvature.

    Notation: `planes` a `PlaneArrays`; the rest as in `contact`, c [N/m4] the stiffness. `forces` gets the sum of both
    planes' forces and the direction of the larger one.
    """
    areas, diagonal = nodes
    stiffness, thickness = law
    gradient, blocks = derivatives
    force, normal = forces
    normals, offsets = planes
    energy = 0.0
    for v in range(x.shape[0]):
        force[v], most = 0.0, 0.0
        scale = areas[v] * stiffness
        for k in range(offsets.shape[0]):
            n = normals[k, v]
            depth = thickness + offsets[k, v] - (n[0] * x[v, 0] + n[1] * x[v, 1] + n[2] * x[v, 2])
            if not depth > 0.0:
                continue
            energy += scale * depth * depth * depth / 3.0
            if order == 0:
                continue
            first, second = scale * depth * depth, 2.0 * scale * depth
            force[v] += first
            for d in range(3):
                gradient[v, d] -= first * n[d]
                if first > most:
                    normal[v, d] = n[d]
            most = max(most, first)
            if order == 1:
                continue
            b = diagonal[v]
            for d in range(3):
                for e in range(3):
                    blocks[b, d, e] += second * n[d] * n[e]
    return energy
