"""Draft garments with GarmentCode's own programs (MIT), from seeds: the patterns that `foreign_drapes.py` drapes.

It runs in an environment of its own, which has what GarmentCode asks for and nothing of ours; GARMENTCODE is a checkout
of github.com/maria-korosteleva/GarmentCode:

    PYTHONPATH=GARMENTCODE python benchmarks/foreign_draft.py GARMENTCODE OUT [--seed 2026] [--body BODY.yaml]
        [--draft CATEGORY]...

Each garment is a folder with `specification.json` as GarmentCode writes it and `design.json`: category, seed, and the
parts in our words. The body is the SMPL average woman with her arms stretched out, or one
that `foreign_body.py` drew. Without `--draft` garments are drafted as `ORDER` has them.
"""

import argparse
import json
import random
from pathlib import Path

import yaml
from assets.bodies.body_params import BodyParameters
from assets.garment_programs.meta_garment import MetaGarment

ORDER = {
    "tshirt": 4, "long_sleeve_tshirt": 3, "tank": 3, "dress": 4, "skirt": 4, "trousers": 3, "shorts": 2, "jumpsuit": 1,
}  # fmt: skip
"""Garments by category."""

SEED = 2026
"""Of the first garment; each has the next one."""

EASE, FILE_EASE = 1.08, 1.15
"""By which girths are drafted wider than the body's: 8 % to move in, and 6 % more than those of GarmentCode's own file,
which are up to 6 % too narrow."""

ARM = 51.6
"""Length of the arm to the wrist [cm] for which long sleeves are drafted: that of GarmentCode's mean woman. The file of
the body has 80, with which they end 9 to 13 cm beyond the fingers, where cloth falls together over its own end."""

GIRTHS = (
    "bust", "underbust", "waist", "hips", "back_width", "waist_back_width", "hip_back_width", "leg_circ", "wrist",
)  # fmt: skip

NECKS = {"crew": "CircleNeckHalf", "v": "VNeckHalf", "square": "SquareNeckHalf"}
SKIRTS = {"straight": "PencilSkirt", "a_line": "Skirt2", "circle": "SkirtCircle", "gored": "SkirtManyPanels"}

LEGS = {"straight": (0.69, 0.62), "tapered": (0.65, 0.52), "flared": (0.66, 0.83), "wide": (0.87, 0.90)}
"""Girths at knee and hem by the thigh's that our legs have; a GarmentCode leg is called by the word that is nearest."""

KNEE = 0.35
"""Share of the way from thigh to hem, which GarmentCode draws straight, that a leg's width has gone at the knee."""

COLLARS = {"collar=turtleneck": "Turtle", "hood=two,hood_worn=up": "Hood2Panels"}
"""GarmentCode's collars by our parts."""

A_LINE = 1.085
"""Flare from which a narrow skirt is called A-line: half of what our A-line has from hip to hem, 1.17."""


def draw_top(design: dict, chance: random.Random, sleeve: str) -> dict[str, str]:
    """Draw the upper part of a garment and return its parts."""
    neck = chance.choice(sorted(NECKS))
    design["meta"]["upper"]["v"] = chance.choice(("Shirt", "FittedShirt"))
    shirt, collar, arm = design["shirt"], design["collar"], design["sleeve"]
    shirt["length"]["v"] = chance.uniform(1.1, 1.5)
    shirt["width"]["v"] = chance.uniform(1.05, 1.25)
    shirt["flare"]["v"] = chance.uniform(0.95, 1.15)
    collar["f_collar"]["v"] = NECKS[neck]
    collar["width"]["v"] = chance.uniform(0.1, 0.5)
    collar["fc_depth"]["v"] = chance.uniform(0.5, 1.0) if neck == "v" else chance.uniform(0.35, 0.7)
    arm["sleeveless"]["v"] = sleeve == "none"
    arm["length"]["v"] = chance.uniform(0.85, 1.0) if sleeve == "long" else chance.uniform(0.25, 0.4)
    arm["end_width"]["v"] = chance.uniform(0.5, 0.8) if sleeve == "long" else chance.uniform(0.8, 1.1)
    arm["connecting_width"]["v"] = chance.uniform(0.2, 0.6)
    return {"neckline": neck, "sleeve": sleeve, "darts": str(design["meta"]["upper"]["v"] == "FittedShirt").lower()}


def draw_collar(design: dict, parts: str) -> None:
    """Sew a collar to a top, whose neck is round and close to the body's then."""
    collar = design["collar"]
    collar["component"]["style"]["v"] = COLLARS[parts]
    collar["f_collar"]["v"], collar["width"]["v"] = NECKS["crew"], 0.1
    collar["fc_depth"]["v"] = 0.35


