"""Recover garments whose patterns are known, of three makers, and keep both: what intervals of seams are made from.

    python benchmarks/known_patterns.py OUT --count 60 --garmentcode CHECKOUT --templates CHECKOUT --python PYTHON

Makers take turns: our own parts, GarmentCode's programs (MIT) and the parametric templates of
Garment-Pattern-Generator (MIT). Each is draped by the simulator on a drawn wearer, scanned with noise, and recovered
from the library's base patterns. A garment is a folder with its pattern, scan, wearer and `known.npz`: where its seams
are on the drape. PYTHON is one that has what GarmentCode asks for. What is made is not made again.
"""

from __future__ import annotations

import argparse
import json
import pickle
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from foreign_body import measure_for_garmentcode
from foreign_own import draw_cut, draw_measures
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export.meshes import write_ply
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.resampling import resample
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import draft_template, find_cut
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.core.recover.drape.stage import DrapeSettings, drape_graded, drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.run.errors import GarmentqError
from garmentq.core.scan.contours.target import Target
from garmentq.training.cloth import refine, wave_field
from unseen_draw import SINGLE
from unseen_wearer import draw_wearer, pose_by_steps

MAKERS = ("own", "garmentcode", "templates")

TEMPLATES = {
    "basic tee/tee": 0.2, "basic tee/tee_sleeveless": 0.15, "combos/dress": 0.15, "combos/dress_sleeveless": 0.1,
    "pants/pants_straight_sides": 0.1, "pants/wb_pants_straight": 0.1, "skirts/skirt_2_panels": 0.1,
    "skirts/skirt_4_panels": 0.1,
}  # fmt: skip
"""Parametric templates, and how often each is drawn."""

POSES = {"A": 0.6, "arms-down": 0.2, "T": 0.2}

FABRICS = ("cotton_poplin", "denim", "interlock_knit", "canvas")

VERTICES = 1500
"""Of a drape."""

NOISES = (0.3e-3, 1.5e-3)
"""Standard deviation of a scan's noise [m]."""

MOST_CROSSING = 0.03
"""Share of faces that may cross others: more is crumpled cloth."""

DRAW_TEMPLATE = """
import json, random, sys
from pathlib import Path
from pygarment.pattern.wrappers import VisPattern
source, out, seed = sys.argv[1:]
random.seed(int(seed))
pattern = VisPattern(source)
pattern._randomize_pattern()
Path(out).write_text(json.dumps(pattern.spec, default=lambda value: value.tolist()))
"""


@dataclass(frozen=True)
class Makers:
    """Where the makers' programs are: checkouts, and a Python that runs them."""

    garmentcode: Path
    templates: Path
    python: str

    def run(self, *line: object) -> None:
        """Run a program of theirs.

        Raises:
            RuntimeError: where it fails.
        """
        environment = {"PYTHONPATH": str(self.garmentcode), "PATH": "/usr/bin:/bin"}
        ran = subprocess.run(
            [self.python, *map(str, line)], env=environment, capture_output=True, text=True, check=False
        )
        if ran.returncode:
            raise RuntimeError(ran.stderr.strip().splitlines()[-1] if ran.stderr.strip() else "it failed")


def choose(shares: dict[str, float], rng: np.random.Generator) -> str:
    """Draw a name by its share."""
    weights = np.array(list(shares.values()))
    return str(rng.choice(list(shares), p=weights / weights.sum()))


def draw_known(index: int, seed: int, folder: Path, makers: Makers) -> tuple[Body, str]:
    """Draft a garment for a drawn wearer into `specification.json`, and return the wearer in a pose and the maker."""
    rng, maker = np.random.default_rng([seed, 1]), MAKERS[index % len(MAKERS)]
    rest = draw_wearer(seed)
    if maker == "own":
        category = choose(SINGLE, rng)
        name = draw_cut(category, rng)
        is_hung = str(find_cut(name).bodice) == "none"
        measures = draw_measures(measure_wearer(rest), rng, hangs_from_waist=is_hung)
        save_pattern(draft_template(name, measures), folder / "specification.json")
    elif maker == "garmentcode":
        category = choose(SINGLE, rng)
        (folder / "body.yaml").write_text(json.dumps({"body": measure_for_garmentcode(rest)}))  # YAML reads JSON
        script = Path(__file__).with_name("foreign_draft.py")
        body = ("--body", folder / "body.yaml")
        makers.run(script, makers.garmentcode, folder, "--seed", seed, "--draft", category, *body)
        (folder / f"{category}_{seed}" / "specification.json").rename(folder / "specification.json")
    else:
        rest = builtin_body(f"builtin:female,height={rng.uniform(1.62, 1.74):.2f}")
        source = makers.templates / "data_generation" / "Patterns" / f"{choose(TEMPLATES, rng)}.json"
        makers.run("-c", DRAW_TEMPLATE, source, folder / "specification.json", seed)
    return pose_by_steps(rest, choose(POSES, rng))[-1], maker


