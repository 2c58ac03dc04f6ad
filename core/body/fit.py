"""Fit the articulated template to points of a surface by Gauss-Newton, with new correspondences in each step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial import cKDTree

from ..geometry.geometry import vertex_normals
from .body import JOINT_PARENTS, JOINTS
from .template import Template, articulate, cross_matrices, rotations_of

_DESCENDANT_MASK = np.zeros((24, 24))
"""Mask of descendants, shape [24, 24]: row j marks joint j and all joints below it."""
for _k in range(24):
    _j = _k
    while _j >= 0:
        _DESCENDANT_MASK[_j, _k] = 1.0
        _j = JOINT_PARENTS[_j]


def _pose_prior_stds() -> np.ndarray:
    """Return the standard deviations [rad] of each joint's axis-angle in everyday poses, shape [24, 3]. Assumed from
    the ranges of human joints: hinges wide about their axis only, ball joints wide, spine and feet narrow."""
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


POSE_PRIOR_STDS = _pose_prior_stds()
HINGES = (("left_knee", 0, 1.0), ("right_knee", 0, 1.0), ("left_elbow", 1, -1.0), ("right_elbow", 1, 1.0))
"""Joint, axis and sign of its only direction of bending: the shank bends back, the forearm forward."""
HINGE_SLACK = 0.1
"""Overextension [rad] of a hinge that is not penalised, and standard deviation of the excess."""


def find_forearms(weights: np.ndarray) -> np.ndarray:
    """Label the vertices of forearms and hands by skinning weights, shape [n, 24]: 1 left, 2 right, else 0."""
    limb = np.zeros(len(weights), dtype=np.int64)
    for number, side in enumerate(("left", "right"), 1):
        columns = [JOINTS.index(f"{side}_{name}") for name in ("elbow", "wrist", "hand")]
        limb[weights[:, columns].sum(axis=1) > 0.5] = number
    return limb


@dataclass(frozen=True)
class OrientedPoints:
    """Describe points of a surface with outward unit normals.

    Attributes:
        points: Positions [m], shape [n, 3].
        normals: Unit normals, shape [n, 3].
        cloth: Probability that the point is on cloth, which hides the body, 0 to 1 or bool, shape [n]; None: 0.
        weight: Weight of the point, shape [n]; None: 1.
        spread: Standard deviation of the body's surface about the point [m], shape [n]; None: 0.
        oriented: Whether the normals are known to point outward; else their signs are ignored.
        limb: Forearm of the point, as `find_forearms`, shape [n], or None if unknown. A forearm is not paired with
            cloth elsewhere: it sticks out beside a coat, and was pulled in by 30 cm.
    """

    points: np.ndarray
    normals: np.ndarray
    cloth: np.ndarray | None = None
    weight: np.ndarray | None = None
    spread: np.ndarray | None = None
    oriented: bool = True
    limb: np.ndarray | None = None

    def take(self, index: np.ndarray | slice) -> OrientedPoints:
        """Return some of the points."""
        known = {
            name: getattr(self, name)[index]
            for name in ("points", "normals", "cloth", "weight", "spread", "limb")
            if getattr(self, name) is not None
        }
        return OrientedPoints(**known, oriented=self.oriented)

    def stack(self, length: float) -> np.ndarray:
        """Return positions and normals times a length [m], shape [n, 6]; if not oriented, with both signs, [2 n, 6]."""
        stacked = np.hstack([self.points, length * self.normals])
        if self.oriented:
            return stacked
        return np.vstack([stacked, np.hstack([self.points, -length * self.normals])])


@dataclass(frozen=True)
class FitState:
    """Describe a fit: shape [k], local rotations [24, 3, 3], translation [m], shape [3]."""

    shape: np.ndarray
    rotations: np.ndarray
    translation: np.ndarray


@dataclass(frozen=True)
class FitStage:
    """Describe the settings of one stage of the fit.

    Attributes:
        steps: Largest number of Gauss-Newton steps.
        scale: Distance [m] beyond which pairs are down-weighted; also the noise against which priors count.
        normal_length: Length [m] per unit of difference in normals in the search for pairs.
        plane: Measure pairs along the normal; else in all three axes, which converges from further away.
        shape_count: Number of free shape coefficients.
        cloth_pull: Weight of a pair with cloth outside the body; skin has 1.
        cloth_gap: Ratio of the scale of such a pair to that of one with skin.
        cloth_reach: Multiple of `scale` up to which a point of the body outside the cloth is not down-weighted: unlike
            a gap between cloth and body, it cannot be right.
        observations: Number of observations that a whole surface counts for against the priors: 1 cm everywhere
            outweighs a few standard deviations of shape. With 300, mannequins with long arms fit badly (16 mm RMS, not
            8); 5000 gained 1 mm.
        least_motion: Share of `scale` that a step must move the points by (RMS) for the stage to continue. Smaller
            moves are a fraction of what the next stage, with a smaller scale, corrects; in the last it is 0.2 mm.
    """

    steps: int
    scale: float
    normal_length: float
    plane: bool
    shape_count: int
    cloth_pull: float = 0.3
    cloth_gap: float = 1.0
    cloth_reach: float = 3.0
    observations: float = 3000.0
    least_motion: float = 0.02


@dataclass(frozen=True)
class _PosedPoints:
    """Describe the template's points in a state.

    Attributes:
        points: Positions [m], shape [m, 3].
        normals: Unit normals, shape [m, 3].
        rest: Points of this shape in the T-pose [m], shape [3, m].
        blend: Sum of the joints' rotations by skinning weight, shape [3, 3, m].
        world: Rotations of the joints, shape [24, 3, 3].
        posed: Joints [m], shape [24, 3].
        shift: Translations that go with `world` [m], shape [24, 3].
    """

    points: np.ndarray
    normals: np.ndarray
    rest: np.ndarray
    blend: np.ndarray
    world: np.ndarray
    posed: np.ndarray
    shift: np.ndarray


class Fitter:
    """Fit a template, reduced to a subset of its vertices, to a surface."""

    def __init__(self, template: Template, subset: np.ndarray, surface: OrientedPoints) -> None:
        """Take the template, indices of the vertices used, and the surface's points."""
        self.template = template
        # The last axis is that of the points, here and in all arrays per point, so that numpy's inner loops are long.
        self.vertices = np.ascontiguousarray(template.vertices[subset].T)
        self.directions = np.ascontiguousarray(template.directions[:, subset].transpose(2, 0, 1))
        self.weights = np.ascontiguousarray(template.weights[subset].T)
        self.limb = find_forearms(template.weights[subset])
        self.normals = np.ascontiguousarray(vertex_normals(template.vertices, template.faces)[subset].T)
        self.surface = surface

    def fit(self, state: FitState, stage: FitStage) -> FitState:
        """Improve a state by one stage."""
        s = self.surface
        tree = cKDTree(s.stack(stage.normal_length))
        last = None
        for _ in range(stage.steps):
            placed = self._place(state)
            moved = np.inf if last is None else np.sqrt(((placed.points - last) ** 2).sum(axis=1).mean())
            if moved < stage.least_motion * stage.scale:
                break
            last = placed.points
            state = self._step(state, stage, tree, placed)
        return state

    def residual(self, state: FitState, scale: float, normal_length: float) -> float:
        """Compute the robust two-way misfit of a state: mean of min(d, scale) over pairs, d [m] including normals."""
        placed = self._place(state)
        placed_stack = np.hstack([placed.points, normal_length * placed.normals])
        target_stack = self.surface.stack(normal_length)
        there, _ = cKDTree(target_stack).query(placed_stack, distance_upper_bound=scale)
        back, _ = cKDTree(placed_stack).query(target_stack, distance_upper_bound=scale)
        if not self.surface.oriented:
            back = back.reshape(2, -1).min(axis=0)
        return float(np.minimum(there, scale).mean() + np.minimum(back, scale).mean()) / 2

    def _place(self, state: FitState) -> _PosedPoints:
        k = len(state.shape)
        rest = self.vertices + np.tensordot(state.shape, self.directions[:, :k], axes=(0, 1))
        joints = self.template.joints + np.tensordot(state.shape, self.template.joint_directions[:k], axes=1)
        world, posed = articulate(state.rotations, joints, state.translation)
        shift = posed - np.einsum("jab,jb->ja", world, joints)
        blend = (world.reshape(24, 9).T @ self.weights).reshape(3, 3, -1)
        points = (blend * rest).sum(axis=1) + shift.T @ self.weights
        normals = (blend * self.normals).sum(axis=1)
        normals /= np.sqrt((normals**2).sum(axis=0))
        return _PosedPoints(points.T, normals.T, rest, blend, world, posed, shift)

    def _step(self, state: FitState, stage: FitStage, tree: cKDTree, placed: _PosedPoints) -> FitState:
        """Take one Gauss-Newton step. With J_i the derivative of template point i, its pairs add J_i^T M_i J_i to the
        normal equations and J_i^T h_i to the gradient, M_i = sum of w n n^T (without n n^T: all axes), h_i = M_i
        offset."""
        points, count = placed.points, len(placed.points)
        row, chosen = self._pairs(points, placed.normals, stage, tree)
        direction = self.surface.normals[chosen]
        offset = points[row] - self.surface.points[chosen]
        weight = self._trust(offset, direction, (row, chosen), stage) * (stage.observations / len(row) / stage.scale**2)
        slopes = np.concatenate(
            [
                self._turn_slopes(placed),
                np.broadcast_to(np.eye(3)[:, :, None], (3, 3, count)),
                self._shape_slopes(stage.shape_count, placed),
            ],
            axis=1,
        )
        if stage.plane:
            pull = (weight * np.einsum("ra,ra->r", direction, offset))[:, None] * direction
            scaled = self._scale_rows(slopes, row, weight, direction)
        else:
            pull = weight[:, None] * offset
            scaled = np.sqrt(np.bincount(row, weight, count)) * slopes
        gradient = sum(slopes[a] @ np.bincount(row, pull[:, a], count) for a in range(3))
        normal = sum(part @ part.T for part in scaled)
        self._add_priors(state, stage.shape_count, normal, gradient)
        step = cho_solve(cho_factor(normal + 1e-9 * np.trace(normal) / len(normal) * np.eye(len(normal))), -gradient)
        return _apply_step(state, step, stage.shape_count)

    def _scale_rows(self, slopes: np.ndarray, row: np.ndarray, weight: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Return L_i^T J_i, where L_i L_i^T is the sum of w n n^T over the pairs of point i; shape as `slopes`."""
        count = slopes.shape[2]
        sums = np.zeros((count, 3, 3))
        for a in range(3):
            for b in range(a + 1):
                sums[:, a, b] = sums[:, b, a] = np.bincount(row, weight * direction[:, a] * direction[:, b], count)
        # A single pair has rank 1; a millionth of the weight makes the Cholesky factor exist without visible effect.
        ease = 1e-6 * np.trace(sums, axis1=1, axis2=2) + 1e-300
        lower = np.ascontiguousarray(np.linalg.cholesky(sums + ease[:, None, None] * np.eye(3)).transpose(1, 2, 0))
        scaled = np.zeros_like(slopes)
        for a in range(3):
            for b in range(a + 1):
                scaled[b] += lower[a, b] * slopes[a]
        return scaled

    def _pairs(
        self, points: np.ndarray, normals: np.ndarray, stage: FitStage, tree: cKDTree
    ) -> tuple[np.ndarray, np.ndarray]:
        """Pair each template point with the surface and each surface point with the template; return the rows."""
        s, length = self.surface, stage.normal_length
        oriented = np.hstack([points, length * normals])
        _, there = tree.query(oriented)
        distance, back = cKDTree(oriented).query(s.stack(length))
        if not s.oriented:
            there = there % len(s.points)
            back = np.where(distance[: len(s.points)] <= distance[len(s.points) :], *back.reshape(2, -1))
        return np.concatenate([np.arange(len(points)), back]), np.concatenate([there, np.arange(len(s.points))])

    def _trust(
        self, offset: np.ndarray, direction: np.ndarray, pairs: tuple[np.ndarray, np.ndarray], stage: FitStage
    ) -> np.ndarray:
        """Compute the weight of each pair from its offset [m], shape [n, 3]; it vanishes far beyond the scale.
        Geman-McClure, (s^2 / (s^2 + |offset|^2))^2. A body may be well below the cloth that hides it: a pair with cloth
        has full weight where the body is outside the cloth, and little where it is inside."""
        s, (row, chosen) = self.surface, pairs
        length2, scale2 = (offset**2).sum(axis=1), np.full(len(offset), stage.scale**2)
        weight = np.ones(len(offset)) if s.weight is None else s.weight[chosen]
        if s.spread is not None:
            spread2 = s.spread[chosen] ** 2
            weight = weight * scale2 / (scale2 + spread2)
            scale2 += spread2
        if s.cloth is not None:
            cloth = s.cloth[chosen].astype(np.float64)
            outside = np.einsum("ra,ra->r", offset, direction) > 0
            reach2 = np.where(outside, stage.cloth_reach**2, stage.cloth_gap**2)
            scale2 *= (1.0 - cloth) + cloth * reach2
            weight = weight * np.where(outside, 1.0, (1.0 - cloth) + cloth * stage.cloth_pull)
            if s.limb is not None:
                weight = weight * (1.0 - cloth * ((self.limb[row] > 0) & (s.limb[chosen] != self.limb[row])))
        return np.asarray(weight * (scale2 / (scale2 + length2)) ** 2)

    def _turn_slopes(self, placed: _PosedPoints) -> np.ndarray:
        """Return the derivatives of the points by rotations in the parents' frames, shape [3, 72, m]. A small rotation
        w about joint j moves the part of a point that hangs below it: dx = w x (S - C p_j), with S the sum of its
        weighted copies below j and C the sum of those weights."""
        world, posed = placed.world, placed.posed
        copies = (world.reshape(72, 3) @ placed.rest + placed.shift.reshape(72, 1)).reshape(24, 3, -1)
        copies *= self.weights[:, None]
        arms = (_DESCENDANT_MASK @ copies.reshape(24, -1)).reshape(copies.shape)
        arms -= (_DESCENDANT_MASK @ self.weights)[:, None] * posed[:, :, None]
        frames = np.stack([np.eye(3) if p < 0 else world[p] for p in JOINT_PARENTS])[:, :, :, None]
        slopes = np.zeros((3, 24, 3, self.weights.shape[1]))
        for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            np.multiply(frames[:, b], arms[:, None, c], out=slopes[a])
            slopes[a] -= frames[:, c] * arms[:, None, b]
        return slopes.reshape(3, 72, -1)

    def _shape_slopes(self, count: int, placed: _PosedPoints) -> np.ndarray:
        """Return the derivatives of the points by the first shape coefficients, shape [3, count, m]."""
        world = placed.world
        joint_slopes = self.template.joint_directions[:count].transpose(1, 2, 0)
        posed_slopes = np.zeros_like(joint_slopes)
        for j, p in enumerate(JOINT_PARENTS):
            posed_slopes[j] = (
                joint_slopes[j] if p < 0 else posed_slopes[p] + world[p] @ (joint_slopes[j] - joint_slopes[p])
            )
        shift = posed_slopes - world @ joint_slopes
        slopes: np.ndarray = (shift.reshape(24, -1).T @ self.weights).reshape(3, count, -1)
        for a in range(3):
            for b in range(3):
                slopes[a] += placed.blend[a, b] * self.directions[b, :count]
        return slopes

    def _add_priors(self, state: FitState, shape_count: int, normal: np.ndarray, gradient: np.ndarray) -> None:
        """Add the Gaussian priors of pose and shape and the hinges' one-sided limits to the normal equations."""
        angles = axis_angles_of(state.rotations)
        precision = 1.0 / POSE_PRIOR_STDS**2  # none for the root, whose spread is infinite
        value = precision * angles
        for name, axis, sign in HINGES:
            j = JOINTS.index(name)
            over = -sign * angles[j, axis] - HINGE_SLACK
            if over > 0:
                precision[j, axis] += 1 / HINGE_SLACK**2
                value[j, axis] -= sign * over / HINGE_SLACK**2
        slope = _left_jacobian_inverse(angles)
        place = np.arange(72).reshape(24, 3)
        normal[place[:, :, None], place[:, None, :]] += np.einsum("jab,ja,jac->jbc", slope, precision, slope)
        gradient[:72] += np.einsum("jab,ja->jb", slope, value).ravel()
        tail = np.arange(75, 75 + shape_count)
        normal[tail, tail] += 1.0
        gradient[tail] += np.pad(state.shape, (0, max(shape_count - len(state.shape), 0)))[:shape_count]


def _apply_step(state: FitState, step: np.ndarray, shape_count: int) -> FitState:
    """Apply a step, with rotations clipped to half a radian, which bounds the effect of wrong pairs."""
    turns = step[:72].reshape(24, 3)
    size = np.linalg.norm(turns, axis=1, keepdims=True)
    turns = turns * np.minimum(1.0, 0.5 / np.maximum(size, 1e-12))
    shape = np.pad(state.shape, (0, max(shape_count - len(state.shape), 0)))
    # No human of the model is beyond five standard deviations.
    shape = np.clip(shape + step[75:], -5.0, 5.0)
    return FitState(shape, rotations_of(turns) @ state.rotations, state.translation + step[72:75])


def axis_angles_of(rotations: np.ndarray) -> np.ndarray:
    """Return the axis-angle vectors [rad], shape [24, 3], of rotations [24, 3, 3]."""
    from scipy.spatial.transform import Rotation

    found: np.ndarray = Rotation.from_matrix(rotations).as_rotvec()
    return found


def _left_jacobian_inverse(vectors: np.ndarray) -> np.ndarray:
    """Return d log(exp(w) R) / dw at w = 0, shape [n, 3, 3], for log R = vectors, shape [n, 3]."""
    angle = np.maximum(np.linalg.norm(vectors, axis=1), 1e-4)  # below it the quadratic term is lost in rounding
    k = cross_matrices(vectors)
    factor = (1 - 0.5 * angle / np.tan(0.5 * angle)) / angle**2
    return np.asarray(np.eye(3) - 0.5 * k + factor[:, None, None] * (k @ k))
