"""Part the layers of worn cloth that pass through each other."""

from __future__ import annotations

import numpy as np

from ..body import project_outside
from ..drape import WearerGeometry, pin_waist
from ..hooks import SILENT, Hooks
from ..mesh import self_intersections
from ..pattern import Garment
from ..segment import Target
from ..simulate import Drape, Fabric, Scene, SelfContact, Topology, equilibrium, soften


def part_layers(
    garment: Garment, wearer: WearerGeometry, fabric: Fabric, target: Target, drape: Drape, hooks: Hooks = SILENT
) -> tuple[np.ndarray, Drape]:
    """Bring worn cloth that crosses itself to rest anew, in contact with itself and untangled first.

    Cloth that crosses itself nowhere stays as it is, and so does cloth of which as many faces cross after that.

    Args:
        garment: The garment, nodes at rest on the wearer, outside of it.
        wearer: The wearer's geometry.
        fabric: The cloth.
        target: Where its waist, if any, holds the garment's.
        drape: The equilibrium that the nodes are of.
        hooks: Progress and cancellation.

    Returns:
        Nodes [m], shape [node_count, 3], outside the wearer, and the equilibrium that they are of.
    """
    crossed = len(self_intersections(garment.nodes, garment.faces))
    if not crossed:
        return garment.nodes, drape
    hooks.progress("drape", 0.8, "parting layers that cross")
    topology, pins = Topology.from_garment(garment), pin_waist(garment, target)
    scene = Scene(topology, soften(fabric), wearer.grid, pins, self_contact=SelfContact.of(topology))
    parted = equilibrium(scene, garment.nodes, hooks=hooks)
    nodes = project_outside(parted.nodes, wearer.exposed, garment.faces)
    if len(self_intersections(nodes, garment.faces)) >= crossed:
        return garment.nodes, drape
    return nodes, parted
