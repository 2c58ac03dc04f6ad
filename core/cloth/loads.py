"""Energy of the nodes' masses: weight and inertia."""

from __future__ import annotations

import math

import numpy as np

from ..run.kernels import kernel


@kernel()
def loads(x, masses, gravity, inertia, order, diagonal, derivatives):  # type: ignore[no-untyped-def]
    """Add the gradient (order >= 1) and Hessian blocks (order 2) of weight and inertia and return their energy [J].

    E_v = m_v (w / 2 |x_v - y_v|^2 - g . x_v)

    Notation: `masses` m [kg]; `gravity` g [m/s2]; `inertia` = (y [m], w [1/s2]), y of no rows where there is none.
    """
    target, weight = inertia
    gradient, blocks = derivatives
    energy, is_tied = 0.0, len(target) > 0
    for v in range(x.shape[0]):
        mass = masses[v]
        for d in range(3):
            energy -= mass * gravity[d] * x[v, d]
            if order > 0:
                gradient[v, d] -= mass * gravity[d]
            if is_tied:
                offset = x[v, d] - target[v, d]
                energy += 0.5 * mass * weight * offset * offset
                if order > 0:
                    gradient[v, d] += mass * weight * offset
                if order > 1:
                    blocks[diagonal[v], d, d] += mass * weight
    return energy


@kernel()
def largest_length(vectors):  # type: ignore[no-untyped-def]
    """Return the length of the longest of vectors, shape [n, 3]; NaN where a vector has NaN."""
    most = 0.0
    for v in range(vectors.shape[0]):
        square = vectors[v, 0] ** 2 + vectors[v, 1] ** 2 + vectors[v, 2] ** 2
        if math.isnan(square):
            return np.nan
        most = max(most, square)
    return math.sqrt(most)
