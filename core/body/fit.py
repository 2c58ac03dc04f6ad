"""Fit the articulated template to points of a surface by Gauss-Newton, correspondences found anew in each step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial import cKDTree

from .body import JOINTS, PARENTS
from .template import Template, articulate, cross_matrices, rotations_of

_BELOW = np.zeros((24, 24))
"""Row j marks joint j and all joints below it."""
for _k in range(24):
    _j = _k
    while _j >= 0:
        _BELOW[_j, _k] = 1.0
        _j = PARENTS[_j]


def _spreads() -> np.ndarray:
    """Give the standard deviations [rad] of each joint's axis-angle in everyday poses, shape [24, 3].

    Assumed from the ranges of human joints: hinges wide about their axis only, ball joints wide, spine and feet narrow.
    """
    spread = np.full((24, 3), 0.15)
    table = {
        "hip": (0.8, 0.35, 0.35), "knee": (0.9, 0.08, 0.08), "ankle": (0.35, 0.2, 0.15), "foot": (0.1, 0.03, 0.03),
        "collar": (0.1, 0.2, 0.2), "shoulder": (0.5, 0.8, 0.8), "elbow": (0.3, 1.0, 0.15), "wrist": (0.3, 0.3, 0.4),
        "hand": (0.1, 0.1, 0.15), "neck": (0.3, 0.3, 0.2), "head": (0.3, 0.3, 0.2), "spine": (0.2, 0.15, 0.12),
    }  # fmt: skip
    for j, name in enumerate(JOINTS):
        for part, values in table.items():
            if part in name:
                spread[j] = values
    spread[0] = np.inf
    return spread


SPREADS = _spreads()
HINGES = (("left_knee", 0, 1.0), ("right_knee", 0, 1.0), ("left_elbow", 1, -1.0), ("right_elbow", 1, 1.0))
"""Joint, axis and sign of the only way it bends: the shank goes back, the forearm forward."""
HINGE_SLACK = 0.1
"""Overextension [rad] that a hinge allows for free, and the spread of what goes beyond."""


@dataclass(frozen=True)
class Surface:
    """Hold points of a surface with outward unit normals.

    Attributes:
        points: Positions [m], shape [n, 3].
        normals: Unit normals, shape [n, 3].
        cloth: True where the point lies on cloth, which hides the body, shape [n]; None: nowhere.
    """

    points: np.ndarray
    normals: np.ndarray
    cloth: np.ndarray | None = None


@dataclass(frozen=True)
class State:
    """Hold a fit: shape [k], local rotations [24, 3, 3], translation [m], shape [3]."""

    shape: np.ndarray
    rotations: np.ndarray
    translation: np.ndarray


@dataclass(frozen=True)
class Stage:
    """Say how one stage of the fit goes.

    Attributes:
        steps: Gauss-Newton steps.
        scale: Distance [m] beyond which a pair of points counts little, and the noise that the priors are weighed by.
        normal_length: Length [m] that a unit of difference in normals counts as in the search for pairs.
        plane: Measure pairs along the normal; else in all three axes, which pulls from further away.
        shape_count: Shape coefficients that are free.
        cloth_pull: Weight of a pair with cloth that lies outside the body, beside 1 for skin.
    """

    steps: int
    scale: float
    normal_length: float
    plane: bool
    shape_count: int
    cloth_pull: float = 0.3


EVIDENCE = 3000.0
"""Observations that a whole surface counts for against the priors, so that 1 cm everywhere outweighs a few standard
deviations of shape. 300 held mannequins with long arms back (16 mm RMS instead of 8); 5000 gained a millimetre more."""
CLOTH_REACH = 3.0
"""A point of the body that sticks out of cloth is believed up to so many times the scale of a stage: unlike a gap, it
is never what the wearer looks like."""


class Fitter:
    """Fit a template, seen at a subset of its vertices, to a surface."""

    def __init__(self, template: Template, subset: np.ndarray, surface: Surface) -> None:
        """Take the template, indices of the vertices used, and the surface's points."""
        self.template = template
        self.vertices = template.vertices[subset]
        self.directions = np.ascontiguousarray(template.directions[:, subset].transpose(1, 2, 0))
        self.weights = template.weights[subset]
        normals = vertex_normals(template.vertices, template.faces)
        self.normals = normals[subset]
        self.surface = surface

    def fit(self, state: State, stage: Stage) -> State:
        """Improve a state by one stage."""
        s = self.surface
        tree = cKDTree(np.hstack([s.points, stage.normal_length * s.normals]))
        for _ in range(stage.steps):
            state = self._step(state, stage, tree)
        return state

    def residual(self, state: State, scale: float, normal_length: float) -> float:
        """Give the robust two-way misfit of a state: mean of min(d, scale) over pairs, normals counted in d [m]."""
        points, normals = self._place(state)[:2]
        ours = np.hstack([points, normal_length * normals])
        theirs = np.hstack([self.surface.points, normal_length * self.surface.normals])
        there, _ = cKDTree(theirs).query(ours, distance_upper_bound=scale)
        back, _ = cKDTree(ours).query(theirs, distance_upper_bound=scale)
        return float(np.minimum(there, scale).mean() + np.minimum(back, scale).mean()) / 2

    def _place(self, state: State) -> tuple[np.ndarray, ...]:
        """Give points [m, 3], normals [m, 3], copies per joint [m, 24, 3], world rotations, joints, rest joints."""
        k = len(state.shape)
        rest = self.vertices + self.directions[:, :, :k] @ state.shape
        joints = self.template.joints + np.tensordot(state.shape, self.template.joint_directions[:k], axes=1)
        world, posed = articulate(state.rotations, joints, state.translation)
        shift = posed - np.einsum("jab,jb->ja", world, joints)
        moved = np.einsum("jab,mb->mja", world, rest, optimize=True) + shift
        points = np.einsum("mj,mja->ma", self.weights, moved)
        normals = np.einsum("mab,mb->ma", np.tensordot(self.weights, world, axes=1), self.normals)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return points, normals, moved, world, posed, joints

    def _step(self, state: State, stage: Stage, tree: cKDTree) -> State:
        points, normals, moved, world, posed, _ = self._place(state)
        row, chosen = self._pairs(points, normals, stage, tree)
        direction = self.surface.normals[chosen]
        offset = points[row] - self.surface.points[chosen]
        robust = self._trust(offset, direction, chosen, stage)
        blocks, rhs = [], []
        pose_block, shape_block = self._derivatives(state, stage.shape_count, moved, world, posed)
        axes = [direction] if stage.plane else [np.tile(e, (len(row), 1)) for e in np.eye(3)]
        for n in axes:
            value = np.einsum("ra,ra->r", n, offset)
            blocks.append(
                np.hstack(
                    [
                        np.einsum("ra,rap->rp", n, pose_block[row], optimize=True),
                        n,
                        np.einsum("ra,rak->rk", n, shape_block[row], optimize=True),
                    ]
                )
            )
            rhs.append(value)
        jacobian, value = np.vstack(blocks), np.concatenate(rhs)
        weight = np.tile(robust, len(axes)) * (EVIDENCE / len(row) / stage.scale**2)
        normal = (jacobian * weight[:, None]).T @ jacobian
        gradient = jacobian.T @ (weight * value)
        self._add_priors(state, stage.shape_count, normal, gradient)
        step = cho_solve(cho_factor(normal + 1e-9 * np.trace(normal) / len(normal) * np.eye(len(normal))), -gradient)
        return _advance(state, step, stage.shape_count)

    def _pairs(
        self, points: np.ndarray, normals: np.ndarray, stage: Stage, tree: cKDTree
    ) -> tuple[np.ndarray, np.ndarray]:
        """Pair each of our points with the surface and each of the surface's with us: rows of ours and of theirs."""
        s, length = self.surface, stage.normal_length
        ours = np.hstack([points, length * normals])
        _, there = tree.query(ours)
        _, back = cKDTree(ours).query(np.hstack([s.points, length * s.normals]))
        return np.concatenate([np.arange(len(points)), back]), np.concatenate([there, np.arange(len(s.points))])

    def _trust(self, offset: np.ndarray, direction: np.ndarray, chosen: np.ndarray, stage: Stage) -> np.ndarray:
        """Give the weight of each pair by its offset [m], shape [n, 3]: pairs far beyond the scale stop pulling.

        Geman-McClure, (s^2 / (s^2 + |offset|^2))^2. Cloth hides a body that may lie well below it: there a pair counts
        in full where the body is outside the cloth, and little where it is inside.
        """
        length2, scale2 = (offset**2).sum(axis=1), np.full(len(offset), stage.scale**2)
        if self.surface.cloth is None:
            return np.asarray((scale2 / (scale2 + length2)) ** 2)
        cloth = self.surface.cloth[chosen]
        outside = cloth & (np.einsum("ra,ra->r", offset, direction) > 0)
        scale2[outside] *= CLOTH_REACH**2
        weight = np.where(cloth & ~outside, stage.cloth_pull, 1.0)
        return np.asarray(weight * (scale2 / (scale2 + length2)) ** 2)

    def _derivatives(
        self, state: State, shape_count: int, moved: np.ndarray, world: np.ndarray, posed: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Give the derivatives of our points by rotations in the parents' frames [m, 3, 72] and by shape [m, 3, k].

        A small turn w about joint j moves the part of a point that hangs below it: dx = w x (S - C p_j), with S the
        weighted sum of its moved copies below j and C the sum of those weights.
        """
        parts = np.matmul(_BELOW, self.weights[:, :, None] * moved)
        share = self.weights @ _BELOW.T
        arms = parts - share[:, :, None] * posed
        frames = np.stack([np.eye(3) if p < 0 else world[p] for p in PARENTS])
        turn = -np.einsum("mjab,jbc->majc", cross_matrices(arms), frames, optimize=True)
        t = self.template
        joint_slopes = t.joint_directions[:shape_count].transpose(1, 2, 0)
        posed_slopes = np.zeros_like(joint_slopes)
        for j, p in enumerate(PARENTS):
            posed_slopes[j] = (
                joint_slopes[j] if p < 0 else posed_slopes[p] + world[p] @ (joint_slopes[j] - joint_slopes[p])
            )
        shift = posed_slopes - world @ joint_slopes
        blended = np.tensordot(self.weights, world, axes=1)
        shape = blended @ self.directions[:, :, :shape_count] + np.tensordot(self.weights, shift, axes=1)
        return turn.reshape(len(moved), 3, 72), shape

    def _add_priors(self, state: State, shape_count: int, normal: np.ndarray, gradient: np.ndarray) -> None:
        """Add the Gaussian priors of pose and shape and the hinges' one-sided limits to the normal equations."""
        angles = vectors_of(state.rotations)
        for j in range(1, 24):
            block = slice(3 * j, 3 * j + 3)
            precision = np.diag(1 / SPREADS[j] ** 2)
            value = precision @ angles[j]
            for name, axis, sign in HINGES:
                over = -sign * angles[j, axis] - HINGE_SLACK
                if JOINTS[j] == name and over > 0:
                    precision[axis, axis] += 1 / HINGE_SLACK**2
                    value[axis] -= sign * over / HINGE_SLACK**2
            slope = _left_jacobian_inverse(angles[j])
            normal[block, block] += slope.T @ precision @ slope
            gradient[block] += slope.T @ value
        tail = slice(75, 75 + shape_count)
        normal[tail, tail] += np.eye(shape_count)
        gradient[tail] += np.pad(state.shape, (0, max(shape_count - len(state.shape), 0)))[:shape_count]


def _advance(state: State, step: np.ndarray, shape_count: int) -> State:
    """Take a step, with turns clipped to half a radian so that a poor pairing cannot throw the limbs about."""
    turns = step[:72].reshape(24, 3)
    size = np.linalg.norm(turns, axis=1, keepdims=True)
    turns = turns * np.minimum(1.0, 0.5 / np.maximum(size, 1e-12))
    shape = np.pad(state.shape, (0, max(shape_count - len(state.shape), 0)))
    # Five standard deviations: no human of the model is beyond.
    shape = np.clip(shape + step[75:], -5.0, 5.0)
    return State(shape, rotations_of(turns) @ state.rotations, state.translation + step[72:75])


def vectors_of(rotations: np.ndarray) -> np.ndarray:
    """Give the axis-angle vectors [rad], shape [24, 3], of rotations [24, 3, 3]."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotations).as_rotvec()


def _left_jacobian_inverse(vector: np.ndarray) -> np.ndarray:
    """Give d log(exp(w) R) / dw at w = 0, shape [3, 3], for log R = vector."""
    angle = float(np.linalg.norm(vector))
    k = cross_matrices(vector)
    if angle < 1e-4:
        return np.eye(3) - 0.5 * k
    return np.eye(3) - 0.5 * k + (1 / angle**2) * (1 - 0.5 * angle / np.tan(0.5 * angle)) * (k @ k)


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Give area-weighted unit normals of the vertices, shape [n, 3]."""
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(total, faces[:, k], normal)
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300)
