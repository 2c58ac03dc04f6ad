"""Take the cloth of a frame out of its wearer, as far as it leaves itself room."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...body import ExposedSurface, penetration_depth, pinched_depth, project_outside, untangle_outside, ways_out
from ...cloth import Energy, Scene
from ...cloth.carry_step import carry_free
from ...geometry import self_intersections

CLEARANCE = 1e-3
"""Distance from the skin to which what is nearer goes in the first round [m], as everywhere; after it what is inside
goes to the skin, for layers that are pressed together have no room for more."""

ROUNDS = 12
"""Rounds at most: in each a layer takes four fifths of the room that the next one leaves. A T-shirt between arm and
trunk came from 5.8 mm inside to 3.8 in two, 2.9 in six and 2.0 in twelve."""

LEFT = 1.9e-3
"""Depth beyond which the straight way out is tried too [m], a little under what passes (`measured.DEPTH_MM`): what
crosses then is taken apart by `untangle_outside`, and where it comes apart that is taken, though layers met on the way.
It takes 1 to 8 s, and is tried from where the rounds began and from where they ended: of trousers between thighs
either came apart where the other did not."""

HOPELESS = 2e-2
"""Depth between parts of the wearer that run into each other beyond which cloth is left there [m]: no place is outside
of both. Of a T-shirt 20 to 27 mm deep between arm and trunk no try came apart, at 20 s a frame; what was 3 to 10 mm
deep in the crease under an arm, or between thighs, did."""

DEPTH = 1e-4
"""Depth that stays [m]: nothing of it is seen."""


def take_outside(nodes: np.ndarray, skin: ExposedSurface, scene: Scene) -> np.ndarray:
    """Return a frame's nodes outside the wearer [m], shape [node_count, 3], as far as cloth leaves them room.

    Nodes closer to the skin than a clearance, and faces whose centre is inside, go out as `project_outside` takes them.
    Where parts of the wearer press layers between them all of these go to one place; on the way there what would meet
    is held back (`carry_free`): a little inside the wearer is not seen, cloth that passes through itself is.

    Args:
        nodes: Where the steps left the cloth [m], shape [node_count, 3].
        skin: The wearer.
        scene: The cloth, in contact with itself.
    """
    cloth = scene.self_contact
    assert cloth is not None
    waiting = cloth.wait(self_intersections(nodes, cloth.faces))
    energy, start = Energy(replace(scene, self_contact=waiting)).let_shut(nodes), nodes
    singles, sheets = np.ones(len(nodes), dtype=bool), np.ones(len(cloth.faces), dtype=bool)
    for turn in range(ROUNDS):
        push, (own, middles) = np.zeros_like(nodes), (np.flatnonzero(each) for each in (singles, sheets))
        distance, push[own] = ways_out(nodes[own], skin, CLEARANCE if turn == 0 else 0.0)
        corners = cloth.faces[middles]
        depth, way = ways_out(nodes[corners].mean(axis=1), skin, 0.0)
        for k in range(3):
            node = corners[:, k]
            further = (way**2).sum(axis=1) > (push[node] ** 2).sum(axis=1)
            push[node[further]] = way[further]
        low = -min(float(distance.min(initial=0.0)), float(depth.min(initial=0.0)))
        if not push.any() or (turn > 0 and low < DEPTH):
            break
        before, (energy, nodes) = nodes, carry_free(energy, nodes, nodes + push)
        moved = (nodes != before).any(axis=1)
        singles, sheets = moved.copy(), moved[cloth.faces].any(axis=1)
        singles[own[distance < 0.0]] = sheets[middles[depth < 0.0]] = True
    deep = pinched_depth(nodes, cloth.faces, skin) if low > LEFT else None
    if deep is not None and (deep.free > LEFT or LEFT < deep.way < HOPELESS):
        for origin in (start, nodes):
            through = untangle_outside(
                project_outside(origin, skin, cloth.faces), skin, cloth.faces, allowed=LEFT, limit=LEFT
            )
            if not len(self_intersections(through, cloth.faces)) and (
                penetration_depth(through, cloth.faces, skin) < penetration_depth(nodes, cloth.faces, skin)
            ):
                return through
    return nodes
