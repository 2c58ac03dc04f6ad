"""Move cloth out of the body: every delivered mesh is cleared of the exposed skin here (thesis eq. 3.5)."""

from __future__ import annotations

import numpy as np

from ..geometry.intersections import self_intersections
from .advection import advect_outside
from .exposed import ExposedSurface

MAX_BODY_PUSH_ITERATIONS = 12
"""Largest number of iterations that move cloth out of the body. Moving a face's corners for its centre may move a
neighbour inside; 2 to 6 iterations suffice."""

REDUCED_CLEARANCE_SHARES = (0.5, 0.1)
"""Shares of the clearance that are tried where all of it makes cloth cross, as in gaps narrower than two clearances."""


def project_outside(
    nodes: np.ndarray, skin: ExposedSurface, faces: np.ndarray | None = None, clearance: float = 1e-3
) -> np.ndarray:
    """Move nodes [m], shape [n, 3], that are closer than `clearance` [m] to a body's exposed skin out of it.

    x~ = x + (delta - d(x)) n,  n = grad d / |grad d| (eq. 3.5), delta = `clearance`, wherever d(x) < delta. With the
    cloth's `faces`, the three corners of a face whose centre is inside move alike, until no centre is deeper than 0.1
    mm. Other nodes do not move. Nodes inside leave all of the body, however long the way past parts that intersect.

    Where the cloth then crosses itself (nodes of several layers move to one rim), `advect_outside` first moves the
    nodes inside together with the cloth around them, and smaller clearances are tried: the first that crosses no more
    than before is taken, else the one that crosses least.

    **Deviation**: the thesis moves only nodes with d < 0 and ignores faces; with edges of 1.5 cm a face between three
    nodes on the skin cuts up to 1 mm into a limb.
    """
    nodes = np.array(nodes, dtype=np.float64)
    if faces is None or not len(faces):
        return _push(nodes, skin, np.zeros((0, 3), dtype=np.int64), clearance)
    best = _push(nodes, skin, faces, clearance)
    before, least = (len(self_intersections(each, faces)) for each in (nodes, best))
    if least <= before:
        return best
    carried = _advect(nodes, faces, skin, clearance)
    for share in (1.0, *REDUCED_CLEARANCE_SHARES):
        tried = _push(carried, skin, faces, share * clearance)
        crossing = len(self_intersections(tried, faces))
        if crossing < least:
            best, least = tried, crossing
        if least <= before:
            break
    return best


def limit_penetration(nodes: np.ndarray, faces: np.ndarray, skin: ExposedSurface, depth: float) -> np.ndarray:
    """Move nodes, and faces by their corners, that are deeper in a body than a depth [m] up to it; others do not move.

    Args:
        nodes: Positions [m], shape [n, 3].
        faces: Shape [m, 3].
        skin: The body's exposed skin.
        depth: Depth that may remain [m].
    """
    for _ in range(MAX_BODY_PUSH_ITERATIONS):
        distance, push = exit_displacements(nodes, skin, -depth)
        push[distance >= -depth] = 0.0
        middle, outward = exit_displacements(nodes[faces].mean(axis=1), skin, -depth)
        low = middle < -depth
        _keep_larger(push, faces[low], outward[low])
        if not push.any():
            break
        nodes = nodes + push
    return nodes


def _advect(nodes: np.ndarray, faces: np.ndarray, skin: ExposedSurface, clearance: float) -> np.ndarray:
    """Advect cloth out of the body by a displacement field as wide as the cloth's mean edge."""
    edge = float(np.linalg.norm(nodes[faces] - nodes[faces[:, [1, 2, 0]]], axis=2).mean())
    return advect_outside(nodes, faces, skin, edge, clearance=clearance)


def _push(nodes: np.ndarray, skin: ExposedSurface, faces: np.ndarray, clearance: float) -> np.ndarray:
    """Move each node on its own, and each face by its corners."""
    nodes = nodes.copy()
    at_nodes, at_faces = np.arange(len(nodes)), np.arange(len(faces))
    for _ in range(MAX_BODY_PUSH_ITERATIONS):
        push = np.zeros_like(nodes)
        distance, displacement = exit_displacements(nodes[at_nodes], skin, clearance)
        push[at_nodes] = displacement
        worst = 0.0
        if len(at_faces):
            depth, outward = exit_displacements(nodes[faces[at_faces]].mean(1), skin, 1e-4)
            inside = depth < 0
            worst = float(-depth.min(initial=0.0))
            _keep_larger(push, faces[at_faces[inside]], outward[inside])
        # Whatever moved is measured again, including nodes that a face moved; also what is inside without a
        # displacement: at the clearance from one side of a crease, and behind the other.
        moved = (push != 0).any(axis=1)
        at_faces = np.flatnonzero(moved[faces].any(axis=1))
        at_nodes = np.union1d(np.flatnonzero(moved), at_nodes[distance < 0])
        if not moved.any() or (worst < 1e-4 and float(distance.min(initial=1.0)) >= clearance - 1e-5):
            break
        nodes += push
    # A clearance from one side of a sharp crease may be inside the other side: such nodes move to the crease's rim.
    stuck = at_nodes[skin.measure(nodes[at_nodes])[0] < 0]
    if len(stuck):
        nodes[stuck] = skin.closest(nodes[stuck]).foot
    return nodes


def exit_displacements(points: np.ndarray, skin: ExposedSurface, clearance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return signed distances of points [m], and displacements of those that are too low to a clearance, [n, 3].

    Points inside move to the nearest exposed skin and on along its normal: in a crease that skin ends, and the
    direction of the way there leads from one part of the body into the other, and back in the next iteration.

    Args:
        points: Shape [n, 3].
        skin: The wearer.
        clearance: Distance from the skin to reach [m].
    """
    distance, normal = skin.measure(points)
    move = np.maximum(clearance - distance, 0.0)[:, None] * normal
    inside = np.flatnonzero(distance < 0)
    if len(inside):
        found = skin.closest(points[inside])
        move[inside] = found.foot + clearance * skin.normals[found.face] - points[inside]
    return distance, move


def _keep_larger(push: np.ndarray, corners: np.ndarray, face_push: np.ndarray) -> None:
    """Replace each corner's displacement by its face's where that is longer."""
    for k in range(3):
        size = np.linalg.norm(face_push, axis=1)
        order = np.argsort(size, kind="stable")  # the largest move of all faces around a node is written last
        node, candidate = corners[order, k], face_push[order]
        best = np.zeros_like(push)
        best[node] = candidate
        larger = (best**2).sum(1) > (push**2).sum(1)
        push[larger] = best[larger]
