"""A sewing pattern: flat panels bounded by lines and curves, and the seams that join their edges, without a mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

__all__ = ["Edge", "EdgeRef", "Panel", "Pattern", "Seam"]


@dataclass(frozen=True)
class Edge:
    """Describe the curve from control point i of a panel to control point i + 1. Handles are relative: (along, across),
    in units of the chord, across to the left of it (thesis eq. 3.1), so that an edge follows its two control points by
    a similarity and keeps its kind.

    Attributes:
        kind: `line`, `quadratic` (one handle), `cubic` (two) or `arc` (one handle: the apex, along = 0.5).
        handles: Relative coordinates of the handles, shape [handle_count, 2].
        label: The author's label, or an empty text.
        contour: Name of the sewn garment's open contour with this edge (`hem`, `cuff.left`, ...), or an empty text.
    """

    kind: str = "line"
    handles: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    label: str = ""
    contour: str = ""


@dataclass(frozen=True)
class Panel:
    """Describe one flat piece of cloth.

    Attributes:
        name: Unique in the pattern.
        points: Control points (corners and joins) [m], counter-clockwise from the cloth's outside, shape [n, 2].
        edges: n edges; edge i joins point i to point (i + 1) % n.
        rotation: Turns panel axes into the world's (first drape), shape [3, 3]; rotation[:, 2] is the outward normal.
        translation: Position of the panel's origin [m], shape [3].
        grainline: Angle of the warp from the panel's +y [rad].
        label: The author's label (`body`, `leg`, ...), or an empty text.
        mirrored: True for a panel that is clockwise in the file: import and export mirror it (x to -x).
        notches: (edge index, fraction of its length) of each notch.
    """

    name: str
    points: np.ndarray
    edges: tuple[Edge, ...]
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    translation: np.ndarray = field(default_factory=lambda: np.zeros(3))
    grainline: float = 0.0
    label: str = ""
    mirrored: bool = False
    notches: tuple[tuple[int, float], ...] = ()

    def __repr__(self) -> str:
        """Return one line; the arrays are its attributes."""
        return f"<Panel {self.name}: {len(self.edges)} edges>"


@dataclass(frozen=True)
class EdgeRef:
    """Describe one edge of a pattern by panel and number."""

    panel: str
    edge: int


@dataclass(frozen=True)
class Seam:
    """Describe the seam of two edges.

    Attributes:
        reversed: True (the rule for two outward counter-clockwise panels) where a's start meets b's end.
        gathered: True where the sides' lengths are meant to differ (ratio outside 1 +- 0.03 in the template).
    """

    a: EdgeRef
    b: EdgeRef
    reversed: bool = True
    gathered: bool = False


@dataclass(frozen=True)
class Pattern:
    """Describe the panels and seams of one garment.

    Attributes:
        name: For display.
        panels: The panels, in the author's order.
        category: One of `target.CATEGORIES`, or an empty text where it is unknown.
        extra: Unknown keys of its file (parameters, properties), kept for export.
        symmetric: False for independent left and right sides: `find_symmetry` then finds nothing.
    """

    name: str
    panels: tuple[Panel, ...]
    seams: tuple[Seam, ...]
    category: str = ""
    extra: dict[str, Any] = field(default_factory=dict)
    symmetric: bool = True

    def __repr__(self) -> str:
        """Return one line; the arrays are its attributes."""
        return f"<Pattern {self.name}: {len(self.panels)} panels, {len(self.seams)} seams>"

    def panel(self, name: str) -> Panel:
        """Return a panel by name.

        Raises:
            KeyError: where there is none.
        """
        for panel in self.panels:
            if panel.name == name:
                return panel
        raise KeyError(name)

    @property
    def points(self) -> np.ndarray:
        """Return all control points [m], panel after panel, shape [point_count, 2]."""
        return np.concatenate([panel.points for panel in self.panels])

    @cached_property
    def first_points(self) -> dict[str, int]:
        """Return the index in `points` of each panel's first control point, by the panel's name."""
        return {panel.name: int(at) for panel, at in zip(self.panels, self.point_starts, strict=False)}

    @cached_property
    def gathered(self) -> np.ndarray:
        """Return which seams are gathered, shape [seam_count]."""
        return np.array([seam.gathered for seam in self.seams], dtype=bool)

    def ends_of(self, edge: EdgeRef) -> tuple[int, int]:
        """Return the indices in `points` of the control points at which an edge begins and ends."""
        first, count = self.first_points[edge.panel], len(self.panel(edge.panel).points)
        return first + edge.edge, first + (edge.edge + 1) % count

    @property
    def point_starts(self) -> np.ndarray:
        """Return the index in `points` of each panel's first control point, and the total, shape [panel_count + 1]."""
        return np.cumsum([0] + [len(panel.points) for panel in self.panels])

    def with_points(self, points: np.ndarray | Mapping[str, np.ndarray]) -> Pattern:
        """Return the pattern with its control points moved; curves follow their chords.

        Args:
            points: All control points [m], shape [point_count, 2] as in `points`, or those of some panels by name.
        """
        if isinstance(points, Mapping):
            moved = [np.asarray(points.get(panel.name, panel.points), float) for panel in self.panels]
        else:
            moved = np.split(np.asarray(points, float), self.point_starts[1:-1])
        if any(new.shape != panel.points.shape for new, panel in zip(moved, self.panels, strict=True)):
            raise ValueError("points have another shape than the pattern's control points")
        pairs = zip(self.panels, moved, strict=True)
        return replace(self, panels=tuple(replace(panel, points=new) for panel, new in pairs))
