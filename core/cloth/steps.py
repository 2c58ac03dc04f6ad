"""Time steps of a cloth and the adjoint through them, for any way of taking a single step."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np

from ..geometry.linear import Solver
from .energy import Energy, Inertia
from .friction import Friction
from .scene import Scene
from .sensitivity import Sensitivity
from .settings import SettingsBad
from .solver import make_solver

__all__ = ["ClothTrajectory", "TimeSteps"]


@dataclass(frozen=True)
class TimeSteps(ABC):
    """Take implicit Euler steps from y_t = x_{t-1} + damping (x_{t-1} - x_{t-2}); a subclass defines the single step.

    Attributes:
        dt: Length of a step [s]; the thesis has 0.05.
        damping: Share of velocity kept from one step to the next; the thesis has 1. `SolveSettings.damping` is for
            coming to rest, this for targets in motion. 0.6 is about critical for a sway of a second over 20 steps of
            0.05 s, and the gradient at rest is that of `ImplicitDerivative`; undamped it still swings
            (docs/lab/simulate.md).
    """

    steps: int = 20
    dt: float = 0.05
    damping: float = 1.0

    def solve(
        self,
        scene: Scene,
        nodes: np.ndarray,
        solver: Solver | None = None,
        *,
        friction: Friction | None = None,
        velocities: np.ndarray | None = None,
    ) -> ClothTrajectory:
        """Take the steps from nodes [m] and velocities [m/s], both [node_count, 3], with constant friction.

        Raises:
            NotAtRest: where a step cannot be taken; take shorter ones.
            SettingsBad: where the scene has self-contact, whose pairs change on the path; use `ImplicitDerivative`.
        """
        if scene.self_contact is not None:
            raise SettingsBad("derivatives through time exclude self-contact: use ImplicitDerivative or switch it off.")
        energy, solver = Energy(scene, friction), solver or make_solver(scene.topology.pattern)
        start = np.array(nodes, dtype=np.float64)
        path = [start if velocities is None else start - self.dt * np.asarray(velocities), start]
        for _ in range(self.steps):
            path.append(self._advance(self.energy_of_step(energy, path[-2], path[-1]), path[-1], solver))
        return ClothTrajectory(energy, self, np.stack(path), solver)

    def energy_of_step(self, energy: Energy, before: np.ndarray, now: np.ndarray) -> Energy:
        """Return the energy that the next step minimises, after nodes [m] before and now, both [node_count, 3]."""
        return replace(energy, inertia=Inertia(now + self.damping * (now - before), 1.0 / self.dt**2))

    @abstractmethod
    def _advance(self, step: Energy, nodes: np.ndarray, solver: Solver) -> np.ndarray:
        """Return the positions after a step from nodes [m]."""

    @abstractmethod
    def pull_step(
        self, step: Energy, start: np.ndarray, end: np.ndarray, bar: np.ndarray, solver: Solver
    ) -> tuple[np.ndarray, Sensitivity]:
        """Return lambda and the derivative by everything but y, from that by positions after a step, `bar` [1/m]."""


@dataclass(frozen=True)
class ClothTrajectory:
    """Describe the positions of a cloth over time.

    Attributes:
        energy: The energy without inertia.
        path: Positions before the start, at it and after each step [m], shape [steps + 2, node_count, 3].
        solver: Factors the steps' matrices again on the way back.
    """

    energy: Energy
    method: TimeSteps
    path: np.ndarray
    solver: Solver

    @property
    def nodes(self) -> np.ndarray:
        """Return the positions after the last step [m], shape [node_count, 3]."""
        return np.asarray(self.path[-1])

    def pull(self, upstream: np.ndarray) -> Sensitivity:
        """Return a loss's derivative by everything, from `upstream` [1/m]: by the last positions, shape [node_count,
        3], or by those after every step (a target in motion), shape [steps, node_count, 3]."""
        method, path, scene = self.method, self.path, self.energy.scene
        bars = np.zeros_like(path)
        if np.ndim(upstream) == 3:
            bars[2:] = upstream
        else:
            bars[-1] = upstream
        pinned = 0 if scene.pins is None else len(scene.pins.nodes)
        rest, fabric, pins = np.zeros_like(scene.topology.rest.corners), np.zeros(6), np.zeros((pinned, 3))
        tied = (scene.masses / method.dt**2)[:, None]
        for t in range(len(path) - 1, 1, -1):
            step = method.energy_of_step(self.energy, path[t - 2], path[t - 1])
            weights, found = method.pull_step(step, path[t - 1], path[t], bars[t], self.solver)
            rest, fabric, pins = rest + found.rest, fabric + found.fabric, pins + found.pins
            bars[t - 1] += found.start + (1.0 + method.damping) * tied * weights
            bars[t - 2] -= method.damping * tied * weights
        return Sensitivity(rest, fabric, pins, bars[1] + bars[0])
