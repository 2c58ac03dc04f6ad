"""Advect cloth out of a body by a smooth map of space that moves all layers alike, so that none passes another."""

from __future__ import annotations

import numpy as np

from ..geometry.intersections import face_boxes, self_intersections, undo_crossings
from .signed_distance import SignedDistance

MAX_ADVECTION_STEP = 2e-3
"""Longest move of a node in an iteration [m]: a strain of a few per cent, which folds nothing over."""

MAX_ADVECTION_ITERATIONS = 40
"""Largest number of advection iterations: together they move cloth by up to 8 cm, the depth of the crease of a lap."""

ADVECTION_CUTOFF_RATIO = 4.0
"""Cutoff distance of the displacement field [widths of the field], at which it has decayed below 1e-3."""


def advect_outside(
    nodes: np.ndarray,
    faces: np.ndarray,
    body: SignedDistance,
    width: float,
    rounds: int = MAX_ADVECTION_ITERATIONS,
    clearance: float = 1e-3,
) -> np.ndarray:
    """Advect cloth that is inside a body, and the cloth around, out of it; return the nodes [m], shape [node_count, 3].

    Each point i inside the body (a node or a face's centre) has a displacement m_i out of it. The displacement field is
    their mean, weighted by nearness, and decays with distance: u(x) = max_i w_i sum_i w_i m_i / sum_i w_i with w_i =
    exp(-|x - x_i|^2 / 2 h^2), h its width. In small steps it is a smooth map of space, which moves layers in contact
    together; where a coarse triangle follows it too badly and crosses another, its step is undone. Nodes further than
    `ADVECTION_CUTOFF_RATIO` widths from all points inside do not move.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        faces: Shape [face_count, 3].
        body: Signed distance to the body; where it gives several surfaces for a point, only the first counts.
        width: Width of the displacement field [m]: about an edge of the cloth.
        rounds: Largest number of iterations; each moves up to 2 mm.
        clearance: Distance to reach [m].
    """
    nodes = np.array(nodes, dtype=np.float64)
    points = np.concatenate([nodes, nodes[faces].mean(axis=1)])
    distance, normal = (values[: len(points)] for values in body.measure(points))
    for _ in range(rounds):
        low = np.flatnonzero(distance < 0.0)
        if not len(low):
            break
        inside_box = np.flatnonzero(_is_within_box(nodes, points[low], ADVECTION_CUTOFF_RATIO * width).all(axis=1))
        move = np.minimum(clearance - distance[low], MAX_ADVECTION_STEP)[:, None] * normal[low]
        square = ((nodes[inside_box, None] - points[low]) ** 2).sum(axis=2)
        nearness = np.exp(-0.5 * square / width**2) * (square < (ADVECTION_CUTOFF_RATIO * width) ** 2)
        share = nearness.max(axis=1) / np.maximum(nearness.sum(axis=1), 1e-300)
        moved = nodes.copy()
        moved[inside_box] += share[:, None] * (nearness @ move)
        _undo_new_crossings(moved, nodes, faces)
        displaced = (moved != nodes).any(axis=1)
        if not displaced.any():
            break
        nodes = moved
        again = np.flatnonzero(np.concatenate([displaced, displaced[faces].any(axis=1)]))
        points = np.concatenate([nodes, nodes[faces].mean(axis=1)])
        distance[again], normal[again] = (values[: len(again)] for values in body.measure(points[again]))
    return nodes


def _undo_new_crossings(moved: np.ndarray, before: np.ndarray, faces: np.ndarray) -> None:
    """Undo, in place, moves that make faces cross; only faces near the moved ones are checked."""
    displaced = (moved != before).any(axis=1)[faces].any(axis=1)
    if not displaced.any():
        return
    corners = np.concatenate([moved[faces[displaced]], before[faces[displaced]]]).reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    least, most = face_boxes(before, faces)
    around = (most >= low).all(axis=1) & (least <= high).all(axis=1)
    checked = faces[around | displaced]
    undo_crossings(moved, before, checked, self_intersections(before, checked))


def _is_within_box(points: np.ndarray, others: np.ndarray, reach: float) -> np.ndarray:
    """Find which coordinates of points are within the bounding box of others, widened by a margin [m], shape [n, 3]."""
    return np.asarray((points >= others.min(axis=0) - reach) & (points <= others.max(axis=0) + reach))
