"""Closest points of a node and a face and of two edges, and their derivatives by the nodes."""

from __future__ import annotations

import math

import numpy as np

from ...run.kernels import kernel

NODE_FACE, EDGE_EDGE = 0, 1
"""Codes of the kinds of pairs in the kernels. A node and a face are (p, a, b, c); two edges are (p, q) and (r, s)."""

PARALLEL_EDGE_SHARE = 1e-3
"""Share of |e1|^2 |e2|^2 at rest under which |e1 x e2|^2 counts as nearly parallel (Li et al. 2020, 6.3)."""

_DEGENERATE_AREA_SHARE = 1e-20
"""Share of the squared lengths under which a triangle or a pair of edges has no defined direction."""


@kernel(inline="always")
def _dot(x, i, j, k, m):  # type: ignore[no-untyped-def]
    """Return (x_j - x_i) . (x_m - x_k)."""
    return (
        (x[j, 0] - x[i, 0]) * (x[m, 0] - x[k, 0])
        + (x[j, 1] - x[i, 1]) * (x[m, 1] - x[k, 1])
        + (x[j, 2] - x[i, 2]) * (x[m, 2] - x[k, 2])
    )


@kernel()
def closest_weights(x, pair, kind, weights, rates):  # type: ignore[no-untyped-def]
    """Find the closest points of a pair: fill the four weights of r = sum_k w_k x_k, the vector between them. `rates`
    [2, 4] are dw/dp by the free parameters p (not at an end of their range); returns their number, 0 to 2."""
    weights[:] = 0.0
    rates[:] = 0.0
    if kind == NODE_FACE:
        return _closest_weights_face(x, pair[0], pair[1], pair[2], pair[3], weights, rates)
    return _closest_weights_edges(x, pair[0], pair[1], pair[2], pair[3], weights, rates)


@kernel()
def _closest_weights_face(x, p, a, b, c, weights, rates):  # type: ignore[no-untyped-def]
    """Find the point of a triangle that is closest to a node, by its regions (Ericson 2005, 5.1.5)."""
    weights[0] = 1.0
    d1, d2 = _dot(x, a, b, a, p), _dot(x, a, c, a, p)
    if d1 <= 0.0 and d2 <= 0.0:
        weights[1] = -1.0
        return 0
    d3, d4 = _dot(x, a, b, b, p), _dot(x, a, c, b, p)
    if d3 >= 0.0 and d4 <= d3:
        weights[2] = -1.0
        return 0
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return _on_side(weights, rates, 1, 2, d1 / (d1 - d3))
    d5, d6 = _dot(x, a, b, c, p), _dot(x, a, c, c, p)
    if d6 >= 0.0 and d5 <= d6:
        weights[3] = -1.0
        return 0
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return _on_side(weights, rates, 1, 3, d2 / (d2 - d6))
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        return _on_side(weights, rates, 2, 3, (d4 - d3) / ((d4 - d3) + (d5 - d6)))
    total = va + vb + vc
    u, v = vb / total, vc / total
    weights[1], weights[2], weights[3] = u + v - 1.0, -u, -v
    rates[0, 1], rates[0, 2] = 1.0, -1.0
    rates[1, 1], rates[1, 3] = 1.0, -1.0
    return 2


@kernel(inline="always")
def _on_side(weights, rates, first, second, along):  # type: ignore[no-untyped-def]
    """Set the closest point on a side of the triangle."""
    weights[first], weights[second] = along - 1.0, -along
    rates[0, first], rates[0, second] = 1.0, -1.0
    return 1


@kernel()
def _closest_weights_edges(x, p, q, r, s, weights, rates):  # type: ignore[no-untyped-def]
    """Find the closest points of two segments (Ericson 2005, 5.1.9); for parallel ones the middle of the overlap. Where
    they are parallel to round-off the first parameter counts as fixed: the mollifier is zero there."""
    a, e, f = _dot(x, p, q, p, q), _dot(x, r, s, r, s), _dot(x, r, s, r, p)
    c, b = _dot(x, p, q, r, p), _dot(x, p, q, r, s)
    area = a * e - b * b
    free_one, free_two = True, True
    if area > _DEGENERATE_AREA_SHARE * a * e:
        one = (b * f - c * e) / area
    else:
        one, free_one = 0.5, False
    if one <= 0.0:
        one, free_one = 0.0, False
    elif one >= 1.0:
        one, free_one = 1.0, False
    two = (b * one + f) / e
    if two <= 0.0 or two >= 1.0:
        two, free_two = (0.0 if two <= 0.0 else 1.0), False
        one, free_one = (b * two - c) / a, True
        if one <= 0.0:
            one, free_one = 0.0, False
        elif one >= 1.0:
            one, free_one = 1.0, False
    weights[0], weights[1], weights[2], weights[3] = 1.0 - one, one, two - 1.0, -two
    count = 0
    if free_one:
        rates[count, 0], rates[count, 1] = -1.0, 1.0
        count += 1
    if free_two:
        rates[count, 2], rates[count, 3] = 1.0, -1.0
        count += 1
    return count


