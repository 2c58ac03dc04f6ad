"""Fit pattern and bending through the simulator: Gauss-Newton over control points and ln k (thesis chapter 3)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...cloth.fabric import Fabric
from ...cloth.statics import Drape
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...garment.seams import MIN_SINGULAR_VALUE_SHARE, equalise_seams, seam_constraints
from ...garment.symmetry import find_symmetry
from ...run.checkpoints import load, save
from ...run.hooks import SILENT_HOOKS, Hooks
from ..grade.flattening import mean_width
from ..grade.proportion import area_growth, find_proportions
from .independence import count_independent
from .losses.registered import RegisteredLoss
from .scene import FitScene
from .settings import ShapeSettings

if TYPE_CHECKING:
    from ...cloth.scene import Scene


MIN_DAMPING = 1e-3
"""Damping, as a share of the matrix's diagonal, below which a step hardly depends on it: after a step that does not
lower the objective a smaller one would lead to the same drape."""


@dataclass(frozen=True)
class ShapeFit:
    """Describe the fitted pattern.

    Attributes:
        pattern: Seams equal within 1e-6 m, symmetry of the template kept.
        fabric: The cloth, with the k that was fitted, or as the problem gave it.
        nodes: Its equilibrium on the mesh of the fit [m], shape [node_count, 3].
        misfits: Root mean square misfit at the start and after each accepted step [m].
        outcome: `plateau` (last or predicted gain too small), `no gain` (no step lowers the objective), `iterations`.
        drape: The equilibrium with its friction.
    """

    pattern: Pattern
    fabric: Fabric
    nodes: np.ndarray
    misfits: tuple[float, ...]
    outcome: str
    drape: Drape


@dataclass(frozen=True)
class ShapeProblem:
    """Describe what stays the same while a pattern is fitted.

    Attributes:
        scene: The scene of the first pattern's mesh, nodes registered on the target. Its parameters are the effective
            control points, and ln k where `bending` is given.
        loss: The misfit.
        settings: Steps and prior.
        precision: Inverse covariance of the parameters around the first ones [1/m2; 1 for ln k], shape [p, p].
        bending: Standard deviation of ln k around the fabric's where k is fitted, too; None where it stays.
    """

    scene: FitScene
    loss: RegisteredLoss
    settings: ShapeSettings
    precision: np.ndarray
    bending: float | None = None

    @classmethod
    def of(cls, scene: FitScene, settings: ShapeSettings) -> ShapeProblem:
        """Prepare the fit of a garment on the target, contours named."""
        loss = RegisteredLoss.of(scene.garment, settings.slide)
        return cls(scene, loss, settings, _precision(scene.garment.pattern, scene.base, settings))

    @property
    def garment(self) -> Garment:
        """Return the mesh of the first pattern, nodes registered on the target."""
        return self.scene.garment

    @property
    def fabric(self) -> Fabric:
        """Return the initial cloth."""
        return self.scene.fabric

    def with_fabric(self, fabric: Fabric) -> ShapeProblem:
        """Return the problem with another initial cloth."""
        return replace(self, scene=self.scene.with_fabric(fabric))

    def fitting_bending(self, std: float) -> ShapeProblem:
        """Return the problem with k fitted, too; the prior's standard deviation of ln k is `std`."""
        parameters = replace(self.scene.parameters, fabric=("k",))
        scene = replace(self.scene, parameters=parameters)
        return replace(self, scene=scene, precision=_append_diagonal(self.precision, std**-2), bending=std)

    def difference(self, pattern: Pattern, fabric: Fabric) -> np.ndarray:
        """Return the parameters' difference from the first ones [m; 1 for ln k], shape [p]."""
        points = self.scene.effective(pattern) - self.scene.effective(self.garment.pattern)
        return points if self.bending is None else np.append(points, np.log(fabric.k / self.fabric.k))

    def at(self, pattern: Pattern, fabric: Fabric | None = None) -> Scene:
        """Return the scene with a pattern and, where k is fitted, a fabric."""
        return self.scene.at(self.difference(pattern, fabric or self.fabric))

    def drape(
        self, pattern: Pattern, nodes: np.ndarray, hooks: Hooks = SILENT_HOOKS, fabric: Fabric | None = None
    ) -> Drape:
        """Bring the cloth to rest from nodes [m], with friction anchored where it was registered."""
        from ...cloth.statics import equilibrium

        scene, solver, anchors = self.at(pattern, fabric), self.scene.preconditioner, self.garment.nodes
        return equilibrium(scene, nodes, anchors=anchors, solver=solver, settings=self.settings.solve, hooks=hooks)

    def linearise(self, pattern: Pattern, drape: Drape, fabric: Fabric | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return gradient [p] and Gauss-Newton matrix [p, p] of the loss by the parameters (`linearise_at`)."""
        rest = self.scene.linearise(self.difference(pattern, fabric or self.fabric), drape.nodes, drape.anchors)
        moves = rest.push(*self.scene.parameters.rates(rest.scene))
        gradient = np.tensordot(moves, self.loss.gradient(drape.nodes), axes=((0, 1), (0, 1)))
        return gradient, self.loss.curvature(moves)

    def objective(self, loss: float, count: float, delta: np.ndarray) -> float:
        """Return n/2 ln L + (p - p0) P (p - p0) / 2: the negative log posterior, the size of the noise unknown."""
        return 0.5 * count * float(np.log(loss)) + 0.5 * float(delta @ self.precision @ delta)

    def observations(self, nodes: np.ndarray) -> float:
        """Return n, the number of independent observations of the target in a drape [m], shape [node_count, 3]."""
        normals, areas = self.loss.normals, self.scene.first.topology.rest.node_areas
        return count_independent(self.loss.target, normals, ((nodes - self.loss.target) * normals).sum(1), areas)

    def step(
        self, pattern: Pattern, delta: np.ndarray, weight: float, linear: tuple[np.ndarray, np.ndarray], damping: float
    ) -> tuple[np.ndarray, float]:
        """Return the Levenberg-Marquardt step [p], seams equal to first order, and its gain; `weight` is n / (2 L)."""
        gradient, matrix = weight * linear[0] + self.precision @ delta, weight * linear[1]
        curvature = matrix + self.precision
        matrix = curvature + damping * np.diag(np.diag(matrix))
        free = seam_null_space(pattern, self.scene.base, self.scene.locked)
        if self.bending is not None:
            free = _append_diagonal(free, 1.0)
        step = np.asarray(free @ np.linalg.solve(free.T @ matrix @ free, -free.T @ gradient))
        return step, -float(gradient @ step) - 0.5 * float(step @ curvature @ step)

    def cut(self, delta: np.ndarray) -> tuple[Pattern | None, Fabric]:
        """Return pattern (seams equal; None if folded) and cloth at a difference [m; 1 for ln k], shape [p]."""
        scene, fabric = self.scene, self.fabric
        first = scene.effective(self.garment.pattern)
        if self.bending is not None:
            fabric = replace(fabric, k=fabric.k * float(np.exp(delta[-1])))
        proposed = scene.base.with_points(scene.symmetry.expand(first + delta[: len(first)]))
        pattern = scene.with_locks(equalise_seams(proposed, base=scene.base))
        return pattern if scene.is_sound(pattern) else None, fabric


def _precision(pattern: Pattern, base: Pattern, settings: ShapeSettings) -> np.ndarray:
    """Return the prior's inverse covariance around a pattern [1/m2], shape [p, p]: diag(1 / s^2) + R^T R + g g^T / a^2.

    s is `spread`, but at most `spread_share` of the panel's mean width; R are the rates of the base pattern's
    `Proportions` in standard deviations, which the simulator must not change. g is the rate of ln of the whole area, a
    `area_spread`: the metric measures all cloth, including wrinkles that the simulator lacks.
    """
    free = find_symmetry(base).matrix.toarray()
    whole = area_growth(pattern).reshape(1, -1) / settings.area_spread
    rates = np.concatenate([find_proportions(base).linearise(pattern)[1], whole]) @ free
    counts = [len(panel.points) for panel in pattern.panels]
    widths = np.array([settings.spread_share * mean_width(panel) for panel in pattern.panels])
    of_point = np.repeat(np.minimum(widths, settings.spread), 2 * np.array(counts))
    spread = np.where(free != 0.0, of_point[:, None], settings.spread).min(axis=0)
    return np.asarray(np.diag(spread**-2.0) + rates.T @ rates)


def _append_diagonal(matrix: np.ndarray, last: float) -> np.ndarray:
    """Append a row and a column that are zero except for their common element."""
    from scipy.linalg import block_diag

    return np.asarray(block_diag(matrix, last))


def seam_null_space(pattern: Pattern, base: Pattern, locked: np.ndarray | None = None) -> np.ndarray:
    """Compute an orthonormal basis of the effective motions that keep seams equal and locks, shape [p, free_count].

    Seams that repeat others up to rounding in a file (`MIN_SINGULAR_VALUE_SHARE`) remove no motion.
    """
    rows = seam_constraints(pattern, base=base)[1] @ find_symmetry(base).matrix.toarray()
    if locked is not None:
        rows = np.concatenate([rows, np.eye(len(locked))[locked]])
    if not len(rows):
        return np.eye(rows.shape[1])
    _, values, right = np.linalg.svd(rows)
    return np.asarray(right[int((values > MIN_SINGULAR_VALUE_SHARE * values[0]).sum()) :].T)


@dataclass(frozen=True)
class _ShapeCheckpoint:
    """Describe the start of the next iteration (checkpoint `fit.shape`); `settled` is true where the fit has ended."""

    points: np.ndarray
    k: float
    drape: Drape
    damping: float
    misfits: tuple[float, ...]
    settled: bool


def fit_shape(problem: ShapeProblem, hooks: Hooks = SILENT_HOOKS) -> ShapeFit:
    """Fit control points, and k where the problem includes it, so that the equilibrium is on the target.

    Minimises n/2 ln L(x*(p)) + (p - p0) P (p - p0) / 2, L of `RegisteredLoss`, x* the equilibrium of the parameters p,
    p0 the first ones, P `precision`, by Levenberg-Marquardt with the implicit Jacobian dx*/dp. n is computed again
    before each step. Only steps that lower it are taken, and none with too small a predicted gain is tried.

    **Deviation**: the thesis descends by Adam through 20 time steps without a prior. Here the misfit determines its own
    weight: a drape in other folds than the target's has a large L, correlated over wide stretches, and little weight.
    """
    settings, outcome = problem.settings, "iterations"
    inputs = (problem.garment.nodes, problem.fabric.k)
    kept = load(hooks, "fit.shape", _ShapeCheckpoint, *inputs)
    if kept is None:
        drape = problem.drape(problem.garment.pattern, problem.garment.nodes, hooks)
        misfit = float(np.sqrt(2.0 * problem.loss.value(drape.nodes)))
        kept = _ShapeCheckpoint(
            problem.garment.pattern.points, problem.fabric.k, drape, settings.damping, (misfit,), False
        )
    pattern, fabric = problem.scene.base.with_points(kept.points), replace(problem.fabric, k=kept.k)
    drape, damping, misfits, settled = kept.drape, kept.damping, list(kept.misfits), kept.settled
    first = len(misfits) - 1
    for iteration in range(first, settings.iterations):
        if settled:
            break
        hooks.progress("fit", (iteration + 1.0) / (settings.iterations + 1.0), f"misfit {1e3 * misfits[-1]:.1f} mm")
        linear = problem.linearise(pattern, drape, fabric)
        loss, count = problem.loss.value(drape.nodes), problem.observations(drape.nodes)
        delta = problem.difference(pattern, fabric)
        before, least = problem.objective(loss, count, delta), settings.plateau * count
        for _ in range(settings.trials):
            step, gain = problem.step(pattern, delta, 0.5 * count / loss, linear, damping)
            settled = gain < least
            if settled:
                break
            proposed, cloth = problem.cut(delta + step)
            damping = 10.0 * max(damping, MIN_DAMPING)
            if proposed is None:
                continue
            trial = problem.drape(proposed, drape.nodes, hooks, cloth)
            trial_loss = problem.loss.value(trial.nodes)
            after = problem.objective(trial_loss, count, problem.difference(proposed, cloth))
            if after < before:
                pattern, fabric, drape = proposed, cloth, trial
                misfits.append(float(np.sqrt(2.0 * trial_loss)))
                # back to the damping that worked, and a fifth of it next
                damping /= 50.0
                settled = before - after < least
                reached = _ShapeCheckpoint(pattern.points, fabric.k, drape, damping, tuple(misfits), settled)
                save(hooks, "fit.shape", reached, *inputs)
                break
        else:
            outcome = "no gain"
            break
    return ShapeFit(pattern, fabric, drape.nodes, tuple(misfits), "plateau" if settled else outcome, drape)
