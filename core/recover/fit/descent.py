"""Descend by Adam over control points, then fabric too, through the simulator's derivative (thesis section 3.2.5)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ...cloth.fabric import Fabric
from ...cloth.settings import SolveSettings
from ...garment.pattern import Pattern
from ...garment.seams import equalise_seams
from ...run.checkpoints import load, save
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.contours.target import Target
from .adam import Adam
from .losses.chamfer import ChamferLoss
from .losses.contours import ContourLoss
from .losses.panels import PanelLoss
from .losses.range import STIFFNESSES, RangeLoss, logarithms
from .losses.seams import SeamLoss
from .scene import FitScene

if TYPE_CHECKING:
    from ...cloth.scene import Scene


@dataclass(frozen=True)
class InverseSettings:
    """Describe the thesis' inverse fit.

    Attributes:
        vertices: Number of vertices of the mesh of the loop; with 1000 one iteration takes 0.1 to 0.3 s.
        iterations: Largest number of steps over the control points; on three garments the plateau came after 45 to 80.
        fabric_iterations: Largest number of steps over control points and fabric, after the plateau of the first ones;
            0 leaves the fabric as given. Both bounds together keep a recovery within 150 s of CPU.
        rate: Adam's step of a control point [m]; the thesis' 1e-3.
        fabric_rate: Adam's step of a stiffness' logarithm [1]; 5 % a step, so that a factor of 10 takes 46.
        curvature: Weight added to curved places of the target relative to flat ones (eq. 3.9); 0: plain distance (3.8).
        contour: Weight of the open contours relative to the surface's distance, lambda_open of eq. 3.7.
        seam: Weight of unequal seams relative to it, lambda_seam of eq. 3.6; 0 leaves seams unequal. At 1 a millimetre
            in ten seams of ten edges costs as much as 1 mm of distance; the thesis' 0.01 allows centimetres.
        panel: Weight of fold-over and kept corners relative to it: a centimetre of swing counts as 3 mm of distance.
        material: Weight of a fabric outside the library's range [m2]: a factor of e costs as much as 10 mm of distance.
        plateau: Gain, as a share of the loss, that has to be made within `patience` steps.
        patience: Number of steps; fewer would take one jump of a fold for the end.
        trials: Largest number of times that a step is tried, half as long each time.
        least_area: Smallest share of its area that a flat triangle may keep in a step: smaller ones are degenerate.
        keep_every: Number of steps from one checkpoint to the next.
        solve: The equilibrium in each step. It starts a millimetre of pattern away from the last, so 30 factorisations
            suffice; a step that ends before it is at rest still has a direction of descent.
    """

    vertices: int = 1000
    iterations: int = 150
    fabric_iterations: int = 100
    rate: float = 1e-3
    fabric_rate: float = 0.05
    curvature: float = 1.0
    contour: float = 0.1
    seam: float = 1.0
    panel: float = 0.1
    material: float = 1e-4
    plateau: float = 0.01
    patience: int = 15
    trials: int = 4
    least_area: float = 0.05
    keep_every: int = 5
    solve: SolveSettings = field(default_factory=lambda: SolveSettings(max_iterations=30))


@dataclass(frozen=True)
class DescentProblem:
    """Describe what stays the same during Adam's descent.

    Its variables are the effective control points x0, y0, x1, ... [m] and ln of H00, H01, H11, H22, k.

    Attributes:
        scene: The scene of the first pattern's mesh, nodes at its drape, contours named.
        chamfer, contour, seam, panel, material: The losses.
        settings: Their weights and the steps.
    """

    scene: FitScene
    chamfer: ChamferLoss
    contour: ContourLoss
    seam: SeamLoss
    panel: PanelLoss
    material: RangeLoss
    settings: InverseSettings

    @classmethod
    def of(cls, scene: FitScene, target: Target, settings: InverseSettings) -> DescentProblem:
        """Prepare the descent from a garment at rest towards a target; the scene's parameters have `STIFFNESSES`."""
        garment = scene.garment
        return cls(
            scene=scene,
            chamfer=ChamferLoss.of(garment, target.vertices, target.faces, settings.curvature),
            contour=ContourLoss.of(garment, target),
            seam=SeamLoss.of(garment, scene.base),
            panel=PanelLoss.of(garment, scene.base),
            material=RangeLoss.of(scene.fabric),
            settings=settings,
        )

    @property
    def start(self) -> np.ndarray:
        """Return the variables of the first pattern and fabric, shape [variable_count]."""
        points = self.scene.effective(self.scene.garment.pattern)
        return np.concatenate([points, logarithms(self.scene.fabric)])

    def points_of(self, variables: np.ndarray) -> np.ndarray:
        """Return all control points [m], shape [point_count, 2]."""
        return self.scene.symmetry.expand(variables[: -len(STIFFNESSES)])

    def fabric_of(self, variables: np.ndarray) -> Fabric:
        """Return the fabric; only its stiffnesses vary."""
        values = np.exp(variables[-len(STIFFNESSES) :]).tolist()
        return replace(self.scene.fabric, **dict(zip(STIFFNESSES, values, strict=True)))

    def pattern_of(self, variables: np.ndarray) -> Pattern:
        """Return the final pattern: seams made equal unless gathered, locked coordinates restored."""
        pattern = self.scene.base.with_points(self.points_of(variables))
        if self.settings.seam > 0.0:
            pattern = equalise_seams(pattern, base=pattern, symmetry=self.scene.symmetry)
        return self.scene.with_locks(pattern)

    def at(self, variables: np.ndarray) -> Scene:
        """Return the scene with these variables."""
        return self.scene.at(variables - self.start)

    def drape(
        self, variables: np.ndarray, nodes: np.ndarray, anchors: np.ndarray | None, hooks: Hooks
    ) -> tuple[np.ndarray, np.ndarray]:
        """Bring the cloth to rest from nodes [m]; return nodes and friction's anchors, shape [node_count, 3] each."""
        from ...cloth.statics import equilibrium

        scene, solver, settings = self.at(variables), self.scene.preconditioner, self.settings.solve
        drape = equilibrium(scene, nodes, anchors=anchors, solver=solver, settings=settings, hooks=hooks)
        return drape.nodes, drape.anchors

    def evaluate(self, variables: np.ndarray, nodes: np.ndarray, anchors: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the loss [m2] and its gradient by the variables, shape [variable_count] (eq. 3.6 and 3.7).

            L = L_chamfer + w_o L_contour + w_m L_material + w_s L_seam + w_p L_panel
        The drape's part is pulled back through its equilibrium: one factor, one back-substitution.
        """
        weights = self.settings
        value, upstream = self.chamfer.evaluate(nodes)
        more, slope = self.contour.evaluate(nodes)
        value, upstream = value + weights.contour * more, upstream + weights.contour * slope
        rest = self.scene.linearise(variables - self.start, nodes, anchors)
        gradient = self.scene.parameters.pull(rest.scene, rest.pull(upstream))
        points, shape = self.points_of(variables), len(variables) - len(STIFFNESSES)
        unequal, by_seam, _ = self.seam.evaluate(points, self.seam.best_ratios(points))
        folded, by_panel = self.panel.evaluate(points)
        outside, by_log = self.material.evaluate(variables[shape:])
        by_points = weights.seam * by_seam + weights.panel * by_panel
        gradient[:shape] += self.scene.symmetry.pull_back(by_points).ravel()
        gradient[shape:] += weights.material * by_log
        value += weights.seam * unequal + weights.panel * folded + weights.material * outside
        return value, gradient

    def take(self, variables: np.ndarray, move: np.ndarray) -> np.ndarray:
        """Take the largest part of a move (1, 1/2, 1/4, ...) that folds no panel; none where all do."""
        for _ in range(self.settings.trials):
            trial = self.scene.base.with_points(self.points_of(variables + move))
            if self.scene.is_sound(trial, self.settings.least_area):
                taken: np.ndarray = variables + move
                return taken
            move = 0.5 * move
        return variables


@dataclass(frozen=True)
class Descent:
    """Describe the state of the descent, on which the next step depends.

    Attributes:
        variables: Control points and fabric, shape [variable_count].
        nodes, anchors: Its drape [m], shape [node_count, 3] each.
        gradient: Of the loss there, shape [variable_count].
        adam: The optimiser.
        best: The variables of the lowest loss so far.
        best_nodes, best_anchors: Their drape.
        losses: The loss at the start and after every step [m2].
        first: Index of the first loss of the present stage.
        stage: 0: control points; 1: fabric too; 2: done.
    """

    variables: np.ndarray
    nodes: np.ndarray
    anchors: np.ndarray
    gradient: np.ndarray
    adam: Adam
    best: np.ndarray
    best_nodes: np.ndarray
    best_anchors: np.ndarray
    losses: np.ndarray
    first: int
    stage: int

    def reaches_end(self, settings: InverseSettings) -> bool:
        """Return whether the present stage is over: its steps are used up, or the loss has reached a plateau."""
        losses = self.losses[self.first :]
        if len(losses) > (settings.iterations, settings.fabric_iterations)[self.stage]:
            return True
        if len(losses) <= 2 * settings.patience:
            return False
        return bool(losses[-settings.patience :].min() > (1.0 - settings.plateau) * losses[: -settings.patience].min())


def descend(problem: DescentProblem, hooks: Hooks = SILENT_HOOKS, fit_fabric: bool = True) -> Descent:
    """Descend by Adam to a plateau, then once more with the fabric's stiffnesses added.

    **Deviation**: the thesis differentiates 10 to 20 time steps of 0.05 s. Here the derivative is that of the state at
    rest (`Implicit`): both agree there, and a gradient costs 5 ms at 1000 vertices, not 20 solves.
    """
    settings = problem.settings
    state = load(hooks, "fit.inverse", Descent, problem.scene.garment.nodes) or _begin(problem, hooks)
    while state.stage < 2:
        if state.reaches_end(settings):
            state = _next_stage(problem, state, hooks, fit_fabric)
            continue
        done = len(state.losses) / (settings.iterations + settings.fabric_iterations + 1.0)
        hooks.progress("fit", 0.9 * done, f"loss {1e6 * state.losses[-1]:.0f} mm2")
        state = _step(problem, state, hooks)
        if len(state.losses) % settings.keep_every == 0:
            save(hooks, "fit.inverse", state, problem.scene.garment.nodes)
    return state


def _begin(problem: DescentProblem, hooks: Hooks) -> Descent:
    variables = problem.start
    nodes, anchors = problem.drape(variables, problem.scene.garment.nodes, None, hooks)
    loss, gradient = problem.evaluate(variables, nodes, anchors)
    adam = Adam.of(len(variables))
    return Descent(
        variables, nodes, anchors, gradient, adam, variables, nodes, anchors, np.array([loss]), first=0, stage=0
    )


def _step(problem: DescentProblem, state: Descent, hooks: Hooks) -> Descent:
    """Take one step of Adam and drape."""
    settings, shape = problem.settings, len(problem.scene.locked)
    rates = np.full(len(state.variables), settings.fabric_rate if state.stage == 1 else 0.0)
    rates[:shape] = np.where(problem.scene.locked, 0.0, settings.rate)
    adam, move = state.adam.step(state.gradient, rates)
    variables = problem.take(state.variables, move)
    nodes, anchors = problem.drape(variables, state.nodes, state.anchors, hooks)
    loss, gradient = problem.evaluate(variables, nodes, anchors)
    losses = np.append(state.losses, loss)
    state = replace(
        state, variables=variables, nodes=nodes, anchors=anchors, gradient=gradient, adam=adam, losses=losses
    )
    if loss < losses[:-1].min():
        return replace(state, best=variables, best_nodes=nodes, best_anchors=anchors)
    return state


def _next_stage(problem: DescentProblem, state: Descent, hooks: Hooks, fit_fabric: bool) -> Descent:
    """Return to the best variables and begin the next stage with a new Adam state."""
    if state.stage == 1 or not fit_fabric or problem.settings.fabric_iterations == 0:
        return replace(state, stage=2)
    loss, gradient = problem.evaluate(state.best, state.best_nodes, state.best_anchors)
    return replace(
        state,
        variables=state.best,
        nodes=state.best_nodes,
        anchors=state.best_anchors,
        gradient=gradient,
        adam=Adam.of(len(state.best)),
        losses=np.append(state.losses, loss),
        first=len(state.losses),
        stage=1,
    )
