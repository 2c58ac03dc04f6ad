"""Metrics, quality gates and the report."""

from .chamfer import VertexCloud, chamfer_and_normals
from .comparison import Comparison, PanelDifference, compare_patterns
from .contour_shape import measure_contour_shapes
from .contours import transfer_contours
from .damage import DAMAGES, Damage
from .fairness import measure_fairness
from .fit import Reference, measure_distance, measure_fit
from .gates import Product, evaluate_gates, product_of
from .knowledge import summarise_estimates
from .matching import PanelPair, is_same_cut, match_panels
from .packs import Pack, find_packs, is_raw_pack, read_mesh_file, read_packs, read_true_mesh, read_true_pattern
from .patterns import (
    PATTERN_METRICS,
    measure_panels,
    measure_pattern,
    measure_seams,
    unmatched_panels,
)
from .plausibility import measure_plausibility
from .raw_borders import BorderScore, find_edges, measure_borders
from .raw_file import RawFile, read_raw_file, write_raw_file
from .raw_frame import TruthFrame, find_frame
from .raw_labels import Calibration, LabelScore, measure_calibration, measure_labels
from .raw_outcome import Outcome, judge_outcome
from .raw_packs import (
    RawPack,
    TrueGarment,
    read_cover,
    read_garment_pattern,
    read_raw_packs,
    read_true_labels,
    read_visible,
)
from .raw_shape import BodyScore, VisibleScore, measure_true_body, measure_visible
from .raw_states import SCAN_STATES, ScanState, degrade_scan
from .true_pattern import TruePanel, TruePattern, TrueSeam
from .turning import turning_distance
from .wear import measure_upright, measure_wear

__all__ = [
    "DAMAGES",
    "PATTERN_METRICS",
    "SCAN_STATES",
    "BodyScore",
    "BorderScore",
    "Calibration",
    "Comparison",
    "Damage",
    "LabelScore",
    "Outcome",
    "Pack",
    "PanelDifference",
    "PanelPair",
    "Product",
    "RawFile",
    "RawPack",
    "Reference",
    "ScanState",
    "TrueGarment",
    "TruePanel",
    "TruePattern",
    "TrueSeam",
    "TruthFrame",
    "VertexCloud",
    "VisibleScore",
    "chamfer_and_normals",
    "compare_patterns",
    "degrade_scan",
    "evaluate_gates",
    "find_edges",
    "find_frame",
    "find_packs",
    "is_raw_pack",
    "is_same_cut",
    "judge_outcome",
    "match_panels",
    "measure_borders",
    "measure_calibration",
    "measure_contour_shapes",
    "measure_distance",
    "measure_fairness",
    "measure_fit",
    "measure_labels",
    "measure_panels",
    "measure_pattern",
    "measure_plausibility",
    "measure_seams",
    "measure_true_body",
    "measure_upright",
    "measure_visible",
    "measure_wear",
    "product_of",
    "read_cover",
    "read_garment_pattern",
    "read_mesh_file",
    "read_packs",
    "read_raw_file",
    "read_raw_packs",
    "read_true_labels",
    "read_true_mesh",
    "read_true_pattern",
    "read_visible",
    "summarise_estimates",
    "transfer_contours",
    "turning_distance",
    "unmatched_panels",
    "write_raw_file",
]
