"""One implicit Euler step of cloth on a moving body, solved to convergence."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..body.signed_distance import SignedDistance
from ..geometry.linear import Solver
from .bending_friction import measure_angles
from .carry_step import move_collision_free
from .collision.coupling import extend_sparsity
from .collision.self_contact import SelfContact
from .dynamics import ClothState
from .energy import Energy, Inertia
from .factorisation import factor_regularised
from .friction import lag_friction
from .pins import Pins
from .quasi_newton import descend
from .scene import Scene
from .settings import SettingsBad
from .solver import make_solver
from .tangent_planes import TangentPlanes


@dataclass(frozen=True)
class StepSettings:
    """Describe the settings of a step of cloth in motion.

    Attributes:
        damping: Rate at which velocity relative to the air decays [1/s]. A sheet of 120 g/m2 that falls flat reaches
            1.3 m/s (drag coefficient 1.2), which is a rate of 7.5; edge-on the rate is 0. 2 is a third of 7.5, the mean
            over all directions, rounded down, and includes the yarns' own losses. Assumed.
        wind: Velocity of the air [m/s].
        tolerance: Largest force left on a node [mean weight of a node]. 0.1: 1 m/s2 on the worst node for a step, which
            in 1/30 s moves it by at most a millimetre; on 99 of 100 nodes it is a fifth of that.
        rest_motion: Motion of the fastest node in a run under which the step counts as converged [m], unless a near
            collision cut the run short.
        steps_per_factor: Number of quasi-Newton steps per factored matrix (a run).
        legs: Largest number of runs; a step that needs more is taken in two halves. 40: steps of a skirt in a walk that
            failed after 12 runs, and then took 14 to 21 in two halves, converged after 14 to 26.
        renewals: Number of runs before which planes and friction's normal forces are computed anew. In a crease they
            and the cloth keep changing each other, so that they stay constant after so many runs.
        reach: Distance to the skin within which a node has a plane [m]: more than it moves in a run.
        max_step: Largest displacement of a node in a quasi-Newton step [m].
    """

    damping: float = 2.0
    wind: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tolerance: float = 0.1
    rest_motion: float = 1e-4
    steps_per_factor: int = 8
    legs: int = 40
    renewals: int = 5
    reach: float = 0.03
    max_step: float = 0.02

    def __post_init__(self) -> None:
        """Check the values; raise `SettingsBad` where one is negative."""
        if not self.damping >= 0 or not self.reach > 0 or self.legs < 1:
            raise SettingsBad(f"damping, reach and legs must not be negative: {self}.")


@dataclass(frozen=True)
class SolverLayout:
    """Describe a scene, without its body, with the pairs of cloth that may touch and a solver analysed for its
    topology, in single precision. That is enough for a direction of descent: a step ends by its forces, in double
    precision."""

    energy: Energy
    solver: Solver

    @classmethod
    def of(cls, scene: Scene) -> SolverLayout:
        """Return the layout of a scene without pairs."""
        return cls(Energy(scene), make_solver(scene.topology.pattern, single=True))

    def at(self, pins: Pins | None, contact: SelfContact | None) -> SolverLayout:
        """Return the layout with the pins and the self-contact of a step."""
        scene = replace(self.energy.scene, pins=pins, self_contact=contact)
        near = self.energy.near if contact is self.energy.scene.self_contact else None
        return SolverLayout(replace(self.energy, scene=scene, near=near), self.solver)


@dataclass(frozen=True)
class StepResult:
    """Describe the result of a step.

    Attributes:
        state: The cloth after it.
        converged: Whether the forces are within the tolerance or nothing moves any more.
        residual: Largest force left on a node, relative to the mean weight of a node.
        factors: Number of matrices factored.
        layout: For the next step.
    """

    state: ClothState
    converged: bool
    residual: float
    factors: int
    layout: SolverLayout


def step_in_motion(
    layout: SolverLayout,
    before: ClothState,
    carried: ClothState,
    body: SignedDistance | None,
    dt: float,
    settings: StepSettings = StepSettings(),
) -> StepResult:
    """Compute an implicit Euler step of `dt` [s] with air drag, on a body that has moved.

        m (v+ - v) / dt = -dE(x+) - c m (v+ - w),   v+ = (x+ - x) / dt

    is the minimum of E(x+) + (1 + c dt) / (2 dt^2) |x+ - y|_M^2 with y = x + dt (v + c dt w) / (1 + c dt).

    Notation: c `damping`; w `wind`; M masses. Friction on the skin and in bending starts from the anchors of the step
    before (`anchors`, `folds`). The body's planes and friction's normal forces are computed anew before each run, so
    that a converged step is in balance with those at its end. Where forces become NaN or infinite, the step ends at the
    last place with finite ones and is not converged.

    Args:
        layout: The cloth and all that acts on it except the body; pins are at their points after the step.
        before: The cloth before the step.
        carried: Nodes and friction's anchors moved with the skin. The search for the minimum starts at these nodes, so
            that cloth stays on its side of a limb that moves by more than its thickness.
        body: The body after the step, or None.
        dt: Length of the step [s].
        settings: Limits.
    """
    free = 1.0 + settings.damping * dt
    target = before.nodes + dt * (before.velocities + settings.damping * dt * np.asarray(settings.wind)) / free
    energy, solver = replace(layout.energy, inertia=Inertia(target, free / dt**2), friction=None), layout.solver
    friction = energy.scene.bending_friction
    if friction is not None and before.folds is not None:
        friction = replace(friction, angles=before.folds)
        energy = replace(energy, scene=replace(energy.scene, bending_friction=friction))
    energy = energy.suspend_coincident(before.nodes)
    energy, nodes = move_collision_free(energy, before.nodes, carried.nodes)
    planes, motion, cut, factors, sound = TangentPlanes.none(len(nodes)), np.inf, False, 0, before.nodes
    while True:
        energy, solver = extend_sparsity(energy, solver, nodes)
        if factors < settings.renewals:
            if body is not None:
                planes = planes.renewed(nodes, body, settings.reach)
                energy = replace(energy, scene=replace(energy.scene, body=planes))
            energy = replace(energy, friction=lag_friction(energy.scene, nodes, carried.anchors))
        start, gradient, blocks = energy.hessian(nodes, False)
        residual = energy.scene.relative_residual(gradient)
        if not np.isfinite(residual):
            nodes, converged = sound, False
            break
        sound, converged = nodes, residual <= settings.tolerance or (motion < settings.rest_motion and not cut)
        if converged or factors == settings.legs:
            break
        if factor_regularised(energy, solver, nodes, blocks, 0.0) < 0:
            break
        leg = descend(
            energy, solver, nodes, start, gradient,
            steps=settings.steps_per_factor, residual=0.3 * settings.tolerance, max_step=settings.max_step,
        )  # fmt: skip
        energy, nodes, motion, cut, factors = leg.energy, leg.nodes, leg.motion, leg.cut, factors + 1
    velocities = (nodes - before.nodes) / dt
    anchors = nodes if energy.friction is None else energy.friction.slide(nodes)
    folds = None if friction is None else friction.slide(measure_angles(energy.scene.topology, nodes))
    bare = replace(energy, scene=replace(energy.scene, body=None), friction=None, inertia=None)
    return StepResult(
        ClothState(nodes, velocities, anchors, folds=folds),
        bool(converged),
        residual,
        factors,
        SolverLayout(bare, solver),
    )
