"""Simulate dressed persons and their scans: `python -m garmentq.training.persons --out DIR --count 100`.

A person is drawn by a seed, dressed once in the T-pose, and scanned in several poses, each with cuts, hair, shoes and a
scanner of its own. Each scan is a file, `persons/00012_1.npz`; what is there is not made again.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from ..core.body.body import Body
from ..core.body.distance import DistanceGrid
from ..core.body.template import Template, load_template
from ..core.people.part import GARMENTS, Part
from .accessories import bare_skin, draw_accessories
from .cloth import hide_skin
from .designs import Piece, draw_outfit
from .outfits import HELD_OUT_OUTFITS, TRAINED_OUTFITS, Outfit, load_outfits, wear_outfit
from .scanner import draw_scanner, scan_person
from .shards import Shard, save_shard
from .shells import Shell, draw_leggings, draw_tight_suit, draw_tight_top, draw_underwear, wear_shell
from .wardrobe import Layer, cover, grid_of, put_on, take_pose
from .wearer import at_rest, draw_pose, draw_wearer, stand

REVISION = 4
"""Counts up where the same seed gives other persons."""


def simulate(seed: int, scans: int, held_out: bool = False, finished: bool = False) -> Iterator[Shard]:
    """Yield the scans of one person.

    Args:
        seed: The person.
        scans: How many times he is scanned, each in a pose of its own.
        held_out: Dress him in designs that are kept for measuring.
        finished: Yield nothing where no garment has a collar, a hood or a front of its own.
    """
    rng = np.random.default_rng([REVISION, seed])
    gender, template, shape = draw_wearer(load_template(), rng)
    rest = at_rest(stand(template, shape, np.zeros((24, 3))))
    shells, pieces = draw_clothes(rest, gender, rng, held_out)
    if finished and not any(piece.is_finished for piece in pieces):
        return
    worn = put_on(pieces, rest)
    if (pieces and not worn) or (finished and not any(one.piece.is_finished for one in worn)):
        return

    def wear(body: Body, grid: DistanceGrid, rng: np.random.Generator) -> list[Layer]:
        return cover([*(wear_shell(shell, body, rng) for shell in shells), *take_pose(worn, body, grid, rng)])

    for scan in range(scans):
        own = np.random.default_rng([REVISION, seed, scan])
        shard, about = _scan(template, shape, wear, own)
        about |= {"seed": seed, "scan": scan, "gender": gender, "held_out": held_out}
        about["garments"] = [*(shell.name for shell in shells), *(one.piece.template for one in worn)]
        yield replace(shard, about=about)


LITTLE, TIGHT_SUIT, TIGHT_TOP, LEGGINGS = 0.08, 0.03, 0.1, 0.12
"""Shares of persons who wear underwear at most, a tight suit, and of tops and bottoms in two pieces that are tight."""


def draw_clothes(rest: Body, gender: str, rng: np.random.Generator, held_out: bool) -> tuple[list[Shell], list[Piece]]:
    """Draw what lies on the skin, and the garments that are draped over it, the innermost first.

    Args:
        rest: The wearer in the T-pose.
        gender: `female`, `male` or `child`.
        rng: The generator.
        held_out: Draw designs that are kept for measuring.
    """
    kind = rng.random()
    if not held_out and kind < LITTLE:
        return draw_underwear(rest, gender, rng), []
    if not held_out and kind < LITTLE + TIGHT_SUIT:
        return [draw_tight_suit(rest, rng)], []
    shells, pieces = draw_underwear(rest, gender, rng), draw_outfit(rest, rng, held_out)
    inner = {piece.part for piece in pieces if piece.part is not Part.OUTER}
    if held_out or inner != {Part.UPPER, Part.LOWER}:
        return shells, pieces
    if rng.random() < LEGGINGS:
        shells.append(draw_leggings(rest, rng))
        pieces = [piece for piece in pieces if piece.part is not Part.LOWER]
    if rng.random() < TIGHT_TOP:
        shells.append(draw_tight_top(rest, rng))
        pieces = [piece for piece in pieces if piece.part is not Part.UPPER]
    return shells, pieces


def simulate_outfit(seed: int, scans: int, outfits: dict[str, Outfit]) -> Iterator[Shard]:
    """Yield the scans of one person in one of the outfits that were modelled by hand."""
    rng = np.random.default_rng([REVISION, seed])
    gender, template, shape = draw_wearer(load_template(), rng)
    name = sorted(outfits)[seed % len(outfits)]

    def wear(body: Body, grid: DistanceGrid, rng: np.random.Generator) -> list[Layer]:
        return wear_outfit(load_template(), body, outfits[name])

    for scan in range(scans):
        shard, about = _scan(template, shape, wear, np.random.default_rng([REVISION, seed, scan]))
        about |= {"seed": seed, "scan": scan, "gender": gender}
        about |= {"held_out": name in HELD_OUT_OUTFITS, "garments": [name]}
        yield replace(shard, about=about)


Wear = Callable[[Body, DistanceGrid, np.random.Generator], list[Layer]]
"""From a body in its pose, the distance to it and a generator to what is worn."""


def _scan(template: Template, shape: np.ndarray, wear: Wear, rng: np.random.Generator) -> tuple[Shard, dict]:
    """Pose, dress and scan a person."""
    pose, body = draw_pose(template, shape, rng)
    layers = wear(body, grid_of(body), rng)
    layers += draw_accessories(load_template(), body, layers, rng)
    skin = bare_skin(body, layers)
    for layer in layers:
        if layer.part in (*GARMENTS, Part.SKIN):
            skin = hide_skin(skin, layer.mesh)
    layers.append(Layer(Part.SKIN, skin, is_cloth=False))
    scanner = draw_scanner(rng)
    shard = scan_person(layers, body, scanner, rng)
    parts = sorted({int(part) for part in np.unique(shard.label)})
    return shard, {
        "pose": pose,
        "parts": parts,
        "scanner": scanner.__dict__,
        "materials": [name_material(layer) for layer in layers],
    }


def name_material(layer: Layer) -> tuple[int, str]:
    """Return a surface's part and what it is made of: `skin`, `hair` or `cloth`."""
    if layer.part is Part.HAIR:
        return int(layer.part), "hair"
    return int(layer.part), "cloth" if layer.is_cloth else "skin"


