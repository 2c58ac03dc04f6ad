"""The simulator as one differentiable operation of torch."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import torch

from .derivative import Derivative
from .friction import Friction
from .scene import Scene
from .sensitivity import FABRIC_PARAMETERS

__all__ = ["drape_tensor"]


class _Drape(torch.autograd.Function):
    """Solve forwards; pull a gradient back through the solution."""

    @staticmethod
    def forward(
        ctx: Any, rest: torch.Tensor, fabric: torch.Tensor, pins: torch.Tensor, start: torch.Tensor, solution: Any
    ) -> torch.Tensor:
        """Solve for the positions at which `solution`'s derivative is taken."""
        scene, derivative, frozen = solution
        values = dict(zip(FABRIC_PARAMETERS, _array(fabric).tolist(), strict=True))
        scene = replace(scene, topology=scene.topology.reshape(_array(rest)), fabric=replace(scene.fabric, **values))
        if scene.pins is not None:
            scene = replace(scene, pins=replace(scene.pins, points=_array(pins)))
        ctx.response = derivative.solve(scene, _array(start), friction=frozen)
        return torch.from_numpy(ctx.response.nodes.copy())

    @staticmethod
    def backward(ctx: Any, *upstream: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        """Pull the gradient by the positions back to all inputs."""
        found = ctx.response.pull(_array(upstream[0]))
        return (*(torch.from_numpy(part) for part in (found.rest, found.fabric, found.pins, found.start)), None)


def drape_tensor(
    scene: Scene,
    derivative: Derivative,
    start: torch.Tensor,
    *,
    friction: Friction | None = None,
    rest: torch.Tensor | None = None,
    fabric: torch.Tensor | None = None,
    pins: torch.Tensor | None = None,
) -> torch.Tensor:
    """Return draped positions [m], shape [node_count, 3], float64, through which torch can differentiate. What is not
    given is taken from the scene; friction is constant. `rest`: flat triangles [m], shape [face_count, 3, 2], as
    `map_rest` makes them from uv. `fabric`: the values of `FABRIC_PARAMETERS`, shape [6]. `pins`: pinned points [m],
    shape [pin_count, 3]. Each call has its own solver, so that one graph may have several calls and can be walked back
    repeatedly."""
    points = np.zeros((0, 3)) if scene.pins is None else np.asarray(scene.pins.points, dtype=np.float64)
    values = np.array([getattr(scene.fabric, name) for name in FABRIC_PARAMETERS])
    inputs = [(rest, scene.topology.rest.corners), (fabric, values), (pins, points)]
    tensors = [torch.from_numpy(np.array(value)) if tensor is None else tensor for tensor, value in inputs]
    return _Drape.apply(*tensors, start, (scene, derivative, friction))  # type: ignore[no-any-return, no-untyped-call]


def _array(tensor: torch.Tensor) -> np.ndarray:
    """Return a tensor's values as float64."""
    return np.asarray(tensor.detach().cpu().numpy(), dtype=np.float64)
