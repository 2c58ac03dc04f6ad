"""In-plane stretch and shear: orthotropic Green strain (thesis eq. 3.3)."""

from __future__ import annotations

import math

import numpy as np

from ..run.kernels import kernel
from .block_pattern import add_block


@kernel()
def membrane(x, elements, H, stress, order, exact, derivatives):  # type: ignore[no-untyped-def]
    """Add the membrane's gradient (order >= 1) and Hessian blocks (order 2) and return its energy [J].

    E_f = A/2 eps^T H eps,  eps = (e00, e11, e01),  e = (F^T F - I) / 2,  F = [f_u f_v] = sum_a x_a (dN_a/du, dN_a/dv).

    Notation: `x` [node_count, 3] positions [m]; `elements` a `FaceElements`, its shape dN/d(u, v) [1/m], its areas A
    [m2]; `H` = (H00, H01, H11, H22) [N/m], with sigma = H eps and e01 the tensor shear, so that sigma2 = H22 e01 is
    conjugate to e01. Source: eq. 3.3.
    The PSD form (`exact` False) keeps the material part and the positive part of the 2x2 stress in the geometric part.
    `stress` [face_count, 3], where it is not empty, takes sigma's place in the geometric part (`predict_stress`).
    """
    faces, shape, areas, slots = elements
    gradient, blocks = derivatives
    energy = 0.0
    gram = _make_scratch()
    fu, fv, block = gram[0], gram[1], gram[2:5]
    for f in range(faces.shape[0]):
        for d in range(3):
            fu[d] = 0.0
            fv[d] = 0.0
            for a in range(3):
                fu[d] += x[faces[f, a], d] * shape[f, a, 0]
                fv[d] += x[faces[f, a], d] * shape[f, a, 1]
        e0 = 0.5 * (fu[0] * fu[0] + fu[1] * fu[1] + fu[2] * fu[2] - 1.0)
        e1 = 0.5 * (fv[0] * fv[0] + fv[1] * fv[1] + fv[2] * fv[2] - 1.0)
        e2 = 0.5 * (fu[0] * fv[0] + fu[1] * fv[1] + fu[2] * fv[2])
        area = areas[f]
        s0 = H[0] * e0 + H[1] * e1
        s1 = H[1] * e0 + H[2] * e1
        s2 = H[3] * e2
        energy += 0.5 * area * (s0 * e0 + s1 * e1 + s2 * e2)
        if order == 0:
            continue
        for a in range(3):
            cu = area * (s0 * shape[f, a, 0] + 0.5 * s2 * shape[f, a, 1])
            cv = area * (s1 * shape[f, a, 1] + 0.5 * s2 * shape[f, a, 0])
            for d in range(3):
                gradient[faces[f, a], d] += cu * fu[d] + cv * fv[d]
        if order == 1:
            continue
        t0, t1, t2 = s0, s1, 0.5 * s2
        if len(stress) > 0:
            t0, t1, t2 = stress[f, 0], stress[f, 1], 0.5 * stress[f, 2]
        if not exact:
            t0, t1, t2 = positive_part(t0, t1, t2)
        n = 0
        for a in range(3):
            au, av = shape[f, a, 0], shape[f, a, 1]
            for b in range(a, 3):
                bu, bv = shape[f, b, 0], shape[f, b, 1]
                quarter = 0.25 * H[3]
                kuu = area * (H[0] * au * bu + quarter * av * bv)
                kvv = area * (H[2] * av * bv + quarter * au * bu)
                kuv = area * (H[1] * au * bv + quarter * av * bu)
                kvu = area * (H[1] * av * bu + quarter * au * bv)
                geometric = area * (au * (t0 * bu + t2 * bv) + av * (t2 * bu + t1 * bv))
                for d in range(3):
                    wu = kuu * fu[d] + kvu * fv[d]
                    wv = kuv * fu[d] + kvv * fv[d]
                    for e in range(3):
                        block[d, e] = wu * fu[e] + wv * fv[e]
                    block[d, d] += geometric
                add_block(blocks, slots[f, n], block)
                n += 1
    return energy


@kernel()
def predict_stress(x, step, faces, shape, H):  # type: ignore[no-untyped-def]
    """Return the stress (sigma0, sigma1, sigma2) [N/m] of each face after a step if strain were linear in it. sigma = H
    (eps(x) + D eps(x)[step]): without the term quadratic in the step, the stretch of a straight step along a fold."""
    found = np.zeros((faces.shape[0], 3))
    rows = np.zeros((4, 3))
    fu, fv, du, dv = rows[0], rows[1], rows[2], rows[3]
    for f in range(faces.shape[0]):
        rows[:] = 0.0
        for a in range(3):
            node, au, av = faces[f, a], shape[f, a, 0], shape[f, a, 1]
            for d in range(3):
                fu[d] += x[node, d] * au
                fv[d] += x[node, d] * av
                du[d] += step[node, d] * au
                dv[d] += step[node, d] * av
        e0, e1, e2 = -0.5, -0.5, 0.0
        for d in range(3):
            e0 += fu[d] * (0.5 * fu[d] + du[d])
            e1 += fv[d] * (0.5 * fv[d] + dv[d])
            e2 += 0.5 * (fu[d] * fv[d] + fu[d] * dv[d] + fv[d] * du[d])
        found[f, 0] = H[0] * e0 + H[1] * e1
        found[f, 1] = H[1] * e0 + H[2] * e1
        found[f, 2] = H[3] * e2
    return found


@kernel()
def _make_scratch():  # type: ignore[no-untyped-def]
    """Return the kernel's scratch rows, allocated once per call."""
    return np.zeros((5, 3))


@kernel()
def positive_part(a, b, c):  # type: ignore[no-untyped-def]
    """Return the positive semi-definite part of [[a, c], [c, b]] as (a, b, c)."""
    mean, half = 0.5 * (a + b), 0.5 * (a - b)
    radius = math.sqrt(half * half + c * c)
    if mean - radius >= 0.0:
        return a, b, c
    if mean + radius <= 0.0:
        return 0.0, 0.0, 0.0
    scale = (mean + radius) / (2.0 * radius)
    return scale * (radius + half), scale * (radius - half), scale * c
