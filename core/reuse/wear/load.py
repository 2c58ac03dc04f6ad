"""Measure the load of worn cloth: its strain, and its pressure on the body."""

from __future__ import annotations

import numpy as np

from ...cloth.contact import contact_forces
from ...cloth.scene import Scene
from ...cloth.topology import Topology
from ...geometry.geometry import deformation_gradients, lump, principal_stretches
from ...recover.drape.wearer import WearerGeometry
from .worn import WornGarment


def measure_strain(worn: WornGarment) -> np.ndarray:
    """Return the largest principal strain of the cloth at each node, 0 where it is as cut, shape [node_count]. It is
    the mean over the faces around a node, by their flat areas; negative where the cloth is compressed."""
    garment = worn.garment
    stretch = principal_stretches(deformation_gradients(garment.nodes, garment.faces, garment.rest))[:, 0]
    sides = garment.rest[:, 1:] - garment.rest[:, :1]
    areas = 0.5 * np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    count = len(garment.nodes)
    whole = lump(areas, garment.faces, count)
    return np.asarray(lump(areas * (stretch - 1.0), garment.faces, count) / np.maximum(whole, 1e-15))


def measure_pressure(worn: WornGarment, wearer: WearerGeometry) -> np.ndarray:
    """Return the pressure of the cloth on its wearer at each node [Pa], shape [node_count]."""
    scene = Scene(Topology.from_garment(worn.garment), worn.fabric, wearer.grid)
    forces = contact_forces(scene, worn.garment.nodes)
    return np.asarray(forces.size / scene.topology.rest.node_areas)
