"""Fit the width and the bending stiffness of a skirt to its drape, with torch and the simulator's derivative.

    python examples/fit_by_gradient.py [--steps 25]

A skirt is draped that is wider and stiffer in bending than the base pattern. The fit begins at the base pattern
and minimises the mean squared distance between nodes of both drapes, through the equilibrium
(docs/concepts/simulation.md, Derivatives).
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
import torch
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.cloth.derivative import ImplicitDerivative
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.friction import Friction, lag_friction
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.sensitivity import FABRIC_PARAMETERS
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.cloth.torch_bridge import drape_tensor
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.recover.drape.waist_placement import pin_waist

WIDTH_UNIT = 0.005
"""Change of the width for a parameter of 1: it then displaces the cloth about as far as one of the stiffness does."""

TRUE_PARAMETERS = (1.0, float(np.log(2.0)))
"""Of the target: its width in `WIDTH_UNIT`, and the logarithm of its bending stiffness, both relative to the base
pattern's."""


@dataclass(frozen=True)
class SkirtModel:
    """Describe a skirt on a body whose width and bending stiffness may vary.

    Attributes:
        scene: The base pattern's skirt.
        start: Its nodes at rest [m], shape [node_count, 3].
        friction: Of the start, held constant.
    """

    scene: Scene
    start: torch.Tensor
    friction: Friction | None

    @classmethod
    def at_rest(cls) -> SkirtModel:
        """Drape the base pattern's skirt on the built-in body."""
        garment = load_draped_template("skirt")
        if garment is None:
            raise SystemExit("no drape of the skirt is shipped for this machine's triangulation")
        body = builtin_body("builtin:female,height=1.70")
        grid = DistanceGrid.from_mesh(body.vertices, body.faces)
        scene = Scene(Topology.from_garment(garment), get_fabric(), grid, pin_waist(garment))
        drape = equilibrium(scene, garment.nodes)
        return cls(scene, torch.from_numpy(drape.nodes), lag_friction(scene, drape.nodes, drape.anchors))

    def drape(self, parameters: torch.Tensor) -> torch.Tensor:
        """Return the nodes at rest [m], shape [node_count, 3], for the parameters of width and stiffness, shape [2]."""
        width, stiffness = 1.0 + WIDTH_UNIT * parameters[0], torch.exp(parameters[1])
        corners = torch.from_numpy(self.scene.topology.rest.corners)
        rest = torch.stack([corners[..., 0] * width, corners[..., 1]], dim=-1)
        values = torch.tensor([getattr(self.scene.fabric, name) for name in FABRIC_PARAMETERS], dtype=torch.float64)
        is_bending = torch.tensor([name == "k" for name in FABRIC_PARAMETERS])
        fabric = torch.where(is_bending, values * stiffness, values)
        return drape_tensor(
            self.scene, ImplicitDerivative(), self.start, friction=self.friction, rest=rest, fabric=fabric
        )


def fit(model: SkirtModel, target: torch.Tensor, steps: int) -> tuple[np.ndarray, list[float]]:
    """Return the fitted parameters, shape [2], and the root mean squared distance after each evaluation [m]."""
    parameters = torch.zeros(2, dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.LBFGS([parameters], max_iter=steps, line_search_fn="strong_wolfe")
    distances = []

    def evaluate() -> torch.Tensor:
        optimiser.zero_grad()
        squared = (model.drape(parameters) - target).square().sum(dim=1).mean()
        distances.append(float(squared.detach().sqrt()))
        loss = squared * 1e6  # [mm2]
        loss.backward()
        return loss

    optimiser.step(evaluate)
    return parameters.detach().numpy(), distances


def main() -> None:
    """Fit and print what was found beside what is true."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--steps", type=int, default=25, help="iterations of L-BFGS")
    steps = parser.parse_args().steps
    model = SkirtModel.at_rest()
    with torch.no_grad():
        target = model.drape(torch.tensor(TRUE_PARAMETERS, dtype=torch.float64))
    found, distances = fit(model, target, steps)
    for name, (width, stiffness) in {"found": found, "true": TRUE_PARAMETERS}.items():
        print(f"{name}: {100 * WIDTH_UNIT * width:.2f} % wider, {np.exp(stiffness):.2f} times as stiff")
    print(f"distance: {1e3 * distances[0]:.2f} mm before, {1e3 * min(distances):.3f} mm after {len(distances)} drapes")


if __name__ == "__main__":
    main()
