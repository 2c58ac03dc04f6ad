"""Measure how well the seams of a pattern fit."""

from __future__ import annotations

from ..garment.curves import edge_length
from ..garment.pattern import Pattern
from ..run.units import MM_PER_M


def measure_seams(pattern: Pattern) -> dict[str, float | None]:
    """Measure `seam_mismatch_mm`, the largest difference in length of the two sides of an ungathered seam."""
    sides = [(seam.a, seam.b) for seam in pattern.seams if not seam.gathered]
    lengths = [[edge_length(pattern.panel(side.panel), side.edge) for side in both] for both in sides]
    gaps = [abs(a - b) for a, b in lengths]
    return {"seam_mismatch_mm": MM_PER_M * max(gaps) if gaps else None}
