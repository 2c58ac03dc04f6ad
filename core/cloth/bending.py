"""Bending energy of the dihedral angle, whose gradient is thesis eq. 3.4."""

from __future__ import annotations

import math

import numpy as np

from ..geometry.vectors import cross, dot, subtract
from ..run.kernels import kernel
from .block_pattern import add_block


@kernel()
def bending(x, elements, k, folds, order, exact, derivatives):  # type: ignore[no-untyped-def]
    """Add the hinges' gradient (order >= 1) and Hessian blocks (order 2) and return their energy [J].

    E_h = 2 k c (1 - cos((theta - theta0) / 2)),  c = |e|^2 / (A1 + A2),  dE/dtheta = k c sin((theta - theta0) / 2).

    Notation: `elements` a `HingeElements`: nodes (0, 1, 2, 3), the edge from 0 to 1; scale c; angles theta0; `k` [N m];
    theta the angle between both normals, pi - alpha of eq. 3.4; grad theta the u_i of eq. 3.4 (Bridson et al. 2003). A
    cylinder of curvature kappa on a regular mesh has the energy k kappa^2 / 4 per area: the flexural rigidity is k / 2.
    If all diagonals have one direction, bending couples with twist, and a narrow strip has 0.8 of this rigidity.
    Moments above zero in `folds` add the friction energy of `BendingFriction`, which is convex in theta.

    **Deviation**: eq. 3.4 is a force. Here it is the gradient of the energy above, as it is for theta0 = 0 and rest
    lengths and areas in c, so that the Hessian is exact and symmetric. The PSD form keeps |d2E| grad grad^T.
    """
    hinges, scale, rest, slots = elements
    angles, moments, slip = folds
    gradient, blocks = derivatives
    energy = 0.0
    slope = np.zeros((4, 3))
    curve = np.zeros((10, 3, 3))
    for h in range(hinges.shape[0]):
        i0, i1, i2, i3 = hinges[h, 0], hinges[h, 1], hinges[h, 2], hinges[h, 3]
        e, p, q = subtract(x[i1], x[i0]), subtract(x[i2], x[i0]), subtract(x[i3], x[i0])
        n1, n2 = cross(e, p), cross(q, e)
        squared, m1, m2 = dot(e, e), dot(n1, n1), dot(n2, n2)
        # a degenerate face (height under 1e-4 of its edge) has no defined normal
        if m1 < 1e-8 * squared * squared or m2 < 1e-8 * squared * squared or squared == 0.0:
            continue
        length = math.sqrt(squared)
        # (n1 x n2) . e / |e| = |e| (n1 . q) up to sign: n1 x n2 is parallel to e
        sine, cosine = -length * dot(n1, q), dot(n1, n2)
        half_sine, half_cosine = halve(sine, cosine, math.sqrt(m1 * m2))
        if rest[h] != 0.0:
            cr, sr = math.cos(0.5 * rest[h]), math.sin(0.5 * rest[h])
            half_sine, half_cosine = half_sine * cr - half_cosine * sr, half_cosine * cr + half_sine * sr
        stiffness = k * scale[h]
        # 1 - cos, without cancellation at small angles
        if half_cosine > 0.0:
            energy += 2.0 * stiffness * half_sine * half_sine / (1.0 + half_cosine)
        else:
            energy += 2.0 * stiffness * (1.0 - half_cosine)
        excess, reach = 0.0, slip
        if moments[h] > 0.0:
            excess = math.atan2(sine, cosine) - angles[h]
            if abs(excess) > math.pi:
                excess -= math.copysign(2.0 * math.pi, excess)
            reach = math.sqrt(excess * excess + slip * slip)
            energy += moments[h] * (reach - slip)
        if order == 0:
            continue
        first, second = stiffness * half_sine, 0.5 * stiffness * half_cosine
        if not exact:
            second = abs(second)
        if moments[h] > 0.0:
            first += moments[h] * excess / reach
            second += moments[h] * slip * slip / reach**3
        t1, t2 = dot(p, e) / squared, dot(q, e) / squared
        u2, u3 = -length / m1, -length / m2
        for d in range(3):
            s2, s3 = u2 * n1[d], u3 * n2[d]
            s0, s1 = (t1 - 1.0) * s2 + (t2 - 1.0) * s3, -t1 * s2 - t2 * s3
            gradient[i0, d] += first * s0
            gradient[i1, d] += first * s1
            gradient[i2, d] += first * s2
            gradient[i3, d] += first * s3
            slope[0, d], slope[1, d], slope[2, d], slope[3, d] = s0, s1, s2, s3
        if order == 1:
            continue
        n = 0
        for a in range(4):
            for b in range(a, 4):
                for d in range(3):
                    for f in range(3):
                        curve[n, d, f] = second * slope[a, d] * slope[b, f]
                n += 1
        if exact:
            edge = (e, squared, length)
            _add_triangle_hessian(edge, (p, n1, 1.0, m1, t1), slope[2], first, (2, 5, 7), curve)
            _add_triangle_hessian(edge, (q, n2, -1.0, m2, t2), slope[3], first, (3, 6, 9), curve)
        for n in range(10):
            add_block(blocks, slots[h, n], curve[n])
    return energy


