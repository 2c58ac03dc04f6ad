"""Products of vectors in kernels: arrays or triples in, triples out."""

from __future__ import annotations

from ..run.kernels import kernel


@kernel(inline="always")
def subtract(a, b):  # type: ignore[no-untyped-def]
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel(inline="always")
def cross(a, b):  # type: ignore[no-untyped-def]
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel(inline="always")
def dot(a, b):  # type: ignore[no-untyped-def]
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(inline="always")
def scale(factor, a):  # type: ignore[no-untyped-def]
    """Return factor a."""
    return factor * a[0], factor * a[1], factor * a[2]
