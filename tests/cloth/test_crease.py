"""Cloth that has sunk into a crease of the body, as between two thighs that touch."""

from __future__ import annotations

import numpy as np
import trimesh
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.body.exposed import ExposedSurface, penetration_depth
from garmentq.core.body.projection import project_outside
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.locking import reduce_membrane_stiffness
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.geometry.intersections import self_intersections

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
    drape = equilibrium(
        Scene(Topology.from_garment(cloth), reduce_membrane_stiffness(get_fabric("cotton_poplin")), grid), nodes
    )
    assert drape.converged and drape.iterations < 60
    assert drape.residual < 0.1


def test_cloth_draped_over_touching_limbs_is_delivered_outside() -> None:
    """Breaks where cloth that rests by the grid, which blurs a crease, is cleared of the nearest skin only."""
    limbs = [trimesh.creation.capsule(height=0.3, radius=0.08, count=[32, 32]) for _ in range(2)]
    for limb, x in zip(limbs, (-0.078, 0.078), strict=True):
        limb.apply_translation([x, 0.0, -0.15])
    both = trimesh.util.concatenate(limbs)
    vertices, faces = np.array(both.vertices), np.array(both.faces)
    square = SIDE * (np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) - 0.5)
    cloth = mesh_pattern(Pattern("square", (Panel("square", square, (Edge(),) * 4),), ()), 200)
    flat = np.zeros((len(cloth.nodes), 2))
    flat[cloth.uv_node] = cloth.uv
    nodes = np.stack([flat[:, 0], np.full(len(flat), 0.09), flat[:, 1]], axis=1)
    grid, skin = DistanceGrid.from_mesh(vertices, faces), ExposedSurface(vertices, faces)
    drape = equilibrium(
        Scene(Topology.from_garment(cloth), reduce_membrane_stiffness(get_fabric("cotton_poplin")), grid), nodes
    )
    moved = project_outside(drape.nodes, skin, cloth.faces)
    assert penetration_depth(moved, cloth.faces, skin) < 1e-3
    assert len(self_intersections(moved, cloth.faces)) <= len(self_intersections(drape.nodes, cloth.faces))
    clear = skin.measure(drape.nodes)[0] > 0.02
    assert clear.any() and np.array_equal(moved[clear], drape.nodes[clear])
