"""The hollow between the trunk and a hanging arm, where cloth is hidden from a scanner."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.geometry import vertex_normals
from .body import JOINT_PARENTS, JOINTS, Body

MAX_HANGING_ANGLE = math.radians(30.0)
"""Angle between upper arm and trunk below which an arm hangs [rad]. In an A pose, 45 degrees and more, a scanner sees
the armpit; in the everyday pose, 10 to 20 degrees, it does not."""

MAX_HIDDEN_GAP_WIDTH = 0.025
"""Largest width of a hidden hollow [m]: two layers of cloth with seams. Scans merge the sides of a narrower one."""

ARMPIT_FACING_COSINE = 0.3
"""Cosine between the normals of arm and trunk below which a point is in the hollow between them, not on a shoulder."""


def find_hanging_arms(body: Body) -> tuple[str, ...]:
    """Find the sides, `left` or `right`, whose upper arm is within `MAX_HANGING_ANGLE` of the trunk's direction."""
    down = body.joint("pelvis") - body.joint("neck")
    found = []
    for side in ("left", "right"):
        arm = body.joint(f"{side}_elbow") - body.joint(f"{side}_shoulder")
        if float(arm @ down) > math.cos(MAX_HANGING_ANGLE) * float(np.linalg.norm(arm) * np.linalg.norm(down)):
            found.append(side)
    return tuple(found)


def lies_under_arm(points: np.ndarray, body: Body) -> np.ndarray:
    """Find the points [m], shape [n, 3], between the trunk and an arm that hangs beside it; bool, shape [n]. Their
    distances to both, by the nearest vertices' tangent planes, sum to less than `MAX_HIDDEN_GAP_WIDTH`, and both face
    each other."""
    found = np.zeros(len(points), dtype=bool)
    sides = find_hanging_arms(body)
    if not sides:
        return found
    normals = vertex_normals(body.vertices, body.faces)
    arms = {side: _weight_below(body, f"{side}_shoulder") > 0.5 for side in ("left", "right")}
    trunk = ~(arms["left"] | arms["right"])
    inner, inner_normal = _measure(points, body.vertices[trunk], normals[trunk])
    for side in sides:
        outer, outer_normal = _measure(points, body.vertices[arms[side]], normals[arms[side]])
        found |= (inner + outer < MAX_HIDDEN_GAP_WIDTH) & (
            (inner_normal * outer_normal).sum(axis=1) < ARMPIT_FACING_COSINE
        )
    return found


def _measure(points: np.ndarray, vertices: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return each point's distance to the tangent plane of its nearest vertex [m] and that vertex' normal."""
    nearest = cKDTree(vertices).query(points)[1]
    return np.abs(((points - vertices[nearest]) * normals[nearest]).sum(axis=1)), normals[nearest]


def _weight_below(body: Body, joint: str) -> np.ndarray:
    """Return the share of each vertex that moves with a joint or its descendants, shape [n]."""
    chosen = {JOINTS.index(joint)}
    for child, parent in enumerate(JOINT_PARENTS):
        if parent in chosen:
            chosen.add(child)
    return np.asarray(body.weights[:, sorted(chosen)].sum(axis=1))
