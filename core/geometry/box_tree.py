"""A tree of boxes round triangles that follows them as they move, and finds the closest point of them."""

from __future__ import annotations

import numpy as np

from ..run.kernels import kernel
from .vectors import dot, scale, subtract

MAX_LEAF_FACE_COUNT = 2
"""Largest number of faces in a leaf: with 1 a search takes as long and refitting longer, with 8 a search takes half as
long again."""

DEGENERATE_AREA_RATIO = 1e-12
"""Ratio of a triangle's squared double area to the product of two squared sides below which its plane is not defined in
float64; the closest point is then one of its edges."""


class BoxTree:
    """Find closest points of triangles by axis-aligned boxes in a complete binary tree, exactly.

    Faces are halved at the median of their centres along the longest side of the box of these, level by level. Node 1
    is the root, 2 k and 2 k + 1 are below node k. Boxes are exact for any positions of the vertices, so that the tree
    of moved vertices keeps the order of the faces.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray, order: np.ndarray | None = None) -> None:
        """Order the faces and fit the boxes.

        Args:
            vertices: Positions [m], float64, shape [vertex_count, 3].
            faces: Vertex indices, int64, shape [face_count, 3], at least one.
            order: The order of the faces in the leaves, from another tree; None: the median's.
        """
        self._faces = faces
        leaves = 1 << max(0, int(np.ceil(np.log2(max(len(faces), 1) / MAX_LEAF_FACE_COUNT))))
        self._order = _order_faces(vertices[faces].mean(axis=1), leaves) if order is None else order
        self._corners, self._boxes = np.zeros((len(faces), 3, 3)), np.zeros((2 * leaves, 6))
        _fit_boxes(vertices, faces, self._order, self._corners, self._boxes)

    def refit(self, vertices: np.ndarray) -> BoxTree:
        """Return the tree of the same faces at other positions [m], made in a tenth of the time."""
        return BoxTree(vertices, self._faces, self._order)

    def search(
        self, points: np.ndarray, hints: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Find the closest point of all triangles to each point [m], float64, shape [n, 3].

        Args:
            points: Positions.
            hints: A face to begin with for each point, shape [n]; it changes the time, and which face is returned where
                several are equally near.

        Returns:
            Distances [m], faces, shape [n] each; feet [m] and their barycentric coordinates, shape [n, 3] each.
        """
        place = np.zeros(len(points), np.int64)
        if hints is not None:
            places = np.zeros(len(self._order), np.int64)
            places[self._order] = np.arange(len(places))
            place = places[hints]
        found = np.zeros(len(points)), place, np.zeros((len(points), 3)), np.zeros((len(points), 3))
        _search_tree(points, self._corners, self._boxes, found)
        return found[0], self._order[place], found[2], found[3]


@kernel(error_model="numpy")
def _order_faces(centres, leaves):  # type: ignore[no-untyped-def]
    """Return the faces' order, of which run k of 2^j equal ones belongs to node 2^j + k on level j of the tree; sort
    their centres, shape [face_count, 3], by it in place."""
    count = len(centres)
    order, runs = np.arange(count), 1
    while runs < leaves:
        for run in range(runs):
            start, middle, end = run * count // runs, (2 * run + 1) * count // (2 * runs), (run + 1) * count // runs
            axis, longest = 0, -1.0
            for d in range(3):
                low, high = np.inf, -np.inf
                for i in range(start, end):
                    low, high = min(low, centres[i, d]), max(high, centres[i, d])
                if high - low > longest:
                    axis, longest = d, high - low
            _split_at(centres, axis, order, (start, middle, end))
        runs *= 2
    return order