Simulate = Callable[[int, int], Iterator[Shard]]
"""From a seed and a number of scans to these."""


def write_persons(out: Path, seeds: range, scans: int, simulate: Simulate, limit: float | None = None) -> int:
    """Write the scans of some persons that are not there yet, and return their number.

    Args:
        out: The folder.
        seeds: Which persons.
        scans: Scans of each.
        simulate: How a person is simulated.
        limit: Stop after so many seconds.
    """
    out.mkdir(parents=True, exist_ok=True)
    start, count = time.monotonic(), 0
    for seed in seeds:
        if limit is not None and time.monotonic() - start > limit:
            break
        if (out / f"{seed:05d}_{scans - 1}.npz").exists() or (out / f"{seed:05d}.none").exists():
            continue
        cpu = time.process_time()
        made = list(simulate(seed, scans))
        for shard in made:
            save_shard(shard, out / f"{seed:05d}_{shard.about['scan']}.npz")
        if not made:
            (out / f"{seed:05d}.none").touch()
        count += len(made)
        print(f"{seed} {time.process_time() - cpu:.1f} s {made[0].about['garments'] if made else 'none'}", flush=True)
    return count


def main() -> None:
    """Write persons."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, required=True, help="folder for the scans")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--count", type=int, default=100, help="persons")
    parser.add_argument("--scans", type=int, default=2, help="scans of each")
    parser.add_argument("--held-out", action="store_true", help="designs that are kept for measuring")
    parser.add_argument("--finished", action="store_true", help="those alone who wear a collar, a hood or a front")
    parser.add_argument("--outfits", type=Path, help="folder of CC0 outfits to wear instead: base.obj and clothes")
    parser.add_argument("--limit", type=float, help="stop after so many seconds")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.count)
    how: Simulate = partial(simulate, held_out=options.held_out, finished=options.finished)
    if options.outfits:
        names = HELD_OUT_OUTFITS if options.held_out else TRAINED_OUTFITS
        how = partial(simulate_outfit, outfits=load_outfits(options.outfits, names))
    write_persons(options.out, seeds, options.scans, how, options.limit)


if __name__ == "__main__":
    main()
