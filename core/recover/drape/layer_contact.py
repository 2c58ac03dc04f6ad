"""Keep layers of cloth apart during position-based steps: by planes between them, and by undoing steps that cross."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.intersections import self_intersections, undo_crossings
from .layers import HalfSpaces, find_layer_constraints


@dataclass(frozen=True)
class LayerContact:
    """Describe how layers of cloth are kept apart.

    Attributes:
        face_centres: Keep centres of faces out of the body too; off for a body that is measured at nodes only.
        partial_steps: Let layers that would cross move as far as they have room; otherwise their steps are undone.
        gap: Distance between two layers of cloth [m]; half the thickness, so that two fit between touching limbs.
        reach: Distance up to which pairs of layers are found [m]; longer steps that cross are undone.
        push: Largest push of the body on a node in a step [m]; below half the reach, so that layers above are found.
    """

    face_centres: bool = True
    partial_steps: bool = False
    gap: float = 2e-3
    reach: float = 10e-3
    push: float = 4e-3

    def begin(self, nodes: np.ndarray, faces: np.ndarray, edges: np.ndarray) -> LayerTracker:
        """Return a tracker for a mesh with nodes [m], shape [node_count, 3]; faces that cross at first may stay so."""
        return LayerTracker(self, faces, edges, self_intersections(nodes, faces), HalfSpaces.none())


@dataclass
class LayerTracker:
    """Track the layers of one cloth from step to step.

    Attributes:
        settings: Distances.
        faces: The mesh, shape [face_count, 3].
        edges: Its edges, each once, shape [edge_count, 2].
        crossed: Faces that cross others, after the last step.
        between: Constraints that keep the layers apart in this step.
    """

    settings: LayerContact
    faces: np.ndarray
    edges: np.ndarray
    crossed: np.ndarray
    between: HalfSpaces

    def planes(self, nodes: np.ndarray) -> HalfSpaces:
        """Return the constraints that keep the layers apart in a step from nodes [m], shape [node_count, 3]."""
        chosen = self.settings
        self.between = find_layer_constraints(nodes, self.faces, self.edges, self.crossed, chosen.gap, chosen.reach)
        return self.between

    def finish(self, nodes: np.ndarray, before: np.ndarray) -> None:
        """Shorten, in place, the moves of a step that cross; both positions [m], shape [node_count, 3]."""
        room = self.between.room(before, self.settings.reach) if self.settings.partial_steps else None
        self.crossed = undo_crossings(nodes, before, self.faces, self.crossed, room)
