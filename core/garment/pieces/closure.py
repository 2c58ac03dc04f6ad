"""Find the edges of a pattern at which the garment is closed when it is worn."""

from __future__ import annotations

from ..pattern import EdgeRef, Pattern
from .piece import CLOSURE_EDGE_USES, EdgeUse

CLOSED_PARTS = ("front", "cuff")
"""First words of the labels of edges that can be opened."""


def find_closure(pattern: Pattern, ref: EdgeRef) -> EdgeUse | None:
    """Return what closes a sewn edge, by its label (`front.zip.front`, `cuff.buttons.left`); None for an ordinary
    seam."""
    words = pattern.panel(ref.panel).edges[ref.edge].label.split(".")
    return next((use for use in CLOSURE_EDGE_USES if words[0] in CLOSED_PARTS and str(use) in words[1:2]), None)
