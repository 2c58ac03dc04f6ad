"""Separate the layers of worn cloth that cross each other."""

from __future__ import annotations

import numpy as np

from ...body.projection import project_outside
from ...cloth.collision.self_contact import SelfContact
from ...cloth.locking import reduce_membrane_stiffness
from ...cloth.scene import Scene
from ...cloth.statics import Drape, equilibrium
from ...cloth.topology import Topology
from ...geometry.intersections import self_intersections
from ...recover.drape.waist_placement import pin_waist
from ...recover.drape.wearer import WearerGeometry
from ...run.hooks import SILENT_HOOKS, Hooks
from .worn import WornGarment


def separate_layers(
    worn: WornGarment, wearer: WearerGeometry, drape: Drape, hooks: Hooks = SILENT_HOOKS
) -> tuple[np.ndarray, Drape]:
    """Bring worn cloth that crosses itself to rest anew, untangled and in contact with itself.

    Cloth without crossings is not changed, nor is cloth whose crossed faces do not become fewer.

    Args:
        worn: The garment, nodes at rest on the wearer, outside of it.
        wearer: The wearer's geometry.
        drape: The equilibrium of the nodes.
        hooks: Progress and cancellation.

    Returns:
        Nodes [m], shape [node_count, 3], outside the wearer, and their equilibrium.
    """
    garment = worn.garment
    crossed = len(self_intersections(garment.nodes, garment.faces))
    if not crossed:
        return garment.nodes, drape
    hooks.progress("drape", 0.8, "parting layers that cross")
    topology, pins = Topology.from_garment(garment), pin_waist(garment, worn.target)
    contact = SelfContact.of(topology)
    scene = Scene(
        topology, reduce_membrane_stiffness(worn.fabric), wearer.grid, pins, worn.rotation, self_contact=contact
    )
    parted = equilibrium(scene, garment.nodes, hooks=hooks)
    nodes = project_outside(parted.nodes, wearer.exposed, garment.faces)
    if len(self_intersections(nodes, garment.faces)) >= crossed:
        return garment.nodes, drape
    return nodes, parted
