"""Untangle cloth that starts crossed, before its contact is on."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...geometry.intersections import intersecting_pairs
from ...geometry.untangling import contract_contours

if TYPE_CHECKING:
    from ..scene import Scene

CONTOUR_CONTRACTION_FORCE = 0.1
"""Force that contracts a contour of intersection [N]: about 200 weights of a node of 4000. A fold yields to it, the
membrane (300 N/m) does not."""


def contract_crossings(scene: Scene, nodes: np.ndarray) -> tuple[Scene, np.ndarray | None]:
    """Switch contact off where faces cross at nodes [m], and contract the contours along which they cross.

    Returns:
        The scene with contact off for crossed faces, and the force on each node [N], shape [node_count, 3], or None
            where none cross.
    """
    cloth = scene.self_contact
    if cloth is None:
        return scene, None
    pairs = intersecting_pairs(nodes, cloth.faces)
    waiting = cloth.wait(np.unique(pairs))
    scene = scene if waiting is cloth else replace(scene, self_contact=waiting)
    if not len(pairs):
        return scene, None
    return scene, CONTOUR_CONTRACTION_FORCE * contract_contours(nodes, cloth.faces, pairs)


def is_resolving(counts: list[int], patience: int) -> bool:
    """Return whether fewer faces cross than before the last `patience` rounds; `counts` of every round so far."""
    return counts[-1] > 0 and (len(counts) <= patience or counts[-1] < min(counts[:-patience]))
