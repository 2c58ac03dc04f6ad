"""Find pattern files whose stretch has to be removed before grading."""

from __future__ import annotations

import numpy as np

from ...garment.curves import panel_area
from ...garment.pattern import Pattern
from ...garment.sewing import mesh_pattern
from ...scan.contours.loop import find_loops
from ...scan.contours.target import TOP_CATEGORIES
from .stage import DrapeSettings
from .waist import flat_length, waist_loop

MAX_EASED_FLARE_SHARE = 0.7
"""Share of a full circle from which a skirt is not eased: under little weight it floats. Half circles have 0.5."""


def needs_easing(pattern: Pattern, category: str) -> bool:
    """Check whether a pattern file, unless eased, is worn too long with its seams too low (ADR 0056).

    Tops are not: they have no seam round the trunk and no crotch that could hang too low.

    Args:
        pattern: The base pattern.
        category: Category of the scan.

    Raises:
        MeshTooCoarse: where the pattern cannot be meshed as it is to be dressed.
    """
    if category != "skirt":
        return category not in TOP_CATEGORIES
    # as finely as for dressing: a coarser mesh may be refused
    garment = mesh_pattern(pattern, DrapeSettings().template_vertices, sweeps=0)
    loop = waist_loop(garment)
    if loop is None:
        return True
    waist = flat_length(garment, loop)
    hem = sum(flat_length(garment, other) for other in find_loops(garment.faces)) - waist
    return find_flare(hem, waist, sum(map(panel_area, pattern.panels))) < MAX_EASED_FLARE_SHARE


def find_flare(hem: float, waist: float, area: float) -> float:
    """Return the share of a full circle as which a skirt of some lengths [m] and area [m2] is cut.

    For a ring's sector f with radii r and R, hem - waist = 2 pi f (R - r) and area = (hem + waist) (R - r) / 2.
    """
    return (hem - waist) * (hem + waist) / (4.0 * np.pi * area)