@kernel()
def _add_triangle_hessian(edge, triangle, apex, first, slots, curve):  # type: ignore[no-untyped-def]
    """Add `first` times one triangle's share of the Hessian of theta. The apex gradient G = -|e| n / m, n = sign e x p,
    m = n.n, depends on this triangle alone; the edge's ends have -t G and -(1 - t) G with t = p.e / |e|^2. `edge`: e,
    |e|^2, |e|; `triangle`: p, n, its sign, m, t; `slots`: of the blocks (0, apex), (1, apex), (apex, apex)."""
    e, squared, length = edge
    p, n, sign, m, t = triangle
    to0, to1, slot = slots
    for d in range(3):
        for f in range(3):
            # entry (d, f) of the cross-product matrices [e]x and [p]x, and of n x e and n x p
            g, s = 3 - d - f, 0.0
            if d != f:
                s = 1.0 if (f - d) % 3 == 2 else -1.0
                ex, px = s * e[g], s * p[g]
            else:
                ex, px = 0.0, 0.0
            f1, f2 = (f + 1) % 3, (f + 2) % 3
            nxe = n[f1] * e[f2] - n[f2] * e[f1]
            nxp = n[f1] * p[f2] - n[f2] * p[f1]
            by_p = -length * sign * (ex - 2.0 * n[d] * nxe / m) / m
            by_e = -n[d] * e[f] / (length * m) + length * sign * (px - 2.0 * n[d] * nxp / m) / m
            t_p = e[f] / squared
            t_e = (p[f] - 2.0 * t * e[f]) / squared
            curve[slot, d, f] += first * by_p
            curve[to1, f, d] += first * by_e
            curve[to0, f, d] -= first * (by_p + by_e)
            curve[4, d, f] += first * (-t * by_e - apex[d] * t_e)
            curve[1, d, f] += first * (-(1.0 - t) * by_e + apex[d] * t_e)
            curve[0, d, f] += first * ((1.0 - t) * (by_p + by_e) - apex[d] * (t_p + t_e))


@kernel(inline="always")
def halve(sine, cosine, length):  # type: ignore[no-untyped-def]
    """Return sine and cosine of half an angle in -pi .. pi from its own times a length; accurate for small angles."""
    sine, cosine = sine / length, cosine / length
    if cosine >= 0.0:
        half_cosine = math.sqrt(0.5 + 0.5 * cosine)
        return 0.5 * sine / half_cosine, half_cosine
    half_sine = math.copysign(math.sqrt(0.5 - 0.5 * cosine), sine)
    return half_sine, 0.5 * sine / half_sine
