"""Dress a body in several garments, each over the one before: all drape together, in contact with each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...body.body import Body
from ...body.exposed import penetration_depth
from ...body.projection import project_outside
from ...body.untangling import untangle_outside
from ...cloth.collision.self_contact import SelfContact
from ...cloth.fabric import Fabric
from ...cloth.layers import stack_garments
from ...cloth.locking import reduce_membrane_stiffness
from ...cloth.pins import Pins
from ...cloth.scene import Scene
from ...cloth.statics import Drape, equilibrium
from ...cloth.topology import Topology
from ...recover.drape.stage import redrape
from ...recover.drape.waist import waist_loop
from ...recover.drape.wearer import WearerGeometry
from ...run.clock import Clock
from ...run.hooks import Hooks
from .dressing import DressedGarment, drape_worn, judge_dressed, transfer_to_body
from .raised_skin import measure_layers, raise_skin_over
from .worn import WornGarment


def dress_over(
    worn: WornGarment, inner: WornGarment, body: Body, fabric: Fabric | None, clock: Clock
) -> DressedGarment:
    """Dress a body in a garment over another one, both at rest together under their weight, patterns unchanged.

    Args:
        worn: The garment above, of a stored result.
        inner: The garment below.
        body: The new wearer.
        fabric: The cloth of the garment above, or None for its own.
        clock: Times the stages.

    Returns:
        The garment above, judged; `inner` is the one below at rest with it.

    Raises:
        Cancelled: where the clock's hooks cancel.
    """
    wearer = WearerGeometry(body)
    with clock.stage("drape", "dressing the body in both garments") as hooks:
        pair = (transfer_to_body(inner, body, None), transfer_to_body(worn, body, fabric))
        (below, above), drape = drape_together(drape_in_order(pair, wearer, hooks), wearer, hooks)
    layers = measure_layers(below.garment, above.garment, wearer.exposed)
    layers["under.body_penetration_mm"] = 1e3 * penetration_depth(
        below.garment.nodes, below.garment.faces, wearer.exposed
    )
    dressed = judge_dressed(worn, above, drape, wearer, clock, layers)
    return replace(dressed, inner=below)


def drape_in_order(garments: Sequence[WornGarment], wearer: WearerGeometry, hooks: Hooks) -> tuple[WornGarment, ...]:
    """Drape garments one after the other, each alone on the wearer raised to those below it.

    Args:
        garments: From the innermost to the outermost, waists on this wearer.
        wearer: The wearer's geometry.
        hooks: Progress and cancellation.

    Returns:
        The garments, each outside of those below it where that is possible.
    """
    innermost, _ = drape_worn(garments[0], wearer, hooks)
    laid, raised = [innermost], wearer
    for above in garments[1:]:
        raised = raise_skin_over(raised, laid[-1].garment)
        if above.waist is not None:
            above = replace(above, waist=project_outside(above.waist, raised.exposed))
        draped, _ = redrape(above.garment, raised, above.fabric, above.target, hooks=hooks)
        laid.append(replace(above, garment=above.garment.at(draped.nodes)))
    return tuple(laid)


def drape_together(
    garments: Sequence[WornGarment], wearer: WearerGeometry, hooks: Hooks
) -> tuple[tuple[WornGarment, ...], Drape]:
    """Bring garments to rest on a wearer, each in its own fabric, in contact with each other and with themselves.

    What still crosses is untangled first. Waists are pinned where they are now, not where each was pinned in its own
    drape: clearing them of the skin moved them by some millimetres, and moving back they would push other layers.

    Args:
        garments: From the innermost to the outermost, nodes near their rest (`drape_in_order`).
        wearer: The wearer's geometry.
        hooks: Progress and cancellation.

    Returns:
        All at rest outside the wearer, and the equilibrium of their joined mesh, in the same order.
    """
    hooks.progress("drape", 0.7, "all garments together")
    starts = np.cumsum([0, *(len(one.garment.nodes) for one in garments)])
    cloths = [reduce_membrane_stiffness(one.fabric) for one in garments]
    topology, layers = stack_garments([Topology.from_garment(one.garment) for one in garments], cloths)
    nodes = np.concatenate([one.garment.nodes for one in garments])
    waists = [(waist_loop(one.garment), start) for one, start in zip(garments, starts, strict=False)]
    rows = np.concatenate([np.zeros(0, dtype=np.int64), *(loop + start for loop, start in waists if loop is not None)])
    pins = Pins(rows, nodes[rows]) if len(rows) else None
    contact = SelfContact.of(topology)
    scene = Scene(topology, cloths[-1], wearer.grid, pins, self_contact=contact, layers=layers)
    drape = equilibrium(scene, nodes, hooks=hooks)
    nodes = project_outside(drape.nodes, wearer.exposed, topology.faces)
    nodes = untangle_outside(nodes, wearer.exposed, topology.faces)
    parts = np.split(nodes, starts[1:-1])
    return tuple(replace(one, garment=one.garment.at(part)) for one, part in zip(garments, parts, strict=True)), drape
