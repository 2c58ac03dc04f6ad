"""Compute where open contours are along the skeleton, and the distances between two garments' (thesis algorithm 3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...body.body import Body
from ...scan.contours.target import Contour

_SPINE_JOINTS = ("pelvis", "spine1", "spine2", "spine3", "neck", "head")
_HEM_JOINTS = ("spine3", "spine2", "spine1", "pelvis", "hip", "knee", "ankle", "foot")


@dataclass(frozen=True)
class ContourMeasure:
    """Compare one contour of the draped template with the target's.

    Attributes:
        name: A contour's name.
        distance: From the source's to the target's contour along the limb's bones [m], positive away from the chain's
            root: the length by which the pattern has to grow there.
        source_length, target_length: Circumferences [m].
    """

    name: str
    distance: float
    source_length: float
    target_length: float


def limb_chain(name: str, body: Body) -> np.ndarray:
    """Return the joints [m] that a contour moves along, from the chain's root outwards, shape [joint_count, 3].

    Neck and waist: up the spine; hem: down the spine, then midway between the legs; cuffs and armholes: arm; leg: leg.
    """
    part, _, side = name.partition(".")
    if part in ("neck", "waist"):
        return np.array([body.joint(joint) for joint in _SPINE_JOINTS])
    if part == "hem":
        middle = (body.joint(j) if j.startswith(("spine", "pelvis")) else _between_legs(body, j) for j in _HEM_JOINTS)
        return np.array(list(middle))
    joints = ("hip", "knee", "ankle", "foot") if part == "leg" else ("collar", "shoulder", "elbow", "wrist", "hand")
    return np.array([body.joint(f"{side}_{joint}") for joint in joints])


def position_along(chain: np.ndarray, point: np.ndarray) -> float:
    """Compute the distance along a chain of bones to a point's projection on the nearest bone [m].

    u_i = (p - J_parent) . b_i / |b_i|^2, P_i = J_parent + u_i b_i, h_i = |p - P_i|; the bone with the least h_i counts,
    and the result is the summed length of the bones before it plus u_i |b_i| (thesis algorithm 3, `distToRoot`).

    **Deviation**: u is clamped to 0..1 instead of discarding the bone, except at the chain's two ends, where it may
    exceed it (a cuff over the hand); so no contour is left without a bone.

    Args:
        chain: Joints from the root outwards [m], shape [joint_count, 3].
        point: Centre of a contour [m], shape [3].
    """
    bones = np.diff(chain, axis=0)
    lengths = np.linalg.norm(bones, axis=1)
    low, high = np.zeros(len(bones)), np.ones(len(bones))
    low[0], high[-1] = -np.inf, np.inf
    along = np.clip(((point - chain[:-1]) * bones).sum(1) / lengths**2, low, high)
    off = np.linalg.norm(point - (chain[:-1] + along[:, None] * bones), axis=1)
    nearest = int(np.argmin(off))
    return float(lengths[:nearest].sum() + along[nearest] * lengths[nearest])


def compare_contours(
    source: tuple[np.ndarray, tuple[Contour, ...]], target: tuple[np.ndarray, tuple[Contour, ...]], body: Body
) -> tuple[ContourMeasure, ...]:
    """Measure every contour that both garments have (thesis algorithm 3).

    **Deviation**: contours are matched by name, for names already imply the encircled bones; two contours of one limb
    around different bones (a short sleeve's cuff and a long one's) are compared along the whole limb.

    Args:
        source: Node positions [m], shape [node_count, 3], and named contours of the draped template.
        target: The same of the target.
        body: The wearer of both.
    """
    others = {contour.name: contour for contour in target[1]}
    measures = []
    for contour in source[1]:
        other = others.get(contour.name)
        if other is None:
            continue
        chain = limb_chain(contour.name, body)
        first_points, second_points = (
            position_along(chain, loop_centre(points[c.vertices]))
            for points, c in ((source[0], contour), (target[0], other))
        )
        measures.append(ContourMeasure(contour.name, second_points - first_points, contour.length, other.length))
    return tuple(measures)


def loop_centre(loop: np.ndarray) -> np.ndarray:
    """Return the centre of a closed polygon [m] weighted by length, so independent of its sampling, shape [3]."""
    after = np.roll(loop, -1, axis=0)
    weight = np.linalg.norm(after - loop, axis=1)
    found: np.ndarray = ((loop + after) / 2 * weight[:, None]).sum(0) / weight.sum()
    return found


def _between_legs(body: Body, joint: str) -> np.ndarray:
    found: np.ndarray = (body.joint(f"left_{joint}") + body.joint(f"right_{joint}")) / 2
    return found
