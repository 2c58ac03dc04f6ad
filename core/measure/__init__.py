"""Metrics, quality gates and the report."""

from .chamfer import chamfer_and_normals
from .contours import carry_contours
from .damage import DAMAGES, Damage
from .fit import Reference, measure_distance, measure_fit
from .gates import PRODUCTS, judge, overall, product_of
from .knowledge import measure_knowledge
from .matching import PanelPair, is_same_cut, match_panels
from .packs import Pack, read_packs, read_true_mesh, read_true_pattern
from .patterns import (
    PATTERN_METRICS,
    measure_panels,
    measure_pattern,
    measure_seams,
    unmatched_panels,
)
from .true_pattern import TruePanel, TruePattern, TrueSeam
from .truth import measure_fabric, measure_recovery
from .turning import turning_distance

__all__ = [
    "DAMAGES",
    "PATTERN_METRICS",
    "PRODUCTS",
    "Damage",
    "Pack",
    "PanelPair",
    "Reference",
    "TruePanel",
    "TruePattern",
    "TrueSeam",
    "carry_contours",
    "chamfer_and_normals",
    "is_same_cut",
    "judge",
    "match_panels",
    "measure_distance",
    "measure_fabric",
    "measure_fit",
    "measure_knowledge",
    "measure_panels",
    "measure_pattern",
    "measure_recovery",
    "measure_seams",
    "overall",
    "product_of",
    "read_packs",
    "read_true_mesh",
    "read_true_pattern",
    "turning_distance",
    "unmatched_panels",
]
