"""The flat mesh that belongs to a moved pattern."""

from __future__ import annotations

from dataclasses import replace

from ..pattern import Garment, Pattern, map_controls


def move_pattern(garment: Garment, pattern: Pattern) -> Garment:
    """Move a garment's flat mesh along with its control points; faces and nodes stay."""
    uv = garment.uv + map_controls(garment).apply(pattern.points - garment.pattern.points)
    return replace(garment, pattern=pattern, uv=uv)