@kernel()
def pair_distance(x, pair, weights, vector):  # type: ignore[no-untyped-def]
    """Fill the vector sum_k w_k x_k and return its length."""
    square = 0.0
    for d in range(3):
        part = 0.0
        for k in range(4):
            part += weights[k] * x[pair[k], d]
        vector[d] = part
        square += part * part
    return math.sqrt(square)


@kernel()
def distance_hessian(x, pair, weights, rates, free, vector, distance, curve):  # type: ignore[no-untyped-def]
    """Fill the Hessian of a pair's distance, 16 blocks [4, 4, 3, 3], where the distance is above zero.

    With D = min_p |r|^2, r = sum_k w_k(p) x_k, r_p = dr/dp, P_pq = 2 r_p . r_q and G_pa = 2 (w_a r_p + w_a,p r) the
    implicit function theorem gives

        D_ab = 2 w_a w_b I - sum_pq G_pa (P^-1)_pq G_qb^T,    d_ab = (D_ab - 2 w_a w_b n n^T) / (2 d),  n = r / d.
    """
    along, turned = np.zeros((2, 3)), np.zeros((2, 4, 3))
    for p in range(free):
        for d in range(3):
            for k in range(4):
                along[p, d] += rates[p, k] * x[pair[k], d]
        for k in range(4):
            for d in range(3):
                turned[p, k, d] = 2.0 * (weights[k] * along[p, d] + rates[p, k] * vector[d])
    inverse = np.zeros((2, 2))
    first = 2.0 * (along[0] ** 2).sum()
    if free == 1 and first > 0.0:
        inverse[0, 0] = 1.0 / first
    elif free == 2:
        second, mixed = 2.0 * (along[1] ** 2).sum(), 2.0 * (along[0] * along[1]).sum()
        area = first * second - mixed * mixed
        if area > _DEGENERATE_AREA_SHARE * first * second:
            inverse[0, 0], inverse[1, 1] = second / area, first / area
            inverse[0, 1] = inverse[1, 0] = -mixed / area
    for a in range(4):
        for b in range(4):
            for d in range(3):
                for e in range(3):
                    value = -2.0 * weights[a] * weights[b] * vector[d] * vector[e] / (distance * distance)
                    if d == e:
                        value += 2.0 * weights[a] * weights[b]
                    for p in range(free):
                        for q in range(free):
                            value -= turned[p, a, d] * inverse[p, q] * turned[q, b, e]
                    curve[a, b, d, e] = value / (2.0 * distance)


@kernel()
def mollify(x, pair, least, slope):  # type: ignore[no-untyped-def]
    """Return m(c) = (2 - c / least) c / least and m', m'' of c = |u x v|^2 < least, else 1, 0, 0; fill dc/dx [4, 3]. u
    and v are the edges (p, q) and (r, s). The direction between their closest points is discontinuous where they are
    parallel; m makes the energy zero there (Li et al. 2020, 6.3), and node-face pairs keep them apart."""
    p, q, r, s = pair[0], pair[1], pair[2], pair[3]
    uu, vv, uv = _dot(x, p, q, p, q), _dot(x, r, s, r, s), _dot(x, p, q, r, s)
    cross = uu * vv - uv * uv
    if cross >= least:
        return 1.0, 0.0, 0.0
    for d in range(3):
        u, v = x[q, d] - x[p, d], x[s, d] - x[r, d]
        slope[1, d] = 2.0 * (vv * u - uv * v)
        slope[3, d] = 2.0 * (uu * v - uv * u)
        slope[0, d], slope[2, d] = -slope[1, d], -slope[3, d]
    return (2.0 - cross / least) * cross / least, 2.0 * (1.0 - cross / least) / least, -2.0 / (least * least)


@kernel()
def cross_product_hessian(x, pair, curve):  # type: ignore[no-untyped-def]
    """Fill the Hessian of c = |u x v|^2, 16 blocks [4, 4, 3, 3]."""
    p, q, r, s = pair[0], pair[1], pair[2], pair[3]
    uu, vv, uv = _dot(x, p, q, p, q), _dot(x, r, s, r, s), _dot(x, p, q, r, s)
    for d in range(3):
        ud, vd = x[q, d] - x[p, d], x[s, d] - x[r, d]
        for e in range(3):
            ue, ve = x[q, e] - x[p, e], x[s, e] - x[r, e]
            same = 1.0 if d == e else 0.0
            by_uu = 2.0 * vv * same - 2.0 * vd * ve
            by_vv = 2.0 * uu * same - 2.0 * ud * ue
            by_uv = 4.0 * ud * ve - 2.0 * vd * ue - 2.0 * uv * same
            by_vu = 4.0 * vd * ue - 2.0 * ud * ve - 2.0 * uv * same
            for a in range(4):
                for b in range(4):
                    sign = 1.0 if (a % 2) == (b % 2) else -1.0
                    if a < 2 and b < 2:
                        curve[a, b, d, e] = sign * by_uu
                    elif a >= 2 and b >= 2:
                        curve[a, b, d, e] = sign * by_vv
                    elif a < 2:
                        curve[a, b, d, e] = sign * by_uv
                    else:
                        curve[a, b, d, e] = sign * by_vu
