"""Define the simulated scene of a fit: one mesh whose rest shape and fabric follow from parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...cloth.fabric import Fabric
from ...garment.control import map_controls
from ...garment.errors import PanelCrossing, PanelDegenerate
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...garment.symmetry import Symmetry, find_symmetry
from ...garment.validity import check_outline
from ...geometry.geometry import signed_areas
from .locks import restore_locked

if TYPE_CHECKING:
    from ...body.distance import DistanceGrid
    from ...cloth.derivative import FactoredEquilibrium
    from ...cloth.parameters import Parameters
    from ...cloth.scene import Scene
    from ...geometry.linear import Solver


@dataclass(frozen=True)
class FitScene:
    """Describe the cloth of a fit and its scene as a function of the parameters' difference from the first pattern's.

    Parameters are the effective control points x0, y0, x1, ... [m], then logarithms of the fitted fabric parameters.

    Attributes:
        garment: The mesh of the first pattern, contours named; nodes where the fit starts.
        base: The template, which gives symmetry and the ratios of gathered seams.
        first: The scene of the first pattern.
        parameters: The derivatives of rest shape and fabric.
        solver: Solver analysed for the mesh, for derivatives.
        preconditioner: The same in single precision, for descent.
        locked: Which effective coordinates stay, shape [shape_count].
    """

    garment: Garment
    base: Pattern
    first: Scene
    parameters: Parameters
    solver: Solver
    preconditioner: Solver
    locked: np.ndarray

    @classmethod
    def of(
        cls,
        garment: Garment,
        base: Pattern,
        scene: Scene,
        fabric: tuple[str, ...] = (),
        locked: np.ndarray | None = None,
    ) -> FitScene:
        """Prepare the fit of a garment's pattern in a scene of its mesh.

        Args:
            garment: The first pattern's mesh, contours named, nodes where the fit starts.
            base: The template.
            scene: The scene of the garment's own topology.
            fabric: Names of fabric parameters that are fitted, too.
            locked: Which effective coordinates stay, shape [shape_count]; None where none does.
        """
        from ...cloth.parameters import Parameters
        from ...cloth.solver import make_solver

        symmetry = find_symmetry(base)
        parameters = Parameters.of_garment(garment, map_controls(garment), symmetry, fabric)
        none = np.zeros(symmetry.matrix.shape[1], dtype=bool)
        solver = make_solver(scene.topology.pattern)
        return cls(garment, base, scene, parameters, solver, solver.in_single(), none if locked is None else locked)

    @property
    def symmetry(self) -> Symmetry:
        """Return the template's symmetry."""
        return find_symmetry(self.base)

    @property
    def fabric(self) -> Fabric:
        """Return the initial cloth."""
        return self.first.fabric

    def with_fabric(self, fabric: Fabric) -> FitScene:
        """Return the scene with another initial cloth."""
        return replace(self, first=replace(self.first, fabric=fabric))

    def with_body(self, body: DistanceGrid) -> FitScene:
        """Return the scene with another body."""
        return replace(self, first=replace(self.first, body=body))

    def with_fixed_folds(self) -> FitScene:
        """Return the scene with bending friction that keeps the folds at the start of the fit."""
        from ...cloth.bending_friction import BendingFriction

        friction = BendingFriction.at(self.first.topology, self.garment.nodes)
        return replace(self, first=replace(self.first, bending_friction=friction))

    def effective(self, pattern: Pattern) -> np.ndarray:
        """Return the effective control points x0, y0, x1, ... of a pattern [m], shape [shape_count]."""
        return self.symmetry.reduce(pattern.points).ravel()

    def at(self, delta: np.ndarray) -> Scene:
        """Return the scene at a difference from the first parameters, shape [p]."""
        return self.parameters.move(self.first, delta)

    def linearise(self, delta: np.ndarray, nodes: np.ndarray, anchors: np.ndarray) -> FactoredEquilibrium:
        """Return the derivative of the drape at nodes and friction's anchors [m], [node_count, 3] each."""
        from ...cloth.derivative import linearise_at

        return linearise_at(self.at(delta), nodes, anchors, self.solver)

    def with_locks(self, pattern: Pattern) -> Pattern:
        """Return a pattern with its locked coordinates restored."""
        return restore_locked(pattern, self.garment.pattern, self.base, self.locked) if self.locked.any() else pattern

    def is_sound(self, pattern: Pattern, least: float = 0.0) -> bool:
        """Check that no panel folds over, and that every triangle of the mesh keeps more than a share of its area."""
        try:
            for panel in pattern.panels:
                check_outline(panel)
        except (PanelCrossing, PanelDegenerate):
            return False
        return self.least_share(pattern) > least

    def least_share(self, pattern: Pattern) -> float:
        """Compute the smallest ratio of a flat triangle's area to its initial area; negative where one turned over."""
        mesh = self.garment
        moved = mesh.uv + map_controls(mesh).apply(pattern.points - mesh.pattern.points)
        return float((signed_areas(moved[mesh.uv_faces]) / signed_areas(mesh.rest)).min())
