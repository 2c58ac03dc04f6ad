"""Coulomb friction against the body (thesis 3.2.4.4), as a potential with lagged normal forces."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..run.kernels import kernel
from .contact import contact_forces
from .scene import Scene

__all__ = ["Friction", "lag_friction"]


class Friction(NamedTuple):
    """Describe the state of friction that is constant during a solve.

    Attributes:
        anchors: Where each node sticks [m], shape [node_count, 3].
        normals: Unit contact normals, shape [node_count, 3].
        limits: Coefficient times normal force [N], shape [node_count]; 0 off the body.
        slip: Displacement at which friction is fully mobilised [m].
    """

    anchors: np.ndarray
    normals: np.ndarray
    limits: np.ndarray
    slip: float

    def slide(self, nodes: np.ndarray) -> np.ndarray:
        """Return the anchors with the cloth at `nodes`, both [node_count, 3] [m]: beyond `slip` they follow; off the
        body they are the nodes."""
        moved = nodes - self.anchors
        along = (moved * self.normals).sum(1, keepdims=True) * self.normals
        tangent = moved - along
        length = np.linalg.norm(tangent, axis=1, keepdims=True)
        kept = tangent * np.minimum(1.0, self.slip / np.maximum(length, 1e-300))
        return np.where(self.limits[:, None] > 0, nodes - kept, nodes)


def lag_friction(scene: Scene, nodes: np.ndarray, anchors: np.ndarray) -> Friction | None:
    """Compute the friction of the contact forces at nodes [m], or None where there is none. For a derivative, which
    takes friction as constant, `nodes` and `anchors`, [node_count, 3], are those of a drape."""
    if scene.body is None or not scene.contact.friction or not np.any(scene.per_node("friction")):
        return None
    force, normals = contact_forces(scene, nodes)
    return Friction(anchors, normals, scene.per_node("friction") * force, scene.contact.slip)


@kernel(inline="always")
def mobilise(y, square, slip):  # type: ignore[no-untyped-def]
    """Return f(y), f'(y) / y and f''(y) of friction at a displacement y [m], y^2 = `square`, fully mobilised at
    `slip`."""
    if y < slip:
        return (
            square / slip - square * y / (3.0 * slip * slip),
            2.0 / slip - y / (slip * slip),
            2.0 / slip - 2.0 * y / (slip * slip),
        )
    return y - slip / 3.0, 1.0 / y, 0.0


@kernel()
def friction(x, contact, order, diagonal, derivatives):  # type: ignore[no-untyped-def]
    """Add friction's gradient (order >= 1) and Hessian blocks (order 2) and return its energy [J].

    E_v = L_v f(|u|),  u = (I - n n^T)(x - a),  f(y) = y^2/s - y^3/(3 s^2) for y < s, else y - s/3; f'(y >= s) = 1.

    Notation: `contact` a `Friction`: anchors a [m]; normals n; limits L = mu N [N], lagged; slip s [m]. The force never
    exceeds mu N and opposes the motion away from the anchor; below s it is elastic, so a block at rest does not creep.
    Smoothed as by Li et al. 2020 (incremental potential contact), with an anchor in place of the last time step.
    """
    anchors, normals, limits, slip = contact
    gradient, blocks = derivatives
    energy = 0.0
    u = np.zeros(3)
    for v in range(x.shape[0]):
        limit = limits[v]
        if limit <= 0.0:
            continue
        along = 0.0
        for d in range(3):
            along += (x[v, d] - anchors[v, d]) * normals[v, d]
        square = 0.0
        for d in range(3):
            u[d] = x[v, d] - anchors[v, d] - along * normals[v, d]
            square += u[d] * u[d]
        y = np.sqrt(square)
        value, over, second = mobilise(y, square, slip)
        energy += limit * value
        if order == 0:
            continue
        for d in range(3):
            gradient[v, d] += limit * over * u[d]
        if order == 1:
            continue
        b = diagonal[v]
        for d in range(3):
            for e in range(3):
                value = -over * normals[v, d] * normals[v, e]
                if d == e:
                    value += over
                if y > 0.0:
                    value += (second - over) * (u[d] / y) * (u[e] / y)
                blocks[b, d, e] += limit * value
    return energy
