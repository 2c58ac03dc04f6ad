"""Draw patterns of other makers at random, from seeds: by GarmentCode's own sampler of designs (MIT), and from the
parametric templates of Garment-Pattern-Generator (MIT). `foreign_pieces.py` makes pieces of them.

It runs in an environment of its own, which has what GarmentCode asks for and nothing of ours:

    PYTHONPATH=GARMENTCODE python benchmarks/foreign_sampled.py GARMENTCODE TEMPLATES OUT [--designs 160] [--drawn 70]

GARMENTCODE and TEMPLATES are checkouts of both repositories. A pattern is a folder with `specification.json`.
"""

from __future__ import annotations

import argparse
import json
import random
from pathlib import Path

from assets.bodies.body_params import BodyParameters
from assets.garment_programs.meta_garment import MetaGarment
from pygarment.garmentcode.params import DesignSampler
from pygarment.pattern.wrappers import VisPattern

SEED = 7100
"""Of the first pattern; each has the next one."""


def main() -> None:
    """Draw all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("garmentcode", type=Path)
    parser.add_argument("templates", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--designs", type=int, default=160)
    parser.add_argument("--drawn", type=int, default=70)
    given = parser.parse_args()
    body = BodyParameters(given.garmentcode / "assets/bodies/mean_all.yaml")
    sampler = DesignSampler(given.garmentcode / "assets/design_params/default.yaml")
    made, seed = 0, SEED
    while made < given.designs:
        seed += 1
        folder = given.out / f"design_{seed}"
        try:
            draw_design(sampler, body, seed, folder)
            made += 1
        except Exception as error:  # its programs refuse some of the sampler's own designs
            print(f"{seed}: {type(error).__name__}")
    sources = sorted(path for path in (given.templates / "data_generation/Patterns").rglob("*.json") if is_whole(path))
    for n in range(given.drawn):
        source = sources[n % len(sources)]
        draw_template(source, SEED + n, given.out / f"template_{source.stem}_{SEED + n}")


def draw_design(sampler: DesignSampler, body: BodyParameters, seed: int, folder: Path) -> None:
    """Write a design that GarmentCode's sampler draws."""
    random.seed(seed)
    design = sampler.randomize()
    piece = MetaGarment("drawn", body, design)
    pattern = piece.assembly()
    if piece.is_self_intersecting() or not pattern.spec["pattern"]["panels"]:
        raise ValueError("its panels cross themselves, or there are none")
    folder.mkdir(parents=True, exist_ok=True)
    write(pattern.spec, folder)


def draw_template(source: Path, seed: int, folder: Path) -> None:
    """Write a parametric template with drawn parameters."""
    random.seed(seed)
    pattern = VisPattern(str(source))
    pattern._randomize_pattern()
    folder.mkdir(parents=True, exist_ok=True)
    write(pattern.spec, folder)


def is_whole(path: Path) -> bool:
    """Check whether a file is a pattern with parameters."""
    document = json.loads(path.read_text())
    return bool(document.get("parameters")) and "pattern" in document


def write(spec: dict, folder: Path) -> None:
    """Write a pattern as its makers' programs do."""
    text = json.dumps(spec, default=lambda value: value.tolist())
    (folder / "specification.json").write_text(text)


if __name__ == "__main__":
    main()
