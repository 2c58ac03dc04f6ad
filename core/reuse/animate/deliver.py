"""Move the cloth of a frame out of its wearer, as far as its layers leave room."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...body.exposed import ExposedSurface, penetration_depth, pinched_depth
from ...body.projection import exit_displacements, project_outside
from ...body.untangling import SeparationSettings, untangle_outside
from ...cloth.carry_step import move_collision_free
from ...cloth.energy import Energy
from ...cloth.scene import Scene
from ...geometry.intersections import self_intersections


@dataclass(frozen=True)
class PushSettings:
    """Describe how a frame's cloth is moved out of its wearer.

    Attributes:
        clearance: Distance from the skin to which nearer cloth moves in the first iteration [m], as in drapes. Later,
            cloth inside the body moves to the skin only: layers that are pressed together have no room for more.
        iterations: Largest number of iterations. In each a layer takes four fifths of the room before the next one. A
            T-shirt between arm and trunk came from 5.8 mm inside to 3.8 in two, 2.9 in six and 2.0 in twelve.
        tolerance: Depth in the body that is not corrected [m]; it is not visible.
        remaining: Depth beyond which the direct way out is tried too [m], a little less than what passes
            (`MAX_MOTION_DEPTH_MM` in `measured.py`). `untangle_outside` then untangles what crosses. If it succeeds the
            result is taken, though layers met on the way. It takes 1 to 8 s, and is tried both from the nodes before
            the iterations and after them: for trousers between thighs each succeeded where the other did not.
        pinch: Depth between intersecting parts of the wearer beyond which cloth is left there [m], as no place is
            outside of both. For a T-shirt 20 to 27 mm deep between arm and trunk no try succeeded, at 20 s a frame.
            Tries succeeded for cloth 3 to 10 mm deep in the crease under an arm, or between thighs.
    """

    clearance: float = 1e-3
    iterations: int = 12
    tolerance: float = 1e-4
    remaining: float = 1.9e-3
    pinch: float = 2e-2


def resolve_penetration(
    nodes: np.ndarray, skin: ExposedSurface, scene: Scene, settings: PushSettings = PushSettings()
) -> np.ndarray:
    """Move a frame's nodes out of the wearer [m], shape [node_count, 3], as far as its layers leave room.

    Nodes closer to the skin than a clearance, and faces whose centre is inside, move out as in `project_outside`. Where
    parts of the wearer press layers together, all of them move to one place; cloth that would cross on the way stops
    (`move_collision_free`), since a small depth in the wearer is not visible but crossing cloth is.

    Args:
        nodes: The cloth after the steps [m], shape [node_count, 3].
        skin: The wearer.
        scene: The cloth, in contact with itself.
        settings: Iterations and their end.
    """
    cloth = scene.self_contact
    assert cloth is not None
    waiting = cloth.wait(self_intersections(nodes, cloth.faces))
    energy, start = Energy(replace(scene, self_contact=waiting)).suspend_coincident(nodes), nodes
    singles, sheets = np.ones(len(nodes), dtype=bool), np.ones(len(cloth.faces), dtype=bool)
    for turn in range(settings.iterations):
        push, (single, middles) = np.zeros_like(nodes), (np.flatnonzero(each) for each in (singles, sheets))
        distance, push[single] = exit_displacements(nodes[single], skin, settings.clearance if turn == 0 else 0.0)
        corners = cloth.faces[middles]
        depth, displacement = exit_displacements(nodes[corners].mean(axis=1), skin, 0.0)
        for k in range(3):
            node = corners[:, k]
            further = (displacement**2).sum(axis=1) > (push[node] ** 2).sum(axis=1)
            push[node[further]] = displacement[further]
        low = -min(float(distance.min(initial=0.0)), float(depth.min(initial=0.0)))
        if not push.any() or (turn > 0 and low < settings.tolerance):
            break
        before, (energy, nodes) = nodes, move_collision_free(energy, nodes, nodes + push)
        moved = (nodes != before).any(axis=1)
        singles, sheets = moved.copy(), moved[cloth.faces].any(axis=1)
        singles[single[distance < 0.0]] = sheets[middles[depth < 0.0]] = True
    deep = pinched_depth(nodes, cloth.faces, skin) if low > settings.remaining else None
    if deep is not None and (deep.free > settings.remaining or settings.remaining < deep.exit < settings.pinch):
        for origin in (start, nodes):
            out = project_outside(origin, skin, cloth.faces)
            depths = SeparationSettings(allowed=settings.remaining, limit=settings.remaining)
            through = untangle_outside(out, skin, cloth.faces, depths)
            if not len(self_intersections(through, cloth.faces)) and (
                penetration_depth(through, cloth.faces, skin) < penetration_depth(nodes, cloth.faces, skin)
            ):
                return through
    return nodes
