"""Sewing patterns: panels, seams, control points, meshing and sewing."""

from .garment import Garment
from .pattern import EDGE_KINDS, Edge, EdgeRef, Panel, Pattern, Seam

__all__ = ["EDGE_KINDS", "Edge", "EdgeRef", "Garment", "Panel", "Pattern", "Seam"]
