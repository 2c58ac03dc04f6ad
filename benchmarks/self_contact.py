"""Self-contact's cost: sheets with and without it in turns, where nothing is near and where sheets lie on sheets.

python benchmarks/self_contact.py [--side 1K|3K|8K] [--layers N] [--garment NAME]...

A garment is a shipped template, which comes to rest in denim from where it hangs in poplin.
"""

from __future__ import annotations

from dataclasses import replace

import click
import numpy as np
from garmentq.core.cloth.collision.near_pairs import find_candidates, find_near_pairs
from garmentq.core.cloth.collision.self_contact import SelfContact
from garmentq.core.cloth.dynamics import ClothState, continue_time_steps
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.drape.waist_placement import pin_waist
from garmentq.core.recover.drape.wearer import WearerGeometry
from sheet import SIDES, cpu, quickest, sheet_on_ball
from worn_template import load_worn_template

STEPS = 10


def stack(scene: Scene, nodes: np.ndarray, layers: int) -> tuple[Scene, np.ndarray]:
    """Lay sheets on each other, 4 mm apart and each 2 mm aside, as pieces of one cloth."""
    topology, count = scene.topology, len(nodes)
    faces = np.concatenate([topology.faces + k * count for k in range(layers)])
    several = Topology.from_mesh(faces, np.tile(topology.rest.corners, (layers, 1, 1)))
    shift = np.array([2e-3, 4e-3, -2e-3])
    return replace(scene, topology=several), np.concatenate([nodes + k * shift for k in range(layers)])


def compare(name: str, scene: Scene, nodes: np.ndarray) -> None:
    """Take time steps and an equilibrium with and without self-contact in turns; print CPU seconds and crossings."""
    kinds = {"off": scene, "on": replace(scene, self_contact=SelfContact.of(scene.topology))}
    start = ClothState(nodes, np.zeros_like(nodes), nodes)
    spent: dict[str, list[float]] = {"off": [], "on": []}
    ends: dict[str, np.ndarray] = {}
    for turn in range(3):
        for kind, each in kinds.items():
            moving, state = cpu(lambda each=each: continue_time_steps(each, start, steps=STEPS))
            resting, drape = cpu(lambda each=each, state=state: equilibrium(each, state.nodes, anchors=state.anchors))
            if turn:  # the first one warms up
                spent[kind].append(np.array([moving, resting, drape.iterations]))
            ends[kind] = drape.nodes
    least = {kind: np.min(found, axis=0) for kind, found in spent.items()}
    for kind, (moving, resting, legs) in least.items():
        crossed = len(self_intersections(ends[kind], scene.topology.faces))
        click.echo(
            f"{name} {len(nodes)} nodes, {kind}: {1e3 * moving / STEPS:.0f} ms a step, equilibrium {resting:.2f} s in "
            f"{legs:.0f} legs, {crossed} faces cross"
        )
    ratio = least["on"] / least["off"]
    cloth, at, step = kinds["on"].self_contact, ends["on"], 1e3 * least["on"][0] / STEPS
    search = quickest(lambda: find_near_pairs(cloth, at))
    broad = quickest(lambda: find_candidates(cloth, at[None], 2.0 * cloth.margin))
    click.echo(
        f"{name}: on / off {ratio[0]:.2f} a step, {ratio[1]:.2f} to rest; one search {search:.2f} ms, "
        f"{100 * search / step:.1f} % of a step, of which pairs of boxes {broad:.2f} ms, {100 * broad / step:.1f} %"
    )


def hang(name: str) -> tuple[Scene, np.ndarray]:
    """Return the scene of a shipped garment in denim, and where it hangs in poplin [m]."""
    worn = load_worn_template(name, get_fabric("denim"))
    if worn is None:
        raise SystemExit("no drape is shipped for this machine's triangulation")
    grid = WearerGeometry(worn.body).grid
    return Scene(Topology.from_garment(worn.garment), worn.fabric, grid, pin_waist(worn.garment)), worn.garment.nodes


@click.command()
@click.option("--side", type=click.Choice(list(SIDES)), default="1K", help="Nodes of a sheet.")
@click.option("--layers", default=3, help="Sheets of the stack.")
@click.option("--garment", multiple=True, help="A shipped template, in place of the sheets.")
def main(side: str, layers: int, garment: tuple[str, ...]) -> None:
    """Compare one sheet, where nothing is near, and a stack; or garments."""
    for name in garment:
        compare(name, *hang(name))
    if garment:
        return
    scene, nodes, _ = sheet_on_ball(SIDES[side])
    compare("sheet", scene, nodes)
    compare("stack", *stack(scene, nodes, layers))


if __name__ == "__main__":
    main()
