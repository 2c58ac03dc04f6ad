"""The pattern whose flat panels have the metric of the registered mesh: no simulation (numerics 1)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..grade import FlatteningSettings, GradeSettings, fit_control_points, step_without_folds, stretch_between
from ..pattern import Garment, Pattern, map_controls


def refit_pattern(
    garment: Garment, registered: np.ndarray, settings: FlatteningSettings | None = None
) -> tuple[Garment, float]:
    """Refit a draped garment's pattern to its registered mesh.

    Every flat face is asked to stretch as its 3D face did from the drape to the target, as in grading; but the
    registered mesh is the detail mesh, a millimetre from the target, and not the coarse one.

    Args:
        garment: The graded pattern's mesh, nodes at its drape.
        registered: The same nodes on the target [m], shape [node_count, 3].
        settings: Believable strains.

    Returns:
        The garment with its flat mesh moved along and its nodes where they were registered, and the share of the step
        that no panel folded over under.
    """
    stretch = stretch_between(garment, registered, settings)
    points = fit_control_points(garment, stretch, settings)
    pattern, share = step_without_folds(garment.pattern, points, GradeSettings())
    return move_pattern(garment, pattern).at(registered), share


def move_pattern(garment: Garment, pattern: Pattern) -> Garment:
    """Move a garment's flat mesh along with its control points; faces and nodes stay."""
    uv = garment.uv + map_controls(garment).apply(pattern.points - garment.pattern.points)
    return replace(garment, pattern=pattern, uv=uv)
