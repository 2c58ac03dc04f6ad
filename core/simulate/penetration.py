"""Take the last millimetres of cloth out of the body, by the exact distance to its mesh (thesis eq. 3.5)."""

from __future__ import annotations

import numpy as np

from ..body import Body, signed_distance

ROUNDS = 12
"""Rounds of pushing: moving a face's corners for its centre may bring a neighbour in again; this settles in 2 to 6."""

NEAR = 0.02
"""Points further out than this [m] are not looked at again: no round moves anything so far."""


def push_out(nodes: np.ndarray, body: Body, faces: np.ndarray | None = None, clearance: float = 1e-3) -> np.ndarray:
    """Move nodes [m], shape [n, 3], that are closer than `clearance` [m] to a body out along the distance's gradient.

    x~ = x + (delta - d(x)) n,  n = grad d / |grad d| (eq. 3.5), delta = `clearance`, wherever d(x) < delta. With the
    cloth's `faces`, the three corners of a face move alike where its centre is inside, until no centre is deeper than
    a tenth of a millimetre. Other nodes stay exactly where they are.

    **Deviation**: the thesis moves only nodes with d < 0 and looks at no faces; with edges of 1.5 cm a face between
    three nodes on the skin cuts up to 1 mm into a limb.
    """
    nodes = np.array(nodes, dtype=np.float64)
    at_nodes, at_faces = np.arange(len(nodes)), np.arange(0 if faces is None else len(faces))
    for _ in range(ROUNDS):
        push = np.zeros_like(nodes)
        distance, normal = signed_distance(body, nodes[at_nodes])
        low = distance < clearance
        push[at_nodes[low]] = (clearance - distance[low])[:, None] * normal[low]
        worst = 0.0
        if faces is not None and len(at_faces):
            depth, outward = signed_distance(body, nodes[faces[at_faces]].mean(1))
            inside = depth < 0
            worst = float(-depth.min(initial=0.0))
            _keep_larger(push, faces[at_faces[inside]], (1e-4 - depth[inside])[:, None] * outward[inside])
            at_faces = at_faces[depth < NEAR]
        at_nodes = at_nodes[distance < NEAR]
        if not (push != 0).any() or (worst < 1e-4 and float(distance.min(initial=1.0)) >= clearance - 1e-5):
            break
        nodes += push
    return nodes


def _keep_larger(push: np.ndarray, corners: np.ndarray, wanted: np.ndarray) -> None:
    """Let each corner move as its face wants to where that is further than it moves already."""
    for k in range(3):
        size = np.linalg.norm(wanted, axis=1)
        order = np.argsort(size, kind="stable")  # the largest wish of all faces around a node is written last
        node, wish = corners[order, k], wanted[order]
        best = np.zeros_like(push)
        best[node] = wish
        larger = (best**2).sum(1) > (push**2).sum(1)
        push[larger] = best[larger]
