"""Patches of a cloth: small groups of faces, and for each two that join, their parts' least distance when flat."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sparse

from ...geometry.connectivity import HalfEdges
from ...run.kernels import kernel
from .closest import EDGE_EDGE, NODE_FACE, closest_weights, pair_distance

_LAYOUT_ITERATIONS = 4
"""Number of iterations that move the layout of a patch towards the shape of its flat triangles. Patches around a seam
or a dart have no exact plane layout; theirs is a least-squares compromise."""


class RaggedLists(NamedTuple):
    """Concatenated lists: where each begins, shape [list_count + 1], and their entries."""

    starts: np.ndarray
    members: np.ndarray

    @classmethod
    def of(cls, owners: np.ndarray, members: np.ndarray, count: int) -> RaggedLists:
        """Group members by their owners, shape [member_count] both, in the given order."""
        order = np.argsort(owners, kind="stable")
        starts = np.concatenate([[0], np.cumsum(np.bincount(owners, minlength=count))])
        return cls(starts.astype(np.int64), np.ascontiguousarray(members[order], dtype=np.int64))


class Patches(NamedTuple):
    """Partition of a cloth into groups of neighbouring faces, with the layout of each two that share a node. Each node,
    face and edge belongs to one patch, so each pair of them belongs to one pair of patches.

    Attributes:
        corners: All nodes of each patch's faces; those on its rim are in other patches too.
        nodes, faces, edges: Nodes, faces and edges that belong to each patch.
        around: The patches that share a node with each, itself included, ascending.
        joined: Pairs of patches that share a node, the lower first, and each with itself, shape [joined_count, 2].
        gaps: Least distance between a part of one and a part of the other that share no node, in the plane layout [m],
            shape [joined_count].
        laid: The nodes of both.
        layout: Plane coordinates of those about their mean, and their weights in the slope by each coordinate [m, m,
            1/m, 1/m], shape [laid_count, 4].
    """

    corners: RaggedLists
    nodes: RaggedLists
    faces: RaggedLists
    edges: RaggedLists
    around: RaggedLists
    joined: np.ndarray
    gaps: np.ndarray
    laid: RaggedLists
    layout: np.ndarray


def partition_cloth(half: HalfEdges, rest: np.ndarray) -> Patches:
    """Partition a mesh into patches of about eight faces, by its flat triangles [m], shape [face_count, 3, 2]."""
    faces, count = half.faces, half.vertex_count
    all_faces = np.arange(len(faces))
    around_node = RaggedLists.of(faces.ravel(), np.repeat(all_faces, 3), count)
    owner, size = _group(faces, half.twin, around_node)
    by_corner = np.unique(np.repeat(owner, 3) * count + faces.ravel())
    corners = RaggedLists.of(by_corner // count, by_corner % count, size)
    first_face = np.full(count, -1)
    first_face[faces.ravel()[::-1]] = np.repeat(owner, 3)[::-1]
    used = np.flatnonzero(first_face >= 0)
    of_edge = np.zeros(len(half.edges), np.int64)
    of_edge[half.edge[::-1]] = np.repeat(owner, 3)[::-1]
    nodes, owners = RaggedLists.of(first_face[used], used, size), RaggedLists.of(owner, all_faces, size)
    edges = RaggedLists.of(of_edge, np.arange(len(half.edges)), size)
    touch = sparse.csr_matrix((np.ones(len(by_corner)), (by_corner // count, by_corner % count)), shape=(size, count))
    shared = (touch @ touch.T).tocsr()
    shared.sort_indices()
    around = RaggedLists(shared.indptr.astype(np.int64), shared.indices.astype(np.int64))
    first = np.repeat(np.arange(size), np.diff(around.starts))
    joined = np.column_stack([first, around.members])[first <= around.members]
    found = _lay_out(
        faces, half.twin, np.ascontiguousarray(rest), half.edges, (corners, nodes, owners, edges, around), joined
    )
    gaps, starts, laid, layout = found
    return Patches(corners, nodes, owners, edges, around, joined, gaps, RaggedLists(starts, laid), layout)


@kernel()
def _group(faces, twin, around):  # type: ignore[no-untyped-def]
    """Return the patch of each face, shape [face_count], and the number of patches. Nodes no two of which share a face
    are the centres; a face without a centre joins the patch across an edge."""
    starts, members = around
    owner, blocked, count = np.full(len(faces), -1, np.int64), np.zeros(len(starts) - 1, np.bool_), 0
    for v in range(len(starts) - 1):
        if blocked[v] or starts[v] == starts[v + 1]:
            continue
        for n in range(starts[v], starts[v + 1]):
            owner[members[n]] = count
            for k in range(3):
                blocked[faces[members[n], k]] = True
        count += 1
    left = np.flatnonzero(owner < 0)
    while len(left):
        taken = np.full(len(left), -1, np.int64)
        for n in range(len(left)):
            for k in range(3):
                across = twin[3 * left[n] + k]
                if across >= 0 and owner[across // 3] >= 0:
                    taken[n] = owner[across // 3]
                    break
        if (taken < 0).all():
            taken[0] = count
            count += 1
        owner[left] = taken
        left = left[taken < 0]
    return owner, count


@kernel()
def _lay_out(faces, twin, rest, sides, lists, joined):  # type: ignore[no-untyped-def]
    """Return gaps, starts, nodes and layout of the joined pairs; see `Patches`."""
    corners, _, _, _, _ = lists
    gaps, starts = np.zeros(len(joined)), np.zeros(len(joined) + 1, np.int64)
    laid, layout = np.zeros(64 * len(joined), np.int64), np.zeros((64 * len(joined), 4))
    count = faces.max() + 1
    place, placed, sums = np.zeros((count, 3)), np.zeros(count, np.bool_), np.zeros((count, 3))
    reached = np.zeros(len(faces), np.bool_)
    current, end = -1, 0
    for n in range(len(joined)):
        c, d = joined[n]
        if c != current:
            current = c
            _unfold(c, faces, twin, rest, lists, (place, placed, sums, reached))
        first, sound = end, True
        for patch in (c, d):
            for m in range(corners[0][patch], corners[0][patch + 1]):
                v, known = corners[1][m], False
                for k in range(first, end):
                    known = known or laid[k] == v
                if known:
                    continue
                if end == len(laid):
                    laid, layout = np.concatenate((laid, laid)), np.concatenate((layout, layout))
                laid[end] = v
                layout[end, 0], layout[end, 1] = place[v, 0], place[v, 1]
                sound = sound and placed[v]
                end += 1
        starts[n + 1] = end
        if sound and _weigh_slopes(layout[first:end]):
            gaps[n] = _gap(c, d, place, faces, sides, lists)
    return gaps, starts, laid[:end].copy(), layout[:end].copy()


@kernel()
def _weigh_slopes(layout):  # type: ignore[no-untyped-def]
    """Centre a layout and fill the weights of its slopes, W = Y (Y^T Y)^-1; return False where it is degenerate."""
    for k in range(2):
        layout[:, k] -= layout[:, k].mean()
    a, b, c = (layout[:, 0] ** 2).sum(), (layout[:, 0] * layout[:, 1]).sum(), (layout[:, 1] ** 2).sum()
    area = a * c - b * b
    if not area > 1e-6 * a * c:
        return False
    for n in range(len(layout)):
        y, z = layout[n, 0], layout[n, 1]
        layout[n, 2], layout[n, 3] = (c * y - b * z) / area, (a * z - b * y) / area
    return True


@kernel()
def _unfold(patch, faces, twin, rest, lists, found):  # type: ignore[no-untyped-def]
    """Lay out a patch and those around it in a plane: fill positions [m] of their nodes and which have one. Faces are
    placed across edges as their flat triangles; then each node moves to the mean of where its triangles, fitted rigidly
    to their corners, have it. Any layout is valid: cloth that differs from it is only tested in detail."""
    _, _, owners, _, around = lists
    place, placed, sums, reached = found
    placed[:] = False
    reached[:] = True
    count = 0
    for m in range(around[0][patch], around[0][patch + 1]):
        other = around[1][m]
        count += owners[0][other + 1] - owners[0][other]
        for k in range(owners[0][other], owners[0][other + 1]):
            reached[owners[1][k]] = False
    queue, head, tail = np.zeros(count, np.int64), 0, 1
    queue[0] = owners[1][owners[0][patch]]
    reached[queue[0]] = True
    for k in range(3):
        v = faces[queue[0], k]
        place[v, 0], place[v, 1], place[v, 2] = rest[queue[0], k, 0], rest[queue[0], k, 1], 0.0
        placed[v] = True
    mirrored = _area(rest[queue[0]]) < 0.0
    if mirrored:
        for k in range(3):
            place[faces[queue[0], k], 0] *= -1.0
    while head < tail:
        f = queue[head]
        head += 1
        for k in range(3):
            across = twin[3 * f + k]
            if across < 0 or reached[across // 3]:
                continue
            g, j = across // 3, across % 3
            reached[g] = True
            queue[tail] = g
            tail += 1
            a, b, apex = faces[g, j], faces[g, (j + 1) % 3], faces[g, (j + 2) % 3]
            if placed[apex]:
                continue
            _set_apex(place[a], place[b], rest[g, j], rest[g, (j + 1) % 3], rest[g, (j + 2) % 3], place[apex])
            placed[apex] = True
    for _ in range(_LAYOUT_ITERATIONS):
        for n in range(tail):
            for k in range(3):
                sums[faces[queue[n], k]] = 0.0
        for n in range(tail):
            _add_rigid_fit(faces[queue[n]], rest[queue[n]], place, sums)
        for n in range(tail):
            for k in range(3):
                v = faces[queue[n], k]
                if sums[v, 2] > 0.0:
                    place[v, 0], place[v, 1] = sums[v, 0] / sums[v, 2], sums[v, 1] / sums[v, 2]
                    sums[v, 2] = 0.0


@kernel()
def _area(flat):  # type: ignore[no-untyped-def]
    """Return twice the signed area of a flat triangle [m2]."""
    return (flat[1, 0] - flat[0, 0]) * (flat[2, 1] - flat[0, 1]) - (flat[1, 1] - flat[0, 1]) * (flat[2, 0] - flat[0, 0])


@kernel()
def _set_apex(a, b, flat_a, flat_b, flat_c, apex):  # type: ignore[no-untyped-def]
    """Fill the third corner of a triangle, left of its edge a b [m], from its flat corners [m]."""
    u, v = flat_b[0] - flat_a[0], flat_b[1] - flat_a[1]
    length = np.sqrt(u * u + v * v)
    along = (u * (flat_c[0] - flat_a[0]) + v * (flat_c[1] - flat_a[1])) / length
    height = abs(u * (flat_c[1] - flat_a[1]) - v * (flat_c[0] - flat_a[0])) / length
    s, t = b[0] - a[0], b[1] - a[1]
    now = max(np.sqrt(s * s + t * t), 1e-12)
    s, t = s / now, t / now
    middle = along - 0.5 * length
    apex[0] = 0.5 * (a[0] + b[0]) + middle * s - height * t
    apex[1] = 0.5 * (a[1] + b[1]) + middle * t + height * s


@kernel()
def _add_rigid_fit(face, flat, place, sums):  # type: ignore[no-untyped-def]
    """Add the corners of a flat triangle that is fitted rigidly to the present positions of its corners."""
    sign = -1.0 if _area(flat) < 0.0 else 1.0
    y, z, p, q = 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        y, z = y + sign * flat[k, 0] / 3.0, z + flat[k, 1] / 3.0
        p, q = p + place[face[k], 0] / 3.0, q + place[face[k], 1] / 3.0
    dot, cross = 0.0, 0.0
    for k in range(3):
        u, v = sign * flat[k, 0] - y, flat[k, 1] - z
        s, t = place[face[k], 0] - p, place[face[k], 1] - q
        dot += u * s + v * t
        cross += u * t - v * s
    length = np.sqrt(dot * dot + cross * cross)
    if not length > 0.0:
        return
    dot, cross = dot / length, cross / length
    for k in range(3):
        u, v = sign * flat[k, 0] - y, flat[k, 1] - z
        sums[face[k], 0] += p + dot * u - cross * v
        sums[face[k], 1] += q + cross * u + dot * v
        sums[face[k], 2] += 1.0


@kernel()
def _gap(c, d, place, faces, sides, lists):  # type: ignore[no-untyped-def]
    """Return the least distance in the plane [m] between parts of two patches that share no node."""
    _, nodes, owners, edges, _ = lists
    pair, weights, rates, vector = np.zeros(4, np.int64), np.zeros(4), np.zeros((2, 4)), np.zeros(3)
    least = np.inf
    for turn in range(1 if c == d else 2):
        one, two = (c, d) if turn == 0 else (d, c)
        for m in range(nodes[0][one], nodes[0][one + 1]):
            pair[0] = nodes[1][m]
            for n in range(owners[0][two], owners[0][two + 1]):
                pair[1:] = faces[owners[1][n]]
                if pair[0] == pair[1] or pair[0] == pair[2] or pair[0] == pair[3]:
                    continue
                if _are_boxes_apart(place, pair, 1, least):
                    continue
                closest_weights(place, pair, NODE_FACE, weights, rates)
                least = min(least, pair_distance(place, pair, weights, vector))
    for m in range(edges[0][c], edges[0][c + 1]):
        pair[:2] = sides[edges[1][m]]
        for n in range(m + 1 if c == d else edges[0][d], edges[0][d + 1]):
            pair[2:] = sides[edges[1][n]]
            if pair[0] == pair[2] or pair[0] == pair[3] or pair[1] == pair[2] or pair[1] == pair[3]:
                continue
            if _are_boxes_apart(place, pair, 2, least):
                continue
            closest_weights(place, pair, EDGE_EDGE, weights, rates)
            least = min(least, pair_distance(place, pair, weights, vector))
    return least


@kernel()
def _are_boxes_apart(place, pair, split, least):  # type: ignore[no-untyped-def]
    """Return whether the boxes of a pair's two parts are at least `least` [m] apart along an axis of the plane."""
    for d in range(2):
        low, high, lower, higher = np.inf, -np.inf, np.inf, -np.inf
        for k in range(4):
            value = place[pair[k], d]
            if k < split:
                low, high = min(low, value), max(high, value)
            else:
                lower, higher = min(lower, value), max(higher, value)
        if lower - high >= least or low - higher >= least:
            return True
    return False
