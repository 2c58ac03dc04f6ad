"""The terms of the deformation that compare a garment with its target, each with its gradient."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.vectors import cross, dot, subtract
from ...run.kernels import kernel


class PointRows(NamedTuple):
    """Describe points y_r = sum_k c_rk x_i(r, k) of a mesh, or normals there, and what each is compared with.

    Attributes:
        nodes: i, shape [row_count, k].
        shares: c, rows sum to 1, shape [row_count, k].
        goals: p, positions [m] or unit normals, shape [row_count, 3].
        weights: w, shape [row_count].
    """

    nodes: np.ndarray
    shares: np.ndarray
    goals: np.ndarray
    weights: np.ndarray


@kernel(error_model="numpy")
def squared_distances(x, rows, scale, gradient):  # type: ignore[no-untyped-def]
    """Return q sum_r w_r |y_r - p_r|^2 [m2] (thesis eq. 3.8 and 4.2) and add its gradient by x, 2 q w_r c_rk (y_r -
    p_r) at each node.

    Notation: `rows` a `PointRows` of positions; x [m], shape [node_count, 3]; `scale` q, the term's weight.
    """
    nodes, shares, goals, weights = rows
    total = 0.0
    for r in range(len(nodes)):
        for d in range(3):
            away = -goals[r, d]
            for k in range(nodes.shape[1]):
                away += shares[r, k] * x[nodes[r, k], d]
            total += weights[r] * away * away
            for k in range(nodes.shape[1]):
                gradient[nodes[r, k], d] += 2.0 * scale * weights[r] * shares[r, k] * away
    return scale * total


@kernel(error_model="numpy")
def cosine_distances(normals, rows, scale, unsigned, slopes):  # type: ignore[no-untyped-def]
    """Return q sum_r w_r (1 - u_r . p_r), u_r = y_r / |y_r| (thesis eq. 4.3), and add its gradient by the vertex
    normals, -q w_r c_rk (p_r - (u_r . p_r) u_r) / |y_r|.

    Notation: `rows` a `PointRows` of normals: y_r interpolates the vertex normals n, shape [node_count, 3], and p_r is
    the target's; `scale` q, the term's weight [m2]. If `unsigned`, |u_r . p_r| replaces u_r . p_r.
    """
    nodes, shares, goals, weights = rows
    total, mean, turn = 0.0, np.zeros(3), np.zeros(3)
    for r in range(len(nodes)):
        mean[:] = 0.0
        for k in range(nodes.shape[1]):
            for d in range(3):
                mean[d] += shares[r, k] * normals[nodes[r, k], d]
        length = math.sqrt(dot(mean, mean))
        if length == 0.0:
            total += weights[r]
            continue
        cosine = dot(mean, goals[r]) / length
        sign = -1.0 if unsigned and cosine < 0.0 else 1.0
        total += weights[r] * (1.0 - sign * cosine)
        for d in range(3):
            turn[d] = -sign * scale * weights[r] * (goals[r, d] - cosine * mean[d] / length) / length
        for k in range(nodes.shape[1]):
            for d in range(3):
                slopes[nodes[r, k], d] += shares[r, k] * turn[d]
    return scale * total


@kernel(error_model="numpy")
def unit_normals(x, faces, normals, lengths):  # type: ignore[no-untyped-def]
    """Fill the vertex normals n_i = s_i / |s_i|, s_i the sum of (x_1 - x_0) x (x_2 - x_0) over the faces around i, and
    their lengths |s_i| [m2]."""
    normals[:] = 0.0
    for f in range(len(faces)):
        start = x[faces[f, 0]]
        vector = cross(subtract(x[faces[f, 1]], start), subtract(x[faces[f, 2]], start))
        for k in range(3):
            for d in range(3):
                normals[faces[f, k], d] += vector[d]
    for i in range(len(normals)):
        lengths[i] = math.sqrt(dot(normals[i], normals[i]))
        if lengths[i] > 0.0:
            normals[i] /= lengths[i]


@kernel(error_model="numpy")
def pull_back_normals(x, faces, found, slopes, gradient):  # type: ignore[no-untyped-def]
    """Add the gradient by x of what has the gradient `slopes` by the vertex normals.

    By s_i it is (I - n_i n_i^T) slope_i / |s_i|; with g its sum over a face's corners, the face's share is
    (x_2 - x_0) x g at x_1, g x (x_1 - x_0) at x_2 and minus both at x_0.

    Notation: `found` n and |s| of `unit_normals`. A vertex whose s is 0 has no normal, and no share.
    """
    normals, lengths = found
    by_sum, g = np.zeros_like(slopes), np.zeros(3)
    for i in range(len(normals)):
        if lengths[i] > 0.0:
            along = dot(slopes[i], normals[i])
            for d in range(3):
                by_sum[i, d] = (slopes[i, d] - along * normals[i, d]) / lengths[i]
    for f in range(len(faces)):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        for d in range(3):
            g[d] = by_sum[i, d] + by_sum[j, d] + by_sum[k, d]
        at_j, at_k = cross(subtract(x[k], x[i]), g), cross(g, subtract(x[j], x[i]))
        for d in range(3):
            gradient[j, d] += at_j[d]
            gradient[k, d] += at_k[d]
            gradient[i, d] -= at_j[d] + at_k[d]