def drape_known(folder: Path, body: Body, rng: np.random.Generator) -> Garment:
    """Return a drafted garment at rest on its wearer.

    Raises:
        RuntimeError: where it crosses itself.
    """
    pattern, wearer = load_pattern(folder / "specification.json"), WearerGeometry(body)
    worn = drape_template(pattern, wearer, carry=True)
    normals = vertex_normals(worn.nodes, worn.faces)
    target = Target(worn.nodes, worn.faces, normals, worn.contours, (), "tshirt")
    fine = mesh_pattern(pattern, VERTICES)
    placed = fine.at(resample(worn, worn.nodes, fine))
    fabric = get_fabric(str(rng.choice(FABRICS)))
    found, _ = drape_graded(placed, wearer, fabric, target, settings=DrapeSettings(self_contact=True))
    crossing = len(self_intersections(found.nodes, found.faces))
    if crossing > MOST_CROSSING * len(found.faces):
        raise RuntimeError(f"{crossing} faces cross others")
    return found


def scan_garment(garment: Garment, path: Path, rng: np.random.Generator) -> None:
    """Write a garment's mesh with noise, on other vertices than its own."""
    vertices, faces = refine(garment.nodes, garment.faces)
    noise = float(np.exp(rng.uniform(*np.log(NOISES))))
    moved = np.sqrt(0.5) * (rng.normal(size=len(vertices)) + wave_field(vertices, (0.01, 0.04), rng))
    write_ply(vertices + noise * moved[:, None] * vertex_normals(vertices, faces), faces, path)


def make_known(index: int, seed: int, out: Path, makers: Makers, method: str) -> Path | None:
    """Make and recover one garment; None where it cannot be made. What is there stays."""
    folder = out / f"{index:03d}"
    if (folder / "recovered.pkl").exists():
        return folder
    if (folder / "failed.txt").exists():
        return None
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([seed, 2])
    try:
        body, maker = draw_known(index, seed, folder, makers)
        known = drape_known(folder, body, rng)
        scan_garment(known, folder / "scan.ply", rng)
        trimesh.Trimesh(body.vertices, body.faces, process=False).export(folder / "body.ply")
        request = Request(folder / "scan.ply", folder / "body.ply", settings=RecoverySettings(method=method))
        found = recover(request)
    except (GarmentqError, RuntimeError, np.linalg.LinAlgError) as error:
        (folder / "failed.txt").write_text(f"{type(error).__name__}: {error}")
        print(f"{index}: {error}", file=sys.stderr, flush=True)
        return None
    with (folder / "recovered.pkl").open("wb") as file:
        pickle.dump({"maker": maker, "seed": seed, "method": method, "known": known, "found": found}, file)
    rms = found.report.metrics["surface_rms_mm.s2t"]
    print(
        f"{index}: {maker} {found.template} {rms:.2f} mm, {found.report.cpu_seconds:.0f} s", file=sys.stderr, flush=True
    )
    return folder


def main() -> None:
    """Make all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=7100, help="of garment 0; each has the next one")
    parser.add_argument("--garmentcode", type=Path, required=True)
    parser.add_argument("--templates", type=Path, required=True)
    parser.add_argument("--python", required=True)
    parser.add_argument("--method", default=RecoverySettings().method)
    given = parser.parse_args()
    makers = Makers(given.garmentcode.resolve(), given.templates.resolve(), given.python)
    for index in range(given.first, given.first + given.count):
        make_known(index, given.seed + index, given.out, makers, given.method)


if __name__ == "__main__":
    main()
