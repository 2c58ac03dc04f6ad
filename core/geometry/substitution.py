"""Solve with the fronts of a Cholesky factor, four columns at a time because memory bandwidth is the limit."""

from __future__ import annotations

import numpy as np

from ..run.kernels import kernel


@kernel(fastmath={"reassoc", "contract"}, error_model="numpy")
def substitute(x, store, layout, joined, zero):  # type: ignore[no-untyped-def]
    """Replace x by (L L^T)^-1 x, front by front forward and backward. `layout` [front_count, 5]: start in `store`, own
    rows, boundary rows, first row, start in `joined`, which has the boundaries' rows. Each front is L11 by columns,
    then L21 by columns. `zero` has the factor's precision."""
    work = np.zeros(max(1, layout[:, 2].max()), x.dtype)
    for p in range(len(layout)):
        start, n1, n2, first, at = layout[p]
        part, tail, rows = x[first : first + n1], work[:n2], joined[at : at + n2]
        pivot, below = store[start : start + n1 * n1], store[start + n1 * n1 : start + n1 * (n1 + n2)]
        tail[:] = zero
        _substitute_forward(part, tail, pivot, below)
        for r in range(n2):
            x[rows[r]] -= tail[r]
    for p in range(len(layout) - 1, -1, -1):
        start, n1, n2, first, at = layout[p]
        part, tail, rows = x[first : first + n1], work[:n2], joined[at : at + n2]
        pivot, below = store[start : start + n1 * n1], store[start + n1 * n1 : start + n1 * (n1 + n2)]
        for r in range(n2):
            tail[r] = x[rows[r]]
        _substitute_backward(part, tail, pivot, below, zero)


@kernel(fastmath={"reassoc", "contract"}, error_model="numpy")
def _substitute_forward(part, tail, pivot, below):  # type: ignore[no-untyped-def]
    """Replace `part` by L11^-1 part, and add L21 times that to `tail`."""
    n1, n2 = len(part), len(tail)
    fours = n1 - n1 % 4
    for c in range(0, fours, 4):
        a, b, d, e = pivot[c * n1 :], pivot[(c + 1) * n1 :], pivot[(c + 2) * n1 :], pivot[(c + 3) * n1 :]
        u = part[c] / a[c]
        v = (part[c + 1] - a[c + 1] * u) / b[c + 1]
        w = (part[c + 2] - a[c + 2] * u - b[c + 2] * v) / d[c + 2]
        z = (part[c + 3] - a[c + 3] * u - b[c + 3] * v - d[c + 3] * w) / e[c + 3]
        part[c], part[c + 1], part[c + 2], part[c + 3] = u, v, w, z
        for r in range(c + 4, n1):
            part[r] -= a[r] * u + b[r] * v + d[r] * w + e[r] * z
        a, b, d, e = below[c * n2 :], below[(c + 1) * n2 :], below[(c + 2) * n2 :], below[(c + 3) * n2 :]
        for r in range(n2):
            tail[r] += a[r] * u + b[r] * v + d[r] * w + e[r] * z
    for c in range(fours, n1):
        a, b = pivot[c * n1 :], below[c * n2 :]
        u = part[c] / a[c]
        part[c] = u
        for r in range(c + 1, n1):
            part[r] -= a[r] * u
        for r in range(n2):
            tail[r] += b[r] * u


@kernel(fastmath={"reassoc", "contract"}, error_model="numpy")
def _substitute_backward(part, tail, pivot, below, zero):  # type: ignore[no-untyped-def]
    """Replace `part` by L11^-T (part - L21^T tail)."""
    n1, n2 = len(part), len(tail)
    fours = n1 - n1 % 4
    for c in range(n1 - 1, fours - 1, -1):
        a, b, u = pivot[c * n1 :], below[c * n2 :], zero
        for r in range(c + 1, n1):
            u += a[r] * part[r]
        for r in range(n2):
            u += b[r] * tail[r]
        part[c] = (part[c] - u) / a[c]
    for c in range(fours - 4, -1, -4):
        a, b, d, e = below[c * n2 :], below[(c + 1) * n2 :], below[(c + 2) * n2 :], below[(c + 3) * n2 :]
        u, v, w, z = zero, zero, zero, zero
        for r in range(n2):
            u += a[r] * tail[r]
            v += b[r] * tail[r]
            w += d[r] * tail[r]
            z += e[r] * tail[r]
        a, b, d, e = pivot[c * n1 :], pivot[(c + 1) * n1 :], pivot[(c + 2) * n1 :], pivot[(c + 3) * n1 :]
        for r in range(c + 4, n1):
            u += a[r] * part[r]
            v += b[r] * part[r]
            w += d[r] * part[r]
            z += e[r] * part[r]
        z = (part[c + 3] - z) / e[c + 3]
        w = (part[c + 2] - w - d[c + 3] * z) / d[c + 2]
        v = (part[c + 1] - v - b[c + 2] * w - b[c + 3] * z) / b[c + 1]
        u = (part[c] - u - a[c + 1] * v - a[c + 2] * w - a[c + 3] * z) / a[c]
        part[c], part[c + 1], part[c + 2], part[c + 3] = u, v, w, z
