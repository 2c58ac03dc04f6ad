"""What one may choose about the inverse fit; every default says why."""

from __future__ import annotations

from dataclasses import dataclass, field

from ...cloth.settings import SolveSettings


@dataclass(frozen=True)
class ShapeSettings:
    """Set the fit of the pattern through the simulator.

    Attributes:
        vertices: Vertices of the mesh that the fit runs on, at most: those of the registered mesh up to 6000, where one
            equilibrium takes 1 s. On 1500 instead two T-shirts of our own came out 1.5 and 2.0 % off in area, not 0.3:
            a coarse mesh cuts its folds short, and the pattern answers for that.
        iterations: Gauss-Newton iterations; what T-shirts and trousers gained after eight moved no point by 1 mm.
        trials: Steps tried in one iteration, each with ten times the damping of the one before. With three the fit of a
            dress stopped at a misfit of 3.2 mm, its hem 18 mm too low; the fourth led on to 2.7.
        damping: First damping, relative to the diagonal of the Gauss-Newton matrix (Marquardt).
        plateau: Gain in the objective, by the number of observations, below which the fit stops: as much as a misfit
            that falls by half a percent. A step that promises less is not tried: on four garments steps gained 0 to 1.6
            times what they promised.
        slide: Cost of sliding within the surface as a share of leaving it: registration finds the surface to 1 mm and
            the place on it to about a centimetre, wrong in one direction all along a seam. With a tenth two T-shirts
            of our own came out 0.9 and 1.2 % off in area, with a hundredth 0.2 and 0.3.
        spread: Standard deviation of the control points around the pattern from the metric [m]: those of two T-shirts
            of our own lay 2.6 and 3.0 mm off in the root mean square, panels of published patterns 4 to 10 mm.
        spread_share: The same by the panel's mean width, where that is less: 2 mm on a waistband of 4 cm, of which no
            scan shows where its long seams lie.
        area_spread: Standard deviation of ln of the area of all panels together around the metric's. Wrinkles that the
            simulated cloth has not are cloth that it has no place for: with the points' spread alone drapes of another
            simulator lost 2 to 3 % of their area while the misfit fell from 4.3 to 2.7 mm; with this 0.3 to 0.5 %, and
            the misfit falls to 3.1 mm.
        solve: The equilibria of the fit. They start next to each other, so 60 iterations suffice.
    """

    vertices: int = 6000
    iterations: int = 8
    trials: int = 6
    damping: float = 1e-2
    plateau: float = 0.005
    slide: float = 0.01
    spread: float = 0.005
    spread_share: float = 0.05
    area_spread: float = 0.003
    solve: SolveSettings = field(default_factory=lambda: SolveSettings(max_iterations=60))


@dataclass(frozen=True)
class MaterialSettings:
    """Set the search for the cloth's bending stiffness.

    Attributes:
        vertices: Vertices of the mesh of the search: 1500 are at equilibrium in under 1 s and resolve folds of 5 cm.
        values: Values of k / density tried over the range, evenly in the logarithm: 7 are a factor of 4 apart, and two
            more beside the best sharpen it. Each is one equilibrium of about 1 s.
        below: The range begins so far below the library's softest, as a logarithm; 1.4 is a factor of 4.
        above: And ends so far above its stiffest; 4.1 is a factor of 60, assumed: chosen so that a very stiff skirt,
            whose folding was seen first, lies within the range, just at its end.
        widen: The library's standard deviation counts times this as the prior's: its 19 fabrics are not all
            there are.
        observations: How many independent things the misfit at one k tells against that at another: folds lie elsewhere
            at each, and a garment has a few dozen of them.
        folding_spread: Standard deviation of the logarithm of the target's folding; a quarter is assumed for what
            another simulator, registration and meshing change, and was not measured.
        least_std: Smallest standard deviation of ln k that is reported: on six drapes of our own it is 0.11 off in the
            root mean square.
    """

    vertices: int = 1500
    values: int = 7
    below: float = 1.4
    above: float = 4.1
    widen: float = 2.0
    observations: float = 30.0
    folding_spread: float = 0.25
    least_std: float = 0.1
