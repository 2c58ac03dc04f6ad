"""What one may choose about the inverse fit; every default says why."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..simulate import SimulateSettings


@dataclass(frozen=True)
class ShapeSettings:
    """Set the fit of the pattern through the simulator.

    Attributes:
        vertices: Vertices of the mesh that the fit runs on; 1500 are at equilibrium in under 1 s and resolve folds of
            5 cm.
        iterations: Gauss-Newton iterations; on the patterns tried nothing was gained after six.
        trials: Steps tried in one iteration, each with ten times the damping of the one before.
        damping: First damping, relative to the diagonal of the Gauss-Newton matrix (Marquardt).
        plateau: Gain in the objective below which the fit stops; 0.1 is a tenth of what one control point that moves
            by `spread` costs twice over: nothing that a scan tells.
        slide: Cost of sliding within the surface as a share of leaving it; registration finds the surface to 1 mm and
            the place on it to about a centimetre.
        spread: Standard deviation of the control points around the pattern from the metric [m]; its outlines were
            6 to 29 mm from the truth.
        observations: How many independent things a drape tells. Thousands of nodes share a few dozen folds and girths;
            30 keeps a drape that hangs in other folds from bending the pattern to them.
        simulate: The equilibria of the fit. They start next to each other, so 60 iterations suffice.
    """

    vertices: int = 1500
    iterations: int = 6
    trials: int = 4
    damping: float = 1e-2
    plateau: float = 0.1
    slide: float = 0.1
    spread: float = 0.01
    observations: float = 30.0
    simulate: SimulateSettings = field(default_factory=lambda: SimulateSettings(max_iterations=60))
