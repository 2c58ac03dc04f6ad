"""Compute the derivatives of a posed template's points, weighted for the normal equations of a fit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..run.kernels import kernel

RIDGE_SHARE = 1e-6
"""Share of a point's weight that is added in all directions where planes count [1]: a single pair has rank 1, and its
Cholesky factor exists without visible effect."""

MIN_RIDGE = 1e-300
"""Weight that a point without a pair has in all directions [1]: its factor exists."""


class PointBones(NamedTuple):
    """Describe the bones that move each point.

    Attributes:
        bone: Their joints, padded by 0, int64, shape [m, bone_count].
        weight: Skinning weights, padded by 0, shape [m, bone_count].
        parent: Parent of each joint, -1 for the root, int64, shape [24].
    """

    bone: np.ndarray
    weight: np.ndarray
    parent: np.ndarray


class PosedSkeleton(NamedTuple):
    """Describe the joints of a state.

    Attributes:
        world: Their rotations, shape [24, 3, 3].
        shift: Translations that go with them [m], shape [24, 3].
        posed: Their positions [m], shape [24, 3].
        frame: Rotation of each one's parent, shape [24, 3, 3].
        shape_shift: Derivatives of `shift` by the shape coefficients [m], shape [24, 3, k].
    """

    world: np.ndarray
    shift: np.ndarray
    posed: np.ndarray
    frame: np.ndarray
    shape_shift: np.ndarray


class PairWeights(NamedTuple):
    """Describe the pairs of template points and surface points.

    Attributes:
        row: Template point of each pair, int64, shape [p].
        weight: Weight, shape [p].
        direction: Unit normal of the surface, shape [p, 3].
        offset: Template point less surface point [m], shape [p, 3].
        is_plane: Whether the distance to the plane counts; else that to the point.
    """

    row: np.ndarray
    weight: np.ndarray
    direction: np.ndarray
    offset: np.ndarray
    is_plane: bool


@kernel()
def scale_slopes(bones, skeleton, rest, shapes, pairs):  # type: ignore[no-untyped-def]
    """Compute S and g, with S S^T the sum of J_i^T M_i J_i and g that of J_i^T h_i over the template points i.

    J_i, shape [3, 75 + k], are the derivatives of point i by rotations in the parents' frames, by the translation and
    by the shape. A rotation w about joint j moves what hangs below it: dx = w x (A - C p_j), with A the sum of the
    point's weighted copies below j and C that of their weights. M_i is the sum of w n n^T over its pairs (without n n^T
    for distances to points), h_i that of w n n^T o. Row blocks of S are J_i^T L_i, L_i L_i^T = M_i.

    Args:
        bones: What moves the points.
        skeleton: The state's joints.
        rest: Points of the state's shape in the T-pose [m], shape [m, 3].
        shapes: Derivatives of the T-pose points by the shape coefficients, rotated as the points are, shape [m, 3, k].
        pairs: The pairs.

    Returns:
        S, shape [75 + k, 3 m], and g, shape [75 + k].
    """
    count, joint_count, shape_count = len(rest), len(bones.parent), shapes.shape[2]
    first_shape = 3 * joint_count + 3
    scaled = np.zeros((first_shape + shape_count, 3 * count))
    gradient = np.zeros(first_shape + shape_count)
    pull, inertia = _sum_pairs(pairs, count)
    arm, share, slope = np.zeros((joint_count, 3)), np.zeros(joint_count), np.zeros(3)
    moved = np.zeros(joint_count, np.int64)
    for i in range(count):
        root = _find_root(inertia[i], RIDGE_SHARE if pairs.is_plane else 0.0)
        moved_count = 0
        for k in range(bones.bone.shape[1]):
            weight = bones.weight[i, k]
            if weight == 0.0:
                continue
            b = bones.bone[i, k]
            x, y, z = rest[i, 0], rest[i, 1], rest[i, 2]
            copy_x = skeleton.world[b, 0, 0] * x + skeleton.world[b, 0, 1] * y + skeleton.world[b, 0, 2] * z
            copy_y = skeleton.world[b, 1, 0] * x + skeleton.world[b, 1, 1] * y + skeleton.world[b, 1, 2] * z
            copy_z = skeleton.world[b, 2, 0] * x + skeleton.world[b, 2, 1] * y + skeleton.world[b, 2, 2] * z
            j = b
            while j >= 0:
                if share[j] == 0.0:
                    moved[moved_count] = j
                    moved_count += 1
                share[j] += weight
                arm[j, 0] += weight * (copy_x + skeleton.shift[b, 0])
                arm[j, 1] += weight * (copy_y + skeleton.shift[b, 1])
                arm[j, 2] += weight * (copy_z + skeleton.shift[b, 2])
                j = bones.parent[j]
        for k in range(moved_count):
            j = moved[k]
            for a in range(3):
                arm[j, a] -= share[j] * skeleton.posed[j, a]
            for c in range(3):
                slope[0] = skeleton.frame[j, 1, c] * arm[j, 2] - skeleton.frame[j, 2, c] * arm[j, 1]
                slope[1] = skeleton.frame[j, 2, c] * arm[j, 0] - skeleton.frame[j, 0, c] * arm[j, 2]
                slope[2] = skeleton.frame[j, 0, c] * arm[j, 1] - skeleton.frame[j, 1, c] * arm[j, 0]
                _add_slope(scaled, gradient, 3 * j + c, i, slope, root, pull[i])
            share[j] = 0.0
            arm[j, :] = 0.0
        for c in range(3):
            slope[:] = 0.0
            slope[c] = 1.0
            _add_slope(scaled, gradient, 3 * joint_count + c, i, slope, root, pull[i])
        for s in range(shape_count):
            for a in range(3):
                slope[a] = shapes[i, a, s]
                for k in range(bones.bone.shape[1]):
                    slope[a] += bones.weight[i, k] * skeleton.shape_shift[bones.bone[i, k], a, s]
            _add_slope(scaled, gradient, first_shape + s, i, slope, root, pull[i])
    return scaled, gradient


@kernel()
def _sum_pairs(pairs, count):  # type: ignore[no-untyped-def]
    """Return h and M of each template point, shape [count, 3] and [count, 3, 3]."""
    pull, inertia = np.zeros((count, 3)), np.zeros((count, 3, 3))
    for p in range(len(pairs.row)):
        i, weight = pairs.row[p], pairs.weight[p]
        if pairs.is_plane:
            along = 0.0
            for a in range(3):
                along += pairs.direction[p, a] * pairs.offset[p, a]
            for a in range(3):
                pull[i, a] += weight * along * pairs.direction[p, a]
                for b in range(3):
                    inertia[i, a, b] += weight * pairs.direction[p, a] * pairs.direction[p, b]
        else:
            for a in range(3):
                pull[i, a] += weight * pairs.offset[p, a]
                inertia[i, a, a] += weight
    return pull, inertia


@kernel(inline="always")
def _find_root(inertia, share):  # type: ignore[no-untyped-def]
    """Return the Cholesky factor L of M and a share of the identity, row by row: 00, 10, 11, 20, 21, 22."""
    ridge = share * (inertia[0, 0] + inertia[1, 1] + inertia[2, 2]) + MIN_RIDGE
    a = np.sqrt(inertia[0, 0] + ridge)
    b = inertia[1, 0] / a
    c = np.sqrt(max(inertia[1, 1] + ridge - b * b, MIN_RIDGE))
    d = inertia[2, 0] / a
    e = (inertia[2, 1] - d * b) / c
    f = np.sqrt(max(inertia[2, 2] + ridge - d * d - e * e, MIN_RIDGE))
    return a, b, c, d, e, f


@kernel(inline="always")
def _add_slope(scaled, gradient, column, point, slope, root, pull):  # type: ignore[no-untyped-def]
    """Write L^T times a derivative of a point into its place, and add its share of the gradient."""
    a, b, c, d, e, f = root
    scaled[column, 3 * point] = a * slope[0] + b * slope[1] + d * slope[2]
    scaled[column, 3 * point + 1] = c * slope[1] + e * slope[2]
    scaled[column, 3 * point + 2] = f * slope[2]
    gradient[column] += slope[0] * pull[0] + slope[1] * pull[1] + slope[2] * pull[2]
