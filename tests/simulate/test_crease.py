"""Cloth that has sunk into a crease of the body, as between two thighs that touch."""

from __future__ import annotations

import numpy as np
from garmentq.core.body import DistanceGrid
from garmentq.core.pattern import Edge, Panel, Pattern, mesh_pattern
from garmentq.core.simulate import Scene, Topology, equilibrium, get_fabric, soften

SIDE = 0.3
"""Side of the cloth [m]."""

STEEP = np.radians(75.0)
"""Slope of the two walls."""


def test_cloth_in_a_crease_comes_to_rest() -> None:
    """Breaks if friction's forces are taken anew for ever: they chase the nodes from wall to wall, by 0.5 mm a leg."""
    square = SIDE * (np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) - 0.5)
    cloth = mesh_pattern(Pattern("square", (Panel("square", square, (Edge(),) * 4),), ()), 200)
    across, up = np.arange(-0.3, 0.301, 0.01), np.arange(-0.15, 0.35, 0.01)
    x, y, _ = np.meshgrid(across, up, across, indexing="ij")
    wall = np.cos(STEEP) * y - np.sin(STEEP) * np.abs(x)
    grid = DistanceGrid.from_values(np.array([across[0], up[0], across[0]]), 0.01, wall)
    flat = np.zeros((len(cloth.nodes), 2))
    flat[cloth.uv_node] = cloth.uv
    nodes = np.stack([flat[:, 0] * np.cos(STEEP), np.abs(flat[:, 0]) * np.sin(STEEP) + 0.006, flat[:, 1]], axis=1)
    drape = equilibrium(Scene(Topology.from_garment(cloth), soften(get_fabric("cotton_poplin")), grid), nodes)
    assert drape.converged and drape.iterations < 60
    assert drape.residual < 0.1
