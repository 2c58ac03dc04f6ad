"""Drape tops with collars, hoods and fronts on drawn wearers, and measure the cloth at their necks.

    python -m garmentq.training.necks --out DIR --count 260 [--write core/recover/grade/neck_drapes.npz]

Each is measured as a garment that was scanned by itself, both sides of its cloth, and as part of a person whose scan
shows the outside alone. A drape is a file, and what is there is not made again.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..core.body.body import Body
from ..core.body.skinning import skin, weights_at
from ..core.body.template import load_template
from ..core.garment.garment import Garment
from ..core.garment.measures import BodyMeasures
from ..core.garment.parts.cut import Bodice, Collar, Cut, Front, Hood, HoodWorn, Neckline, Sleeve
from ..core.garment.parts.draft import draft_cut
from ..core.geometry.geometry import vertex_normals
from ..core.people.hem_cap import cut_part
from ..core.people.part import Part
from ..core.recover.drape.sizing import measure_wearer
from ..core.recover.drape.stage import drape_template
from ..core.recover.drape.wearer import WearerGeometry
from ..core.recover.grade.neck_finish import NECK_KINDS, STYLE_COLLARS, STYLE_HOODS, NeckKind, NeckStyle, ShownSides
from ..core.recover.grade.neck_shape import NeckShape
from ..core.run.errors import GarmentqError
from ..core.scan.contours.garment import segment_garment
from ..core.scan.scan import Scan
from .accessories import bare_skin, draw_accessories
from .cloth import refine
from .scanner import Scanner, draw_scanner, scan_person
from .wardrobe import Layer
from .wearer import at_rest, draw_wearer, pose_angles, stand

POSE_SHARES = {"A": 0.5, "arms-down": 0.3, "T": 0.2}
"""Poses and how often each is drawn [1]."""

SURFACE_SCANNERS = ("fused", "watertight", "depth")
"""Kinds of scanners that give a person's surface as they see it."""

GARMENT_NOISE = (0.0003, 0.0015)
"""Range of the noise of a garment that is scanned by itself [m]."""


@dataclass(frozen=True)
class NeckDrape:
    """Describe a top that is draped.

    Attributes:
        kind: Of the cloth at its neck.
        body: The wearer in the pose.
        garment: The drape.
    """

    kind: NeckKind
    body: Body
    garment: Garment


def draw_drape(seed: int) -> NeckDrape:
    """Drape a drawn top on a drawn wearer, and carry it into a pose with the skin; kinds take turns.

    Raises:
        GarmentqError: where it cannot be drafted or dressed.
    """
    rng = np.random.default_rng([0, seed])
    kind = NECK_KINDS[seed % len(NECK_KINDS)]
    _, template, shape = draw_wearer(load_template(), rng)
    pose = str(rng.choice(list(POSE_SHARES), p=list(POSE_SHARES.values())))
    body = stand(template, shape, pose_angles(pose))
    wearer = WearerGeometry(at_rest(body))
    pattern = draft_cut(draw_cut(kind, rng), draw_measures(measure_wearer(wearer.body), rng))
    worn = drape_template(pattern, wearer)
    nodes = skin(worn.nodes, weights_at(body, worn.nodes, rest=True), body.transforms)
    return NeckDrape(kind, body, worn.at(nodes))


def draw_cut(kind: NeckKind, rng: np.random.Generator) -> Cut:
    """Draw a top with a neck of some kind."""
    is_plain, collar = kind.style is NeckStyle.PLAIN, Collar(str(rng.choice(STYLE_COLLARS[kind.style])))
    if collar is Collar.RIB and kind != NeckKind():
        collar = Collar.NONE
    depth = float(rng.uniform(0.07, 0.2)) if is_plain and kind.neckline is Neckline.V else None
    closed = Front.PLACKET if collar is Collar.POLO else Front.BUTTONS
    has_front = collar not in (Collar.NONE, Collar.RIB, Collar.TURTLENECK)
    return Cut(
        bodice=Bodice(str(rng.choice(["boxy", "skimming"]))),
        sleeve=Sleeve(str(rng.choice(["none", "short", "long"] if is_plain else ["short", "long"]))),
        neckline=kind.neckline,
        back_neckline=Neckline.BOAT if kind.neckline is Neckline.BOAT else Neckline.CREW,
        neck_depth=depth,
        collar=collar,
        hood=Hood.TWO if kind.style in STYLE_HOODS else Hood.NONE,
        hood_worn=STYLE_HOODS.get(kind.style, HoodWorn.DOWN),
        front=Front.OPEN if kind.is_open else closed if has_front else Front.NONE,
    )


