"""The upper edge of a skirt, by what it is sewn to."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..outline import Point, Stroke, cut_stroke
from .shaping import label_pieces


@dataclass(frozen=True)
class UpperEdge:
    """Describe a skirt's upper edge.

    Attributes:
        name: Label of its seam; empty where the edge is open.
        quarter: Length of a quarter of the edge it is sewn to [m].
        height: Above the feet [m].
        shares: Of that quarter, between its cuts, from the middle to the side.
    """

    name: str
    quarter: float
    height: float
    shares: tuple[float, ...] = (1.0,)

    def labels(self, face: str) -> list[str]:
        """Return the labels of the pieces of the left half of a face, from the middle to the side."""
        return label_pieces(self.name, face, len(self.shares))

    def strokes(self, face: str, start: Point, stroke: Stroke) -> list[Stroke]:
        """Return a stroke that begins at the side seam [m] as half of the edge, divided as the edge it is sewn to."""
        if not self.name:
            return [replace(stroke, contour="waist")]
        *sides, middle = self.labels(face)[::-1]
        found, left = [], 1.0
        for share, label in zip(self.shares[:0:-1], sides, strict=True):
            piece, stroke = cut_stroke(start, stroke, share / left, (label, ""))
            found.append(piece)
            start, left = piece.end, left - share
        return [*found, replace(stroke, label=middle)]
