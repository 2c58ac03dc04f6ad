"""Metrics, quality gates and the report."""

from .contours import carry_contours
from .damage import DAMAGES, Damage
from .fit import measure_distance, measure_fit
from .gates import judge, overall
from .intersections import self_intersections
from .packs import Pack, read_packs, read_true_mesh, read_true_pattern
from .patterns import (
    PATTERN_METRICS,
    TruePanel,
    TruePattern,
    TrueSeam,
    measure_panels,
    measure_pattern,
    measure_seams,
    unmatched_panels,
)
from .surface import closest_points, penetration_depth
from .truth import measure_recovery
from .turning import turning_distance

__all__ = [
    "DAMAGES",
    "PATTERN_METRICS",
    "Damage",
    "Pack",
    "TruePanel",
    "TruePattern",
    "TrueSeam",
    "carry_contours",
    "closest_points",
    "judge",
    "measure_distance",
    "measure_fit",
    "measure_panels",
    "measure_pattern",
    "measure_recovery",
    "measure_seams",
    "overall",
    "penetration_depth",
    "read_packs",
    "read_true_mesh",
    "read_true_pattern",
    "self_intersections",
    "turning_distance",
    "unmatched_panels",
]
