"""The contours along which a mesh intersects itself, and the derivative of their length by the vertices."""

from __future__ import annotations

import numpy as np

from ..run.kernels import kernel

MIN_EDGE_FACE_SINE = 0.1
"""Sine of the angle between an edge and a face to which smaller ones are clamped: for an edge almost in the face the
intersection point, and the gradient with it, would be unbounded."""


def measure_contour(vertices: np.ndarray, faces: np.ndarray, pairs: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the length of the intersection of pairs of faces [m] and its gradient by the vertices.

    Two triangles that intersect meet along a segment; each of its ends is a point P where an edge (p, q) of one passes
    through the other, of normal N and barycentric weights w:

        P = p + t (q - p),  t = N . (a - p) / N . E,  E = q - p
        dL/dp = (1 - t) M g,  dL/dq = t M g,  dL/dx_k = w_k N (E . g) / (N . E),  M = I - N E^T / (N . E)

    with g = dL/dP the unit vector along the segment. Shortening the contour untangles a surface (Volino and
    Magnenat-Thalmann 2006, intersection contour minimisation). **Deviation**: the exact gradient of the length, not its
    estimate for each edge; N . E is kept above `MIN_EDGE_FACE_SINE` |N| |E|.

    Args:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: Vertex indices, shape [face_count, 3].
        pairs: Pairs of faces that intersect, from `intersecting_pairs`, shape [pair_count, 2].

    Returns:
        The length [m], and its gradient, shape [vertex_count, 3].
    """
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    gradient = np.zeros_like(vertices)
    return float(_measure(vertices, np.ascontiguousarray(faces, dtype=np.int64), pairs, gradient)), gradient


@kernel()
def _measure(x, faces, pairs, gradient):  # type: ignore[no-untyped-def]
    """Sum the segments of all pairs and their gradients."""
    total = 0.0
    ends, corners, sizes = np.zeros((6, 3)), np.zeros((6, 5), np.int64), np.zeros((6, 8))
    pull = np.zeros(3)
    for n in range(len(pairs)):
        count = 0
        for turn in range(2):
            one, other = faces[pairs[n, turn]], faces[pairs[n, 1 - turn]]
            for k in range(3):
                p, q = one[k], one[(k + 1) % 3]
                if _pierce(x, p, q, other, ends[count], sizes[count]):
                    corners[count, 0], corners[count, 1] = p, q
                    corners[count, 2:] = other
                    count += 1
        if count < 2:
            continue
        length = 0.0
        for d in range(3):
            pull[d] = ends[0, d] - ends[1, d]
            length += pull[d] * pull[d]
        length = np.sqrt(length)
        total += length
        if length == 0.0:
            continue
        for e in range(2):
            for d in range(3):
                pull[d] = (ends[e, d] - ends[1 - e, d]) / length
            _scatter_gradient(x, corners[e], sizes[e], pull, gradient)
    return total


@kernel()
def _pierce(x, p, q, face, end, sizes):  # type: ignore[no-untyped-def]
    """Check whether an edge passes through a face; write where, t, the weights, the normal and N . E."""
    a, b, c = face[0], face[1], face[2]
    u, v, edge, direction = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    for d in range(3):
        u[d], v[d] = x[b, d] - x[a, d], x[c, d] - x[a, d]
        edge[d], direction[d] = x[q, d] - x[p, d], x[a, d] - x[p, d]
    normal = np.cross(u, v)
    square = (normal * normal).sum()
    slope = (normal * edge).sum()
    if square == 0.0 or slope == 0.0:
        return False
    t = (normal * direction).sum() / slope
    if t <= 0.0 or t >= 1.0:
        return False
    for d in range(3):
        end[d] = x[p, d] + t * edge[d]
        direction[d] = end[d] - x[a, d]
    one = (np.cross(direction, v) * normal).sum() / square
    two = (np.cross(u, direction) * normal).sum() / square
    if one <= 0.0 or two <= 0.0 or one + two >= 1.0:
        return False
    least = MIN_EDGE_FACE_SINE * np.sqrt(square * (edge * edge).sum())
    sizes[0], sizes[1], sizes[2], sizes[3] = t, 1.0 - one - two, one, two
    for d in range(3):
        sizes[4 + d] = normal[d]
    sizes[7] = slope if abs(slope) > least else (least if slope > 0.0 else -least)
    return True


@kernel()
def _scatter_gradient(x, corners, sizes, pull, gradient):  # type: ignore[no-untyped-def]
    """Add the gradient by a segment's end to the five vertices on which that end depends."""
    p, q = corners[0], corners[1]
    along = 0.0
    for d in range(3):
        along += (x[q, d] - x[p, d]) * pull[d]
    along /= sizes[7]
    for d in range(3):
        slid = sizes[4 + d] * along
        gradient[p, d] += (1.0 - sizes[0]) * (pull[d] - slid)
        gradient[q, d] += sizes[0] * (pull[d] - slid)
        for k in range(3):
            gradient[corners[2 + k], d] += sizes[1 + k] * slid
