"""The mesh of a sewn pattern: one topology for drape, simulation mesh and detail mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..scan.contours.target import Contour
from .pattern import EdgeRef, Pattern

__all__ = ["Garment"]


@dataclass(frozen=True)
class Garment:
    """Describe the sewn mesh of a pattern. The rest shape of face f is always the flat triangle uv[uv_faces[f]], never
    a placed or draped one.

    Attributes:
        nodes: Present 3D positions [m], shape [node_count, 3].
        faces: Node indices, outward, shape [face_count, 3].
        uv: Flat positions in each panel's own axes [m], shape [uv_count, 2].
        uv_faces: Indices into `uv`, corner for corner as `faces`, shape [face_count, 3].
        uv_node: Node of each uv vertex (many to one along seams), shape [uv_count].
        panel_of_face: Index into pattern.panels, shape [face_count].
        panel_of_uv: Index into pattern.panels, shape [uv_count].
        edge_uv: For each pattern edge, the uv vertices along it from start to end, both included.
        contours: Named open contours as loops of nodes; empty until they are named on a body.
    """

    pattern: Pattern
    nodes: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    uv_faces: np.ndarray
    uv_node: np.ndarray
    panel_of_face: np.ndarray
    panel_of_uv: np.ndarray
    edge_uv: dict[EdgeRef, np.ndarray]
    contours: tuple[Contour, ...] = ()

    def __repr__(self) -> str:
        """Return one line; the arrays are its attributes."""
        return f"<Garment {self.pattern.name}: {len(self.nodes)} nodes, {len(self.faces)} faces>"

    @property
    def rest(self) -> np.ndarray:
        """Return the flat rest triangles [m], shape [face_count, 3, 2]."""
        found: np.ndarray = self.uv[self.uv_faces]
        return found

    def at(self, nodes: np.ndarray, contours: tuple[Contour, ...] | None = None) -> Garment:
        """Return the same garment with its nodes at other positions [m], shape [node_count, 3]."""
        return replace(self, nodes=nodes, contours=self.contours if contours is None else contours)

    def contour(self, name: str) -> Contour | None:
        """Find a contour by name, or None."""
        return next((c for c in self.contours if c.name == name), None)
