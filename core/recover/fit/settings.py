"""Define the settings of the inverse fit, with the reason for each default."""

from __future__ import annotations

from dataclasses import dataclass, field

from ...cloth.settings import SolveSettings


@dataclass(frozen=True)
class ShapeSettings:
    """Describe the fit of the pattern through the simulator.

    Attributes:
        vertices: Largest number of vertices of the fit's mesh: those of the registered mesh up to 6000, where one
            equilibrium takes 1 s. On 1500 two T-shirts of our own came out 1.5 and 2.0 % off in area, not 0.3: a coarse
            mesh cuts its folds short, and the pattern compensates for that.
        iterations: Number of Gauss-Newton iterations; after eight no point of T-shirts and trousers moved by 1 mm.
        trials: Number of steps tried in one iteration, each with ten times the damping of the one before. With three
            the fit of a dress stopped at a misfit of 3.2 mm, its hem 18 mm too low; the fourth led on to 2.7.
        damping: First damping, as a share of the diagonal of the Gauss-Newton matrix (Marquardt).
        plateau: Ratio of the gain in the objective to the number of observations below which the fit stops: a misfit
            that falls by half a percent. Smaller predictions are not tried: four garments gained 0 to 1.6 of them.
        slide: Cost of sliding within the surface as a share of leaving it: registration finds the surface to 1 mm and
            the place on it to about a centimetre, wrong in one direction all along a seam. With a tenth two T-shirts of
            our own came out 0.9 and 1.2 % off in area, with a hundredth 0.2 and 0.3.
        spread: Standard deviation of the control points around the pattern from the metric [m]: those of two T-shirts
            of our own were 2.6 and 3.0 mm off in the root mean square, panels of published patterns 4 to 10 mm.
        spread_share: The same as a share of the panel's mean width, where that is less: 2 mm on a 4 cm waistband.
        area_spread: Standard deviation of ln of the area of all panels together around the metric's [1]. The simulated
            cloth lacks small wrinkles, so it needs less area: with the points' spread alone drapes of another simulator
            lost 2 to 3 % of their area at a misfit from 4.3 to 2.7 mm; with this 0.3 to 0.5 %, at 3.1 mm.
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
    """Describe the search for the cloth's bending stiffness.

    Attributes:
        vertices: Number of vertices of the mesh: 1500 are at equilibrium in under 1 s and resolve folds of 5 cm.
        values: Number of values of k / density tried over the range, evenly in the logarithm: 5 are a factor of 8
            apart, and two more beside the best sharpen it. Of 16 skirts of known k, of 400 to 700 vertices, 5 found
            ln k within 0.18 in the mean, 6 within 0.19 and 7 within 0.25, for 0.75, 0.95 and 1 of the time.
        below: Extension of the range below the library's softest, as a logarithm [1]; 1.4 is a factor of 4.
        above: Extension above its stiffest [1]; 4.1 is a factor of 60, assumed: chosen so that a very stiff skirt,
            whose folding was seen first, is within the range, just at its end.
        widen: Factor from the library's standard deviation to the prior's: its 19 fabrics are not all that exist.
        observations: Number of independent observations in the misfits at two k: a garment has a few dozen folds.
        folding_spread: Standard deviation of the logarithm of the target's folding [1]; a quarter is assumed for what
            another simulator, registration and meshing change, and was not measured.
        least_std: Smallest reported standard deviation of ln k [1]: on six drapes of our own its RMS error is 0.11.
    """

    vertices: int = 1500
    values: int = 5
    below: float = 1.4
    above: float = 4.1
    widen: float = 2.0
    observations: float = 30.0
    folding_spread: float = 0.25
    least_std: float = 0.1
