"""Dress a body in two garments, one over the other: both drape together, in contact with each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..body import Body, penetration_depth, project_outside, untangle_outside
from ..clock import Clock
from ..drape import WearerGeometry, pin_waist, redrape
from ..hooks import Hooks
from ..simulate import Drape, Fabric, Pins, Scene, SelfContact, Topology, equilibrium, lay_over, soften
from .dressing import Dressed, carry_worn, drape_worn, judge_dressed
from .underneath import measure_layers, raise_over
from .worn import Worn


def dress_over(worn: Worn, under: Worn, body: Body, fabric: Fabric | None, clock: Clock) -> Dressed:
    """Dress a body in a garment over another one, both at rest together under their weight, patterns unchanged.

    The garment below is draped alone. The one above is dressed on the body raised to it, then both come to rest on the
    body itself, each with its own fabric, in contact with each other and with themselves; what still crosses is
    untangled first.

    Args:
        worn: The garment above, as a result keeps it.
        under: The garment below.
        body: Who wears them now.
        fabric: The cloth of the garment above, or None for its own.
        clock: Times the stages.

    Returns:
        The garment above, judged; `under` is the one below at rest with it.

    Raises:
        Cancelled: as soon as the clock's hooks say so.
    """
    wearer = WearerGeometry(body)
    with clock.stage("drape", "dressing the body in both garments") as hooks:
        below, _ = drape_worn(carry_worn(under, body, None), wearer, hooks)
        raised = raise_over(wearer, below.garment)
        above = carry_worn(worn, body, fabric)
        if above.waist is not None:
            above = replace(above, waist=project_outside(above.waist, raised.exposed))
        nodes, _ = redrape(above.garment, raised, above.fabric, above.target, hooks=hooks)
        above = replace(above, garment=above.garment.at(nodes))
        below, above, drape = rest_together(below, above, wearer, hooks)
    layers = measure_layers(below.garment, above.garment)
    layers["under.body_penetration_mm"] = 1e3 * penetration_depth(
        below.garment.nodes, below.garment.faces, wearer.exposed
    )
    dressed = judge_dressed(worn, above, drape, wearer, clock, layers)
    return replace(dressed, under=below)


def rest_together(below: Worn, above: Worn, wearer: WearerGeometry, hooks: Hooks) -> tuple[Worn, Worn, Drape]:
    """Bring two garments to rest on a wearer, in contact with each other and with themselves.

    Args:
        below: The garment below, nodes near its rest.
        above: The garment above, nodes outside of the one below but where they cannot be.
        wearer: The wearer's geometry.
        hooks: Progress and cancellation.

    Returns:
        Both at rest outside the wearer, and the equilibrium of their joined mesh, the one below first.
    """
    hooks.progress("drape", 0.7, "both garments")
    pair, first = (below, above), len(below.garment.nodes)
    cloths = [soften(one.fabric) for one in pair]
    topology, layers = lay_over([Topology.from_garment(one.garment) for one in pair], cloths)
    held = [pin_waist(one.garment, one.target) for one in pair]
    places = [Pins(pins.nodes + start, pins.points) for pins, start in zip(held, (0, first), strict=True) if pins]
    pins = None
    if places:
        pins = Pins(np.concatenate([one.nodes for one in places]), np.concatenate([one.points for one in places]))
    contact = SelfContact.of(topology)
    scene = Scene(topology, cloths[-1], wearer.grid, pins, self_contact=contact, layers=layers)
    drape = equilibrium(scene, np.concatenate([one.garment.nodes for one in pair]), hooks=hooks)
    nodes = project_outside(drape.nodes, wearer.exposed, topology.faces)
    nodes = untangle_outside(nodes, wearer.exposed, topology.faces)
    parts = (nodes[:first], nodes[first:])
    rest = [replace(one, garment=one.garment.at(part)) for one, part in zip(pair, parts, strict=True)]
    return rest[0], rest[1], drape