def draw_measures(m: BodyMeasures, rng: np.random.Generator) -> BodyMeasures:
    """Draw the ease of a top over the measures of its wearer."""
    ease = float(rng.uniform(0.98, 1.2))
    return replace(
        m,
        bust=m.bust * ease,
        waist=m.waist * ease,
        hip=m.hip * ease,
        neck_half_width=m.neck_half_width + float(rng.uniform(0.0, 0.015)),
        shoulder_half_width=m.shoulder_half_width + float(rng.uniform(0.0, 0.02)),
    )


def measure_alone(drape: NeckDrape, rng: np.random.Generator) -> NeckShape | None:
    """Measure a garment that is scanned by itself."""
    vertices, faces = refine(drape.garment.nodes, drape.garment.faces)
    noise = float(rng.uniform(*GARMENT_NOISE)) * rng.normal(size=(len(vertices), 1))
    moved = vertices + noise * vertex_normals(vertices, faces)
    return NeckShape.of(segment_garment(Scan(moved, faces), drape.body), drape.body)


def measure_on_person(drape: NeckDrape, rng: np.random.Generator) -> NeckShape | None:
    """Measure a garment that is cut out of the surface of a scanned person, by the true labels."""
    layers = [Layer(Part.UPPER, refine(drape.garment.nodes, drape.garment.faces))]
    layers += draw_accessories(load_template(), drape.body, layers, rng)
    layers.append(Layer(Part.SKIN, bare_skin(drape.body, layers), is_cloth=False))
    scan = scan_person(layers, drape.body, _draw_surface_scanner(rng), rng)
    part = cut_part(Scan(scan.points, scan.faces), scan.label == Part.UPPER.value, drape.body)
    return NeckShape.of(segment_garment(part.garment, drape.body), drape.body)


def _draw_surface_scanner(rng: np.random.Generator) -> Scanner:
    while True:
        scanner = draw_scanner(rng)
        if scanner.kind in SURFACE_SCANNERS:
            return scanner


def measure_drapes(out: Path, seeds: range) -> Iterator[Path]:
    """Yield the files of drapes, each made unless it is there."""
    out.mkdir(parents=True, exist_ok=True)
    for seed in seeds:
        path = out / f"{seed:04d}.npz"
        if not path.exists():
            rng, found = np.random.default_rng([1, seed]), dict[str, np.ndarray]()
            try:
                drape = draw_drape(seed)
            except GarmentqError as error:
                print(f"{seed}: not dressed, {error}", flush=True)
                np.savez(path)
                continue
            for sides, measure in ((ShownSides.BOTH, measure_alone), (ShownSides.OUTSIDE, measure_on_person)):
                try:
                    shape = measure(drape, rng)
                except GarmentqError as error:
                    print(f"{seed} {sides}: {error}", flush=True)
                    continue
                if shape is not None:
                    found[sides.value] = shape.to_vector()
            np.savez(path, **found)  # type: ignore[arg-type]
            print(f"{seed} {drape.kind.name} {list(found)}", flush=True)
        yield path


def gather_samples(out: Path) -> dict[str, np.ndarray]:
    """Return the measures of all drapes of a folder by `<kind>/<sides>`, single precision, shape [n, k] each."""
    samples: dict[str, list[np.ndarray]] = {}
    for path in sorted(out.glob("*.npz")):
        with np.load(path) as stored:
            for sides in stored.files:
                kind = NECK_KINDS[int(path.stem) % len(NECK_KINDS)]
                samples.setdefault(f"{kind.name}/{sides}", []).append(stored[sides])
    return {name: np.array(rows, np.float32) for name, rows in sorted(samples.items())}


def main() -> None:
    """Drape, measure and write."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, required=True, help="folder for the drapes' measures")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--count", type=int, default=6 * len(NECK_KINDS), help="drapes")
    parser.add_argument("--write", type=Path, help="file of all measures, neck_drapes.npz")
    options = parser.parse_args()
    list(measure_drapes(options.out, range(options.first, options.first + options.count)))
    if options.write:
        np.savez_compressed(options.write, **gather_samples(options.out))  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
