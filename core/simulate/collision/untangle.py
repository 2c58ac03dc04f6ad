"""Take cloth that starts crossed out of itself, before contact can keep it apart."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...mesh import find_components, intersecting_pairs, measure_contour

if TYPE_CHECKING:
    from ..scene import Scene

TENSION = 0.1
"""Force with which a contour of intersection contracts [N]: some 200 weights of a node of 4000, which a fold gives way
to and the membrane (300 N/m) does not."""

_SHARP = 3.0
"""Most of a contour's gradient that one node takes: regular ones have 1 to 2, edges that graze a face 20."""


def pull_apart(scene: Scene, nodes: np.ndarray) -> tuple[Scene, np.ndarray | None]:
    """Let contact wait where faces cross at nodes [m], and contract the contours along which they do.

    Returns:
        The scene whose self-contact waits for the faces that cross, and the force on each node [N], shape
        [node_count, 3], or None where none do.
    """
    cloth = scene.self_contact
    if cloth is None:
        return scene, None
    pairs = intersecting_pairs(nodes, cloth.faces)
    waiting = cloth.wait(np.unique(pairs))
    scene = scene if waiting is cloth else replace(scene, self_contact=waiting)
    if not len(pairs):
        return scene, None
    return scene, -TENSION * (_soften(measure_contour(nodes, cloth.faces, pairs)[1]) + _part(cloth.faces, nodes, pairs))


def _soften(gradient: np.ndarray) -> np.ndarray:
    """Shorten each row of a gradient to `_SHARP`."""
    size = np.sqrt((gradient**2).sum(1, keepdims=True))
    return np.asarray(gradient * np.minimum(1.0, _SHARP / np.maximum(size, _SHARP)))


def _part(faces: np.ndarray, nodes: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Return how each patch of faces that cross others is to be moved as a whole, shape [node_count, 3], 1 at most.

    Two layers that have gone through each other along a lens meet along a long narrow contour, whose own gradient
    shortens it from both tips alone. Its sum over one layer is how the contour's length follows that layer's motion as
    a whole: out of the other one, across the lens. Contours of a patch with itself have no such sum.
    """
    corners = faces[np.unique(pairs)]
    _, patch = find_components(len(nodes), corners.ravel(), np.roll(corners, 1, axis=1).ravel())
    between = patch[faces[pairs[:, 0], 0]] != patch[faces[pairs[:, 1], 0]]
    gradient, crossed = measure_contour(nodes, faces, pairs[between])[1], np.unique(corners)
    sums = np.zeros_like(gradient)
    np.add.at(sums, patch[crossed], gradient[crossed])
    sums /= np.maximum(np.sqrt((sums**2).sum(1, keepdims=True)), 1.0)
    found = np.zeros_like(gradient)
    found[crossed] = sums[patch[crossed]]
    return found


def is_resolving(counts: list[int], patience: int) -> bool:
    """Return whether fewer faces cross than before the last rounds; `counts` of every round so far."""
    return counts[-1] > 0 and (len(counts) <= patience or counts[-1] < min(counts[:-patience]))
