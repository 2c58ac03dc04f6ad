"""Count how often the cut is chosen right: drapes of drawn cuts on drawn bodies, read as scans.

Each case is a cut drawn with a seed from the parts, drafted for other measures than the wearer's, dressed on a drawn
built-in body by the position-based drape, roughened by the noise of a scanner, and named as a scan's garment. The
choice is told surface and body. Drapes are kept in a folder, so that only the choice runs again.

Run with one thread:
OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/cut_choice.py [--seed 0] [--cases 60] --out FOLDER
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.parts.cut import Cut
from garmentq.core.garment.parts.draft import draft_cut
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.templates import find_cut, name_cut
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.grade.choice import choose_cut
from garmentq.core.run.errors import BadInput, GarmentqError
from garmentq.core.scan.contours.garment import segment_garment
from garmentq.core.scan.contours.target import Target
from garmentq.core.scan.scan import Scan

VERTICES = 1500
"""Of a drape: edges of 25 mm."""

NOISE = 0.001
"""Standard deviation of every coordinate [m]."""

GIRTHS, DEPTHS = (1.0, 1.08), (1.0, 1.06)
"""Between which factors of the wearer's the girths, and the heights from one to the next, are drawn: few garments are
made for their wearer."""

NECKS = ("crew", "scoop", "v", "square")
SLEEVES = ("none", "cap", "short", "elbow", "long")
SWEEPS = ("half-circle", "full-circle", "gathered")
"""Skirts that are not cut in one with a bodice."""

JUDGED = ("neckline", "sleeve", "skirt", "legs", "waist", "bodice", "waistband")
"""Parts whose choice is counted. A crew neck and a scoop are one line in two depths and count as one."""


def draw_cut(rng: np.random.Generator) -> str:
    """Draw the name of a cut."""

    def one(*words: str) -> str:
        return str(rng.choice(words))

    kind = one("top", "dress", "skirt", "legs", "suit")
    neck = {"neckline": one(*NECKS)}
    if kind == "top":
        sleeve = one(*SLEEVES)
        stem = "tank" if sleeve == "none" else "tshirt"
        parts = {
            **neck,
            "sleeve": sleeve,
            "bodice": one("skimming", "shift") if sleeve == "none" else one("boxy", "shift"),
        }
    elif kind == "dress":
        skirt = one("straight", "pencil", "a-line", *SWEEPS)
        waist = "seam" if skirt in SWEEPS else one("none", "seam")
        stem, parts = "dress", {**neck, "sleeve": one(*SLEEVES), "skirt": skirt, "waist": waist}
    elif kind == "skirt":
        skirt = one("straight", "pencil", "a-line", *SWEEPS, "tiered")
        band = "band" if skirt in ("gathered", "tiered") else one("none", "band")
        stem, parts = "skirt", {"skirt": skirt, "waistband": band}
    elif kind == "legs":
        stem, parts = (
            "trousers",
            {"legs": one("straight", "tapered", "flared", "wide", "short"), "waistband": one("none", "band")},
        )
    else:
        stem = "jumpsuit"
        parts = {
            **neck,
            "sleeve": one("none", "short", "elbow", "long"),
            "legs": one("straight", "tapered", "flared", "wide"),
        }
    return name_cut(stem, CUTS[stem].choose(parts))


def draw_body(rng: np.random.Generator) -> str:
    """Draw the description of a built-in body."""
    gender, height = str(rng.choice(["female", "male"])), rng.uniform(1.55, 1.90)
    weight = rng.uniform(20.0, 27.0) * height**2
    return f"builtin:{gender},height={height:.2f},weight={weight:.0f},pose={rng.choice(['T', 'A'])}"


def draw_measures(body: Body, rng: np.random.Generator) -> BodyMeasures:
    """Draw the measures that a pattern is drafted for, around a body's."""
    own = measure_wearer(body)
    drawn = {name: getattr(own, name) * rng.uniform(*GIRTHS) for name in ("bust", "waist", "hip")}
    heights = ("nape_height", "armpit_height", "waist_height", "hip_height", "crotch_height")
    at = own.nape_height
    for above, below in pairwise(heights):
        at -= (getattr(own, above) - getattr(own, below)) * rng.uniform(*DEPTHS)
        drawn[below] = at
    return replace(own, **drawn)


def make_case(number: int, seed: int, folder: Path) -> Path:
    """Draw and dress one case, or return the one that is there."""
    path = folder / f"case_{seed}_{number}.npz"
    if path.exists():
        return path
    for attempt in range(10):
        rng = np.random.default_rng([seed, number, attempt])
        name, spec = draw_cut(rng), draw_body(rng)
        body = builtin_body(spec)
        try:
            pattern = draft_cut(find_cut(name), draw_measures(body, rng), name)
            worn = drape_template(pattern, WearerGeometry(body), settings=DrapeSettings(template_vertices=VERTICES))
        except GarmentqError as error:
            print(f"  {number}: {name}: {error}", flush=True)
            continue
        nodes = worn.nodes + rng.normal(0.0, NOISE, worn.nodes.shape)
        np.savez_compressed(path, nodes=nodes, faces=worn.faces, name=name, body=spec)
        return path
    raise RuntimeError(f"nothing could be drawn for case {number}")


def read_case(path: Path) -> tuple[Target, Body, Cut]:
    """Return a case as the choice sees it, and its true cut."""
    with np.load(path) as kept:
        body, cut = builtin_body(str(kept["body"])), find_cut(str(kept["name"]))
        return segment_garment(Scan(kept["nodes"], kept["faces"]), body), body, cut


def is_right(part: str, found: Cut, true: Cut) -> bool:
    """Check one part of a cut."""
    pair = {str(getattr(found, part)), str(getattr(true, part))}
    return len(pair) == 1 or (part == "neckline" and pair == {"crew", "scoop"})


def main() -> None:
    """Print a line for each case and the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--make-only", action="store_true")
    chosen = parser.parse_args()
    chosen.out.mkdir(parents=True, exist_ok=True)
    right: Counter[str] = Counter()
    asked: Counter[str] = Counter()
    whole, spent = 0, 0.0
    for number in range(chosen.cases):
        path = make_case(number, chosen.seed, chosen.out)
        if chosen.make_only:
            continue
        try:
            target, body, true = read_case(path)
            begun = time.process_time()
            choice = choose_cut(target, body)
        except BadInput as error:
            print(json.dumps({"case": number, "error": str(error)}), flush=True)
            continue
        took = time.process_time() - begun
        spent = max(spent, took)
        found = find_cut(choice.template)
        wrong = []
        for part in JUDGED:
            if true.has_place_for(part) or found.has_place_for(part):
                asked[part] += 1
                right[part] += is_right(part, found, true)
                wrong += (
                    [] if is_right(part, found, true) else [f"{part}: {getattr(true, part)} as {getattr(found, part)}"]
                )
        whole += not wrong
        line = {"case": number, "true": str(np.load(path)["name"]), "found": choice.template, "wrong": wrong}
        print(json.dumps({**line, "cpu_s": round(took, 2)}), flush=True)
    for part in JUDGED:
        print(f"{part}: {right[part]} of {asked[part]}")
    print(f"all parts: {whole} of {chosen.cases}; longest choice {spent:.1f} s of CPU")


if __name__ == "__main__":
    main()
