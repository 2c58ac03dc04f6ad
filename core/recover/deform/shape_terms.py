"""The terms of the deformation that keep a garment's own shape and its distance to the body, each with its gradient."""

from __future__ import annotations

import math

import numpy as np

from ...geometry.vectors import cross, dot, subtract
from ...run.kernels import kernel

MIN_HEIGHT_RATIO_SQUARED = 1e-8
"""Ratio of a face's height to its hinge, squared, below which its normal is not defined and the hinge has no angle."""


@kernel(error_model="numpy")
def fold_energy(x, hinges, stiffness, gradient):  # type: ignore[no-untyped-def]
    """Return sum_h k / 2 alpha_h^2 (thesis eq. 4.4) and add its gradient by x, k alpha grad alpha.

    Notation: `hinges` nodes 0 to 3 of each, the edge e from 0 to 1 and the opposite corners, shape [hinge_count, 4];
    `stiffness` k; n1 = e x p and n2 = q x e the normals of both faces, p = x_2 - x_0, q = x_3 - x_0; alpha the angle
    between them about e. grad alpha is -|e| n1 / |n1|^2 at 2, -|e| n2 / |n2|^2 at 3, and at 0 and 1 minus the share of
    these that the foot of each corner has on e (Bridson et al. 2003).
    """
    energy = 0.0
    for h in range(len(hinges)):
        i0, i1, i2, i3 = hinges[h, 0], hinges[h, 1], hinges[h, 2], hinges[h, 3]
        e, p, q = subtract(x[i1], x[i0]), subtract(x[i2], x[i0]), subtract(x[i3], x[i0])
        n1, n2 = cross(e, p), cross(q, e)
        squared, m1, m2 = dot(e, e), dot(n1, n1), dot(n2, n2)
        if min(m1, m2) <= MIN_HEIGHT_RATIO_SQUARED * squared * squared:
            continue
        length = math.sqrt(squared)
        angle = math.atan2(-length * dot(n1, q), dot(n1, n2))
        energy += 0.5 * stiffness * angle * angle
        t1, t2 = dot(p, e) / squared, dot(q, e) / squared
        u1, u2 = -stiffness * angle * length / m1, -stiffness * angle * length / m2
        for d in range(3):
            at_2, at_3 = u1 * n1[d], u2 * n2[d]
            gradient[i0, d] += (t1 - 1.0) * at_2 + (t2 - 1.0) * at_3
            gradient[i1, d] -= t1 * at_2 + t2 * at_3
            gradient[i2, d] += at_2
            gradient[i3, d] += at_3
    return energy


@kernel(error_model="numpy")
def strain_energy(x, faces, rest, lame, scale, gradient):  # type: ignore[no-untyped-def]
    """Return q sum_f A (lambda / 2 tr(E)^2 + mu tr(E^2)) (thesis eq. 4.5) and add its gradient by x.

    F = [x_1 - x_0, x_2 - x_0] D,  E = (F^T F - I) / 2,  dE/dF = A F (lambda tr(E) I + 2 mu E),  D = B S^-1.

    Notation: `rest` B of the flat triangle and S^-1 of the rest stretch, shapes [face_count, 2, 2], and areas A [m2],
    shape [face_count]; `lame` lambda and mu [N/m]; `scale` q, the term's weight [m2/J].
    """
    inverse, undo, areas = rest
    total, first, second = 0.0, np.zeros(3), np.zeros(3)
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        a, b = subtract(x[j], x[i]), subtract(x[k], x[i])
        d00 = inverse[f, 0, 0] * undo[f, 0, 0] + inverse[f, 0, 1] * undo[f, 1, 0]
        d01 = inverse[f, 0, 0] * undo[f, 0, 1] + inverse[f, 0, 1] * undo[f, 1, 1]
        d10 = inverse[f, 1, 0] * undo[f, 0, 0] + inverse[f, 1, 1] * undo[f, 1, 0]
        d11 = inverse[f, 1, 0] * undo[f, 0, 1] + inverse[f, 1, 1] * undo[f, 1, 1]
        for d in range(3):
            first[d], second[d] = a[d] * d00 + b[d] * d10, a[d] * d01 + b[d] * d11
        e00, e01, e11 = 0.5 * (dot(first, first) - 1.0), 0.5 * dot(first, second), 0.5 * (dot(second, second) - 1.0)
        trace, twice = lame[0] * (e00 + e11), 2.0 * lame[1]
        weight = scale * areas[f]
        total += 0.5 * weight * (trace * (e00 + e11) + twice * (e00 * e00 + 2.0 * e01 * e01 + e11 * e11))
        s00, s01, s11 = weight * (trace + twice * e00), weight * twice * e01, weight * (trace + twice * e11)
        for d in range(3):
            by_first, by_second = first[d] * s00 + second[d] * s01, first[d] * s01 + second[d] * s11
            at_j, at_k = by_first * d00 + by_second * d01, by_first * d10 + by_second * d11
            gradient[j, d] += at_j
            gradient[k, d] += at_k
            gradient[i, d] -= at_j + at_k
    return total


@kernel(error_model="numpy")
def body_depth(x, planes, margin, scale, gradient):  # type: ignore[no-untyped-def]
    """Return q sum_r w_r max(m + h_r - x_i(r) . o_r, 0)^3 (thesis eq. 4.6) and add its gradient by x.

    Notation: `planes` nodes i, directions o out of the body, heights h [m] of its tangent planes along them, weights w;
    `margin` m [m]; `scale` q, the term's weight.
    """
    nodes, out, heights, weights = planes
    total = 0.0
    for r in range(len(nodes)):
        missing = margin + heights[r] - dot(x[nodes[r]], out[r])
        if missing > 0.0:
            total += weights[r] * missing**3
            for d in range(3):
                gradient[nodes[r], d] -= 3.0 * scale * weights[r] * missing * missing * out[r, d]
    return scale * total