def draw_skirt(design: dict, chance: random.Random) -> dict[str, str]:
    """Draw a skirt and return its part."""
    kind = chance.choice(sorted(SKIRTS))
    design["meta"]["bottom"]["v"] = SKIRTS[kind]
    design["skirt"]["length"]["v"] = chance.uniform(0.2, 0.45)
    design["skirt"]["ruffle"]["v"] = 1.0
    design["skirt"]["flare"]["v"] = chance.randint(4, 14)
    design["flare-skirt"]["length"]["v"] = chance.uniform(0.2, 0.45)
    design["flare-skirt"]["suns"]["v"] = chance.choice((0.5, 1.0))
    design["flare-skirt"]["skirt-many-panels"]["n_panels"]["v"] = chance.choice((4, 6, 8))
    design["pencil-skirt"]["length"]["v"] = chance.uniform(0.3, 0.5)
    design["pencil-skirt"]["flare"]["v"] = chance.uniform(0.9, 1.2)
    if kind == "circle":
        kind = "half-circle" if design["flare-skirt"]["suns"]["v"] == 0.5 else "full-circle"
    if kind == "straight" and design["pencil-skirt"]["flare"]["v"] > A_LINE:
        kind = "a-line"
    return {"skirt": kind.replace("a_line", "a-line")}


def draw_legs(design: dict, chance: random.Random, *, short: bool) -> dict[str, str]:
    """Draw legs and return their part."""
    legs = design["pants"]
    design["meta"]["bottom"]["v"] = "Pants"
    legs["length"]["v"] = chance.uniform(0.25, 0.4) if short else chance.uniform(0.8, 0.9)
    legs["width"]["v"] = chance.uniform(1.0, 1.3)
    legs["flare"]["v"] = chance.uniform(0.6, 1.2)
    if short:
        return {"legs": "short"}
    hem = legs["flare"]["v"]
    knee = 1.0 - KNEE * (1.0 - hem)
    return {"legs": min(LEGS, key=lambda word: (LEGS[word][0] - knee) ** 2 + (LEGS[word][1] - hem) ** 2)}


def draw(category: str, seed: int, design: dict) -> dict[str, str]:
    """Fill a design in for a category from a seed, and return the parts in our words."""
    chance = random.Random(seed)
    if category in ("tshirt", "long_sleeve_tshirt", "tank"):
        sleeve = {"tshirt": "short", "long_sleeve_tshirt": "long", "tank": "none"}[category]
        return draw_top(design, chance, sleeve)
    if category in ("dress", "jumpsuit"):
        parts = draw_top(design, chance, chance.choice(("none", "short")))
        design["meta"]["upper"]["v"] = "FittedShirt"
        design["shirt"]["length"]["v"] = 1.0
        design["shirt"]["flare"]["v"] = 1.0
        rest = draw_skirt(design, chance) if category == "dress" else draw_legs(design, chance, short=False)
        return {**parts, **rest, "darts": "true"}
    design["meta"]["wb"]["v"] = chance.choice(("StraightWB", "FittedWB"))
    return draw_skirt(design, chance) if category == "skirt" else draw_legs(design, chance, short=category == "shorts")


def write(spec: dict) -> str:
    """Return a specification as JSON, panels and stitches sorted: GarmentCode's order is another one each time."""
    pattern = spec["pattern"]
    pattern["panels"] = dict(sorted(pattern["panels"].items()))
    pattern["stitches"] = sorted((sorted(sides, key=str) for sides in pattern["stitches"]), key=str)
    return json.dumps(spec, default=lambda value: value.tolist())


def main() -> None:
    """Draft all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("garmentcode", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", type=int, default=SEED, help="of the first garment; each has the next one")
    parser.add_argument("--body", type=Path, help="measures by foreign_body.py; GarmentCode's own woman without")
    parser.add_argument("--draft", action="append", choices=tuple(ORDER), help="a category; may be repeated")
    parser.add_argument("--parts", choices=tuple(COLLARS), help="what is sewn to a top's neck")
    given = parser.parse_args()
    assets = given.garmentcode / "assets"
    categories = given.draft or [category for category, count in ORDER.items() for _ in range(count)]
    for seed, category in enumerate(categories, given.seed):
        body = BodyParameters(str(given.body or assets / "bodies" / "f_smpl_average_A40.yaml"))
        body["arm_pose_angle"] = 0
        for girth in GIRTHS:
            body[girth] = (EASE if given.body else FILE_EASE) * body[girth]
        design = yaml.safe_load((assets / "design_params" / "default.yaml").read_text())["design"]
        parts = draw(category, seed, design)
        if given.parts:
            draw_collar(design, given.parts)
        if parts.get("sleeve") == "long" and not given.body:
            body["arm_length"] = ARM
        name = f"{category}_{seed}"
        folder = given.out / name
        folder.mkdir(parents=True, exist_ok=True)
        spec = MetaGarment(name, body, design).assembly().spec
        (folder / "specification.json").write_text(write(spec))
        told = {"category": category, "seed": seed, "parts": parts}
        (folder / "design.json").write_text(json.dumps(told, indent=1))
        print(name, len(spec["pattern"]["panels"]), "panels", parts, flush=True)


if __name__ == "__main__":
    main()
