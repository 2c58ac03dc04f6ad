"""Sewing patterns: panels, seams, control points, meshing and sewing."""

from .curves import edge_length, edge_points, outline, panel_area, reverse_edge, split_edge
from .garment import Garment
from .garmentcode import load_pattern, read_pattern, save_pattern, write_pattern
from .meshing import choose_edge_length
from .pattern import EDGE_KINDS, Edge, EdgeRef, Panel, Pattern, Seam
from .sewing import mesh_pattern

__all__ = [
    "EDGE_KINDS",
    "Edge",
    "EdgeRef",
    "Garment",
    "Panel",
    "Pattern",
    "Seam",
    "choose_edge_length",
    "edge_length",
    "edge_points",
    "load_pattern",
    "mesh_pattern",
    "outline",
    "panel_area",
    "read_pattern",
    "reverse_edge",
    "save_pattern",
    "split_edge",
    "write_pattern",
]
