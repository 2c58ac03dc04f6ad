"""Sewing patterns: panels, seams, control points, meshing and sewing."""

from .control import ControlMap, map_controls, mean_value_coordinates, update_flat_mesh
from .curves import edge_length, edge_points, flat_contours, panel_area, panel_outline, reverse_edge, split_edge
from .division import divide_edges
from .errors import PatternFault, Place
from .examine import Finding, Severity, examine_file, find_faults
from .fairness import fair_curves, unplanned_corners
from .garment import Garment
from .garmentcode import load_pattern, read_pattern, save_pattern, write_pattern
from .laying import transfer_nodes
from .measures import BodyMeasures
from .meshing import choose_edge_length, points_in_polygon
from .mirrors import Mirror
from .moving import move_by_drafts, scale_panels
from .orientation import place_points
from .pattern import EDGE_KINDS, Edge, EdgeRef, Panel, Pattern, Seam
from .polygon import polygon_area, polygon_width
from .resampling import resample
from .seams import equalise_seams, seam_constraints, seam_lengths, seam_mismatch, seam_ratios, seam_sides
from .sewing import mesh_pattern
from .symmetry import Symmetry, find_symmetry
from .templates import (
    TemplateInfo,
    TemplateUnknown,
    draft_template,
    find_cut,
    list_templates,
    load_draped_template,
    load_template,
    name_cut,
)
from .validity import check_outline

__all__ = [
    "EDGE_KINDS",
    "BodyMeasures",
    "ControlMap",
    "Edge",
    "EdgeRef",
    "Finding",
    "Garment",
    "Mirror",
    "Panel",
    "Pattern",
    "PatternFault",
    "Place",
    "Seam",
    "Severity",
    "Symmetry",
    "TemplateInfo",
    "TemplateUnknown",
    "check_outline",
    "choose_edge_length",
    "divide_edges",
    "draft_template",
    "edge_length",
    "edge_points",
    "equalise_seams",
    "examine_file",
    "fair_curves",
    "find_cut",
    "find_faults",
    "find_symmetry",
    "flat_contours",
    "list_templates",
    "load_draped_template",
    "load_pattern",
    "load_template",
    "map_controls",
    "mean_value_coordinates",
    "mesh_pattern",
    "move_by_drafts",
    "name_cut",
    "panel_area",
    "panel_outline",
    "place_points",
    "points_in_polygon",
    "polygon_area",
    "polygon_width",
    "read_pattern",
    "resample",
    "reverse_edge",
    "save_pattern",
    "scale_panels",
    "seam_constraints",
    "seam_lengths",
    "seam_mismatch",
    "seam_ratios",
    "seam_sides",
    "split_edge",
    "transfer_nodes",
    "unplanned_corners",
    "update_flat_mesh",
    "write_pattern",
]
