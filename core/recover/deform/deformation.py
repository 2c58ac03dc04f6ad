"""Describe the result of the deformer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Deformation:
    """Describe the detail mesh and how it was reached.

    Attributes:
        nodes: Deformed positions [m], order of the garment's nodes, shape [node_count, 3].
        iterations: Steps that Adam took.
        losses: Weighted loss terms by name, one value per iteration; `total` is their sum.
        polished: Whether the polish was kept.
        matched: Names of the contours that were matched.
        normals_reversed: Whether the vote reversed the target's normals.
        normals_unsigned: Whether only the normals' axes were used, because their signs are inconsistent.
        spikes: Target vertices that were moved to the median of their ring.
        flipped_faces: Faces against the target's normal at the closest point, (graded drape, result).
        self_intersecting_faces: Faces in a non-adjacent intersecting pair, (graded drape, result).
        body_depth: Largest depth of a node or face centre inside the exact body [m], 0 where there is none.
        warnings: Warnings to the user, one sentence each.
    """

    nodes: np.ndarray
    iterations: int
    losses: dict[str, np.ndarray]
    polished: bool
    matched: tuple[str, ...]
    normals_reversed: bool
    normals_unsigned: bool
    spikes: int
    flipped_faces: tuple[int, int]
    self_intersecting_faces: tuple[int, int]
    body_depth: float
    warnings: tuple[str, ...] = ()
