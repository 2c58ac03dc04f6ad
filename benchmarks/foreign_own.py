"""Draft garments from our own parts, from seeds, for the body of a target pack: what `foreign_drapes.py` drapes beside
the drafts of `foreign_draft.py`.

    python benchmarks/foreign_own.py BODY.ply OUT --seed 3000

Each garment is a folder with `specification.json` and `design.json`: category, seed, the cut by its name and its parts.
Girths are wider than the body's and heights further apart by drawn factors, since nobody wears what was drafted for him
to the millimetre; a waist that hangs from the body is close.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import trimesh
from garmentq.core.body.registration import register_body
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.parts.cut import PARTS, PartsConflict
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.templates import draft_template, find_cut, load_template, name_cut
from garmentq.core.recover.drape.sizing import measure_wearer

ORDER = {
    "skirt": 2, "trousers": 1, "shorts": 1, "long_sleeve_tshirt": 1, "jumpsuit": 1, "dress": 1, "tshirt": 1,
}  # fmt: skip
"""Garments by category."""

DRAWN = ("neckline", "back_neckline", "sleeve", "skirt", "legs", "waist", "waistband", "shaping")
"""Parts of which up to three are chosen anew."""

EASE, CLOSE = (1.02, 1.08), (1.0, 1.03)
"""Between which factors a girth, and the waist that holds a garment up, are drawn."""


def draw_cut(category: str, rng: np.random.Generator) -> str:
    """Draw the name of a cut of a category."""
    stems = [stem for stem, cut in CUTS.items() if cut.category == category]
    while True:
        stem = str(rng.choice(stems))
        places = [part for part in DRAWN if CUTS[stem].has_place_for(part)]
        changed = rng.permutation(places)[: rng.integers(0, 4)]
        cut = CUTS[stem].choose({str(part): str(rng.choice([str(word) for word in PARTS[part]])) for part in changed})
        try:
            if cut.category == category:
                load_template(name_cut(stem, cut))
                return name_cut(stem, cut)
        except PartsConflict:
            continue


def draw_measures(body: BodyMeasures, rng: np.random.Generator, *, hangs_from_waist: bool) -> BodyMeasures:
    """Draw the measures that a garment is drafted for, around the body's."""
    waist = CLOSE if hangs_from_waist else EASE
    return replace(
        body,
        bust=body.bust * rng.uniform(*EASE),
        waist=body.waist * rng.uniform(*waist),
        hip=body.hip * rng.uniform(*EASE),
        shoulder_half_width=body.shoulder_half_width * rng.uniform(*CLOSE),
    )


def main() -> None:
    """Draft all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("body", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", type=int, default=3000, help="Of the first garment; each has the next one.")
    given = parser.parse_args()
    mesh = trimesh.load(given.body, process=False)
    own = measure_wearer(register_body(np.asarray(mesh.vertices), np.asarray(mesh.faces), name="body"))
    seed = given.seed
    for category, count in ORDER.items():
        for _ in range(count):
            rng = np.random.default_rng(seed)
            name = draw_cut(category, rng)
            cut = find_cut(name)
            measures = draw_measures(own, rng, hangs_from_waist=str(cut.bodice) == "none")
            folder = given.out / f"own_{category}_{seed}"
            folder.mkdir(parents=True, exist_ok=True)
            save_pattern(draft_template(name, measures), folder / "specification.json")
            told = {
                "category": category, "seed": seed, "cut": name, "measures": asdict(measures),
                "parts": {part: str(getattr(cut, part)) for part in PARTS},
                "source": {"kind": "own parts"}, "licence": "Apache-2.0",
            }  # fmt: skip
            (folder / "design.json").write_text(json.dumps(told, indent=1))
            print(folder.name, name, flush=True)
            seed += 1


if __name__ == "__main__":
    main()
