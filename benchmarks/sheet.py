"""The sheet on a ball that the simulator's benchmarks share."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.cloth.derivative import Derivative
from garmentq.core.cloth.dynamics import take_time_steps
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.friction import Friction, lag_friction
from garmentq.core.cloth.parameters import Parameters
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.settings import SolveSettings
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.geometry.linear import Solver

SIDES = {"1K": 32, "3K": 55, "8K": 90}
"""Nodes along each side of the sheet."""

THESIS = {"1K": (59.4, 60.0), "3K": (228.6, 186.3)}
"""Thesis table 3.1: seconds for assembly and linear solve of 20 steps, forward and reverse, on an RTX 3090."""


def sheet_on_ball(count: int, corner: tuple[float, float] = (-0.3, -0.3)) -> tuple[Scene, np.ndarray, np.ndarray]:
    """Lay a square sheet of 60 cm over a ball of 15 cm: the scene, its nodes [m] and its flat points [m].

    Args:
        count: Nodes along each side.
        corner: Where its first corner lies, seen from above [m].
    """
    u, v = np.meshgrid(*(np.linspace(low, low + 0.6, count) for low in corner), indexing="ij")
    flat = np.stack([u.ravel(), v.ravel()], axis=1)
    i = np.arange(count * count).reshape(count, count)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    cells = np.arange(-0.35, 0.355, 0.01)
    points = np.stack(np.meshgrid(cells, cells, cells, indexing="ij"), axis=-1)
    ball = DistanceGrid.from_values(np.full(3, -0.35), 0.01, np.linalg.norm(points, axis=-1) - 0.15)
    nodes = np.column_stack([flat[:, 0], np.full(len(flat), 0.153), -flat[:, 1]])
    return Scene(Topology.from_mesh(faces, flat[faces]), get_fabric("cotton_poplin"), ball), nodes, flat


@dataclass(frozen=True)
class Laid:
    """Cloth that lies at rest, its friction as it is there, and what may change of it.

    Attributes:
        scene: The cloth and the ball.
        friction: Where it rests, as every derivative takes it.
        nodes: Where it rests [m], shape [node_count, 3].
        parameters: Of pattern and fabric.
    """

    scene: Scene
    friction: Friction | None
    nodes: np.ndarray
    parameters: Parameters

    @classmethod
    def at_rest(cls, scene: Scene, nodes: np.ndarray, parameters: Parameters) -> Laid:
        """Bring the cloth to rest from nodes [m], shape [node_count, 3]."""
        moving = take_time_steps(scene, nodes, steps=25)
        rest = equilibrium(scene, moving.nodes, anchors=moving.anchors, settings=SolveSettings(max_iterations=400))
        return cls(scene, lag_friction(scene, rest.nodes, rest.anchors), rest.nodes, parameters)

    def ends(self, derivative: Derivative, step: np.ndarray, start: np.ndarray, solver: Solver) -> list[np.ndarray]:
        """Return where the cloth ends up with its parameters a step up and a step down, from a start [m]."""
        moved = [self.parameters.move(self.scene, s * step) for s in (1, -1)]
        return [derivative.solve(each, start, solver, friction=self.friction).nodes for each in moved]


def cpu(work: Callable[[], object]) -> tuple[float, object]:
    """Return the CPU time of one run [s] and its result."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def quickest(work: Callable[[], object], repeats: int = 5) -> float:
    """Return the smallest CPU time of a few runs [ms], after one that warms up."""
    work()
    return 1e3 * min(cpu(work)[0] for _ in range(repeats))
