"""Recover garments of `known_patterns.py` once more, from scans on which cloth shows their seams.

    python benchmarks/known_cloth.py KNOWN OUT

Garments take turns: sleeves, or backs where there are none, of another colour; stripes across each panel's length.
OUT becomes a folder that `line_errors.py` reads like KNOWN.
"""

from __future__ import annotations

import argparse
import pickle
import sys
from pathlib import Path

import numpy as np
import trimesh
from garmentq.core.garment.garment import Garment
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.geometry.surface import ClosestPoints, TriangleSurface
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.run.errors import GarmentqError
from garmentq.training.cloth import refine

CLOTHS = ("blocks", "stripes")

CLOTH_COLOURS = np.array([[0.75, 0.7, 0.65], [0.15, 0.2, 0.5]])

CAMERA_NOISE = 0.04
"""Standard deviation of colours in 0..1."""

STRIPE_WIDTHS = (0.012, 0.03)
"""Least and largest width of a stripe [m]."""


def paint_blocks(known: Garment, near: ClosestPoints) -> np.ndarray:
    """Return which of two colours each point has: the second on sleeves, or behind."""
    names = [panel.name for panel in known.pattern.panels]
    word = "sleeve" if any("sleeve" in name for name in names) else "back"
    return np.array([word in name for name in names])[known.panel_of_face[near.face]].astype(int)


def paint_stripes(known: Garment, near: ClosestPoints, rng: np.random.Generator) -> np.ndarray:
    """Return which of two colours each point has: in turn along the panels."""
    width = rng.uniform(*STRIPE_WIDTHS)
    height = near.interpolate(known.uv, known.uv_faces)[:, 1]
    return np.asarray(np.floor(height / width).astype(int) % 2)


def scan_cloth(cloth: str, known: Garment, scan: Path, out: Path, rng: np.random.Generator) -> None:
    """Write a scan again with what its cloth shows of the seams."""
    mesh = trimesh.load(scan, process=False)
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    if len(vertices) < 30000:
        vertices, faces = refine(vertices, faces)
    normals = vertex_normals(vertices, faces)
    near = TriangleSurface(known.nodes, known.faces).closest(vertices)
    which = paint_blocks(known, near) if cloth == "blocks" else paint_stripes(known, near, rng)
    shade = 0.75 + 0.25 * normals[:, 2:]
    colours = np.clip(shade * CLOTH_COLOURS[which] + CAMERA_NOISE * rng.normal(size=(len(which), 3)), 0.0, 1.0)
    painted = np.round(255.0 * colours).astype(np.uint8)
    trimesh.Trimesh(vertices, faces, vertex_colors=painted, process=False).export(out)


def main() -> None:
    """Recover all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("known", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--method", default="deform")
    given = parser.parse_args()
    for n, path in enumerate(sorted(given.known.glob("*/recovered.pkl"))):
        folder = given.out / path.parent.name
        if (folder / "recovered.pkl").exists():
            continue
        folder.mkdir(parents=True, exist_ok=True)
        stored = pickle.loads(path.read_bytes())
        cloth = CLOTHS[n % len(CLOTHS)]
        rng = np.random.default_rng([stored["seed"], 4])
        scan_cloth(cloth, stored["known"], path.with_name("scan.ply"), folder / "scan.ply", rng)
        settings = RecoverySettings(method=given.method)
        try:
            found = recover(Request(folder / "scan.ply", path.with_name("body.ply"), settings=settings))
        except (GarmentqError, np.linalg.LinAlgError) as error:
            print(f"{folder.name}: {error}", file=sys.stderr, flush=True)
            continue
        (folder / "recovered.pkl").write_bytes(pickle.dumps(stored | {"found": found, "cloth": cloth}))
        shown = [line["name"] for line in found.report.manifest["lines"] if line["evidence"] in ("colour", "stripes")]
        print(f"{folder.name}: {cloth} {found.template} {', '.join(shown) or 'none'}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