@kernel(error_model="numpy")
def _split_at(centres, axis, order, run):  # type: ignore[no-untyped-def]
    """Exchange entries of a run, (start, middle, end), until no centre before `middle` lies further along the axis than
    one from it on (Hoare 1961, FIND)."""
    start, middle, end = run
    low, high = start, end - 1
    while low < high:
        pivot = centres[(low + high) // 2, axis]
        i, j = low, high
        while i <= j:
            while centres[i, axis] < pivot:
                i += 1
            while centres[j, axis] > pivot:
                j -= 1
            if i <= j:
                for d in range(3):
                    centres[i, d], centres[j, d] = centres[j, d], centres[i, d]
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return


@kernel(error_model="numpy")
def _fit_boxes(vertices, faces, order, corners, boxes):  # type: ignore[no-untyped-def]
    """Fill corners [face_count, 3, 3] in the leaves' order, and boxes [2 leaves, 6], lowest coordinates first [m]."""
    count, leaves = len(order), len(boxes) // 2
    boxes[:, :3], boxes[:, 3:] = np.inf, -np.inf
    for leaf in range(leaves):
        box = boxes[leaves + leaf]
        for i in range(leaf * count // leaves, (leaf + 1) * count // leaves):
            for k in range(3):
                for d in range(3):
                    at = vertices[faces[order[i], k], d]
                    corners[i, k, d] = at
                    box[d], box[3 + d] = min(box[d], at), max(box[3 + d], at)
    for node in range(leaves - 1, 0, -1):
        for d in range(3):
            boxes[node, d] = min(boxes[2 * node, d], boxes[2 * node + 1, d])
            boxes[node, 3 + d] = max(boxes[2 * node, 3 + d], boxes[2 * node + 1, 3 + d])


@kernel(error_model="numpy")
def _search_tree(points, corners, boxes, found):  # type: ignore[no-untyped-def]
    """Fill distances, places in the leaves' order, feet and coordinates; places are those to begin with."""
    distances, places, feet, shares = found
    count, leaves = len(corners), len(boxes) // 2
    if count == 0:
        return
    # on each level at most one node waits
    waiting, least = np.zeros(64, np.int64), np.zeros(64)
    for n in range(len(points)):
        p, at = points[n], places[n]
        best, v, w = _closest_in_triangle(p, corners[at])
        waiting[0], least[0], height = 1, _square_to_box(p, boxes[1]), 1
        while height > 0:
            height -= 1
            node, below = waiting[height], least[height]
            while below < best and node < leaves:
                near, far = 2 * node, 2 * node + 1
                below, beyond = _square_to_box(p, boxes[near]), _square_to_box(p, boxes[far])
                if beyond < below:
                    near, far, below, beyond = far, near, beyond, below
                if beyond < best:
                    waiting[height], least[height] = far, beyond
                    height += 1
                node = near
            if below >= best:
                continue
            for i in range((node - leaves) * count // leaves, (node - leaves + 1) * count // leaves):
                square, along, across = _closest_in_triangle(p, corners[i])
                if square < best:
                    best, at, v, w = square, i, along, across
        distances[n], places[n] = np.sqrt(best), at
        shares[n, 0], shares[n, 1], shares[n, 2] = max(1.0 - v - w, 0.0), v, w
        for d in range(3):
            a = corners[at, 0, d]
            feet[n, d] = a + v * (corners[at, 1, d] - a) + w * (corners[at, 2, d] - a)


@kernel(inline="always")
def _square_to_box(p, box):  # type: ignore[no-untyped-def]
    """Return the squared distance of a point from a box [m2]; no more than that from any point in it."""
    x = max(box[0] - p[0], 0.0, p[0] - box[3])
    y = max(box[1] - p[1], 0.0, p[1] - box[4])
    z = max(box[2] - p[2], 0.0, p[2] - box[5])
    return x * x + y * y + z * z


@kernel(error_model="numpy")
def _closest_in_triangle(p, corners):  # type: ignore[no-untyped-def]
    """Return the squared distance [m2] of p from the triangle a, b, c, and the coordinates v and w of b and c at its
    foot, a + v (b - a) + w (c - a).

    v and w minimise |p - a - v (b - a) - w (c - a)|^2; where one of v, w, 1 - v - w is negative, the foot is on an edge
    that p's projection is beyond (Ericson 2005, section 5.1.5).
    """
    first, second, offset = subtract(corners[1], corners[0]), subtract(corners[2], corners[0]), subtract(p, corners[0])
    bb, bc, cc = dot(first, first), dot(first, second), dot(second, second)
    pb, pc, squared_area = dot(offset, first), dot(offset, second), bb * cc - bc * bc
    flat = squared_area <= DEGENERATE_AREA_RATIO * bb * cc
    if not flat:
        v, w = (cc * pb - bc * pc) / squared_area, (bb * pc - bc * pb) / squared_area
        if v >= 0.0 and w >= 0.0 and v + w <= 1.0:
            away = subtract(subtract(offset, scale(v, first)), scale(w, second))
            return dot(away, away), v, w
    best, found_v, found_w = np.inf, 0.0, 0.0
    if flat or w < 0.0:
        best, found_v = _closest_on_edge(offset, first)
    if flat or v < 0.0:
        square, along = _closest_on_edge(offset, second)
        if square < best:
            best, found_v, found_w = square, 0.0, along
    if flat or v + w > 1.0:
        square, along = _closest_on_edge(subtract(p, corners[1]), subtract(corners[2], corners[1]))
        if square < best:
            best, found_v, found_w = square, 1.0 - along, along
    return best, found_v, found_w


@kernel(error_model="numpy")
def _closest_on_edge(offset, edge):  # type: ignore[no-untyped-def]
    """Return a point's squared distance [m2] from an edge, given from its start, and the share of it at the foot."""
    along = min(max(dot(offset, edge) / max(dot(edge, edge), 1e-300), 0.0), 1.0)
    away = subtract(offset, scale(along, edge))
    return dot(away, away), along
