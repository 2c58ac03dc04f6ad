"""Name the open edges of a pattern by the contours of its sewn garment on a body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .garment import Garment
from .pattern import EdgeRef, Pattern

MIN_CONTOUR_SHARE = 0.5
"""Smallest share of an edge's nodes on a contour of which the edge is a part; its ends may be on two."""


def name_open_edges(garment: Garment) -> Pattern:
    """Return the pattern of a garment whose open edges without a name have that of the contour they lie on. A file
    from elsewhere does not say what is hem, neck or cuff; the garment on its wearer shows it."""
    sewn = {ref for seam in garment.pattern.seams for ref in (seam.a, seam.b)}
    panels = []
    for panel in garment.pattern.panels:
        edges = []
        for i, edge in enumerate(panel.edges):
            ref = EdgeRef(panel.name, i)
            named = edge.contour or ref in sewn
            edges.append(edge if named else replace(edge, contour=_find_contour(garment, ref)))
        panels.append(replace(panel, edges=tuple(edges)))
    return replace(garment.pattern, panels=tuple(panels))


def _find_contour(garment: Garment, ref: EdgeRef) -> str:
    """Return the name of the contour that most nodes of an open edge are on; an empty text where there is none."""
    nodes = garment.uv_node[garment.edge_uv[ref]]
    shares = {contour.name: float(np.isin(nodes, contour.vertices).mean()) for contour in garment.contours}
    name = max(shares, key=shares.__getitem__, default="")
    return name if shares.get(name, 0.0) > MIN_CONTOUR_SHARE else ""
