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
        spread: Standard deviation of the control points around the pattern from the metric [m]. The metric
            alone finds a T-shirt of our own to 0.3 % in area; through the simulator it came out 1.0 % off with 5 mm and
            0.8 with 3 mm, its drape 0.1 mm further from the target: more and the pattern answers for the simulator.
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
    spread: float = 0.003
    observations: float = 30.0
    simulate: SimulateSettings = field(default_factory=lambda: SimulateSettings(max_iterations=60))


@dataclass(frozen=True)
class MaterialSettings:
    """Set the search for the cloth's bending stiffness.

    Attributes:
        values: Values of k / density tried over the range, evenly in the logarithm: 7 are a factor of 4 apart, and two
            more beside the best sharpen it. Each is one equilibrium of about 1 s.
        below: The range begins so far below the library's softest, as a logarithm; 1.4 is a factor of 4.
        above: And ends so far above its stiffest; 4.1 is a factor of 60, assumed: chosen so that a very stiff skirt,
            whose folding was seen first, lies within the range, just at its end.
        widen: The library's standard deviation counts times this as the prior's: its 19 fabrics are not all
            there are.
        folding_spread: Standard deviation of the logarithm of the target's folding; a quarter is assumed for what
            another simulator, registration and meshing change, and was not measured.
        least_std: Smallest standard deviation of ln k that is reported: assumed.
    """

    values: int = 7
    below: float = 1.4
    above: float = 4.1
    widen: float = 2.0
    folding_spread: float = 0.25
    least_std: float = 0.1
