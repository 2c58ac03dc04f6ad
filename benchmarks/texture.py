"""Recover a garment whose colours are a function of its true flat place, and measure what the texture shows there.

The truth is a shipped drape on the built-in body, its scan that surface with edges of a quarter, each panel's colours
going from 0 to 255 along and across. The recovery is told the scan, the body and a base pattern that is drafted for
girths 6 % larger.

Run with OMP_NUM_THREADS=1, OPENBLAS_NUM_THREADS=1 and NUMBA_NUM_THREADS=1:
python benchmarks/texture.py [TEMPLATE] --out DIR [--method deform]
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from garmentq.core.body.spec import BuiltinWearer
from garmentq.core.deliver.export.result import write_recovery
from garmentq.core.deliver.export.sewn_mesh import SewnMesh
from garmentq.core.deliver.export.textured import write_textured
from garmentq.core.deliver.texture.texels import find_texels
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.templates import draft_template, load_draped_template
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.scan.coloured import load_coloured
from PIL import Image

BODY = "builtin:female,height=1.70"
LARGER = 1.06
"""Girths that the base pattern is drafted for, by the body's."""


def panel_boxes(pattern: Pattern) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the lower corner and the size of each panel [m]."""
    return {panel.name: (panel.points.min(axis=0), np.ptp(panel.points, axis=0)) for panel in pattern.panels}


def colour_places(flat: np.ndarray, panel: np.ndarray, pattern: Pattern, boxes: dict) -> np.ndarray:
    """Return RGB in 0..255 of flat places [m] of panels by their index: across, along, and one level a panel."""
    low, size = (np.array([boxes[each.name][k] for each in pattern.panels]) for k in range(2))
    share = (flat - low[panel]) / size[panel]
    names = sorted(boxes)
    level = np.array([names.index(each.name) for each in pattern.panels])[panel] / len(names)
    return np.clip(255.0 * np.column_stack([share, level]), 0.0, 255.0)


def write_scan(garment: Garment, path: Path) -> None:
    """Write a garment as a scan with colours of its vertices."""
    rows = np.column_stack([garment.nodes[garment.uv_node], garment.uv, garment.panel_of_uv])
    faces = garment.uv_faces
    for _ in range(2):
        rows, faces = trimesh.remesh.subdivide(rows, faces)
    pattern = garment.pattern
    colours = colour_places(rows[:, 3:5], np.round(rows[:, 5]).astype(int), pattern, panel_boxes(pattern))
    colours = np.round(colours).astype(np.uint8)
    trimesh.Trimesh(rows[:, :3], faces, vertex_colors=colours, process=False).export(path)


def judge(garment: Garment, image: np.ndarray, mesh: SewnMesh, truth: Pattern) -> dict[str, float]:
    """Return mean and 95 % quantile of the error of across and along, as shares of the range."""
    texels = find_texels(mesh.unit_uv[0], garment.uv_faces, len(image), 0.0)
    flat = np.einsum("nk,nkd->nd", texels.barycentric, garment.uv[garment.uv_faces[texels.face]])
    panel = garment.panel_of_face[texels.face]
    true = colour_places(flat, panel, garment.pattern, panel_boxes(truth))
    error = np.abs(image[texels.row, texels.column, :2].astype(float) - true[:, :2]) / 255.0
    return {"mean": float(error.mean()), "p95": float(np.quantile(error, 0.95))}


def main() -> None:
    """Recover, bake and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("template", nargs="?", default="tshirt")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--method", default="hybrid")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    truth = load_draped_template(given.template)
    if truth is None:
        raise SystemExit("no drape is shipped for this machine's triangulation")
    scan, base = given.out / "scan.ply", given.out / "base.json"
    write_scan(truth, scan)
    own = BodyMeasures()
    wider = {name: LARGER * getattr(own, name) for name in ("bust", "waist", "hip")}
    save_pattern(draft_template(given.template, replace(own, **wider)), base)
    recovery = recover(
        Request(scan, BuiltinWearer(BODY), base, RecoverySettings(method=given.method, units="m", up="y"))
    )
    write_recovery(recovery, given.out / "result")
    mesh = SewnMesh("detail", recovery.garment, recovery.meshes.detail, recovery.fabric)
    start = time.process_time()
    written = write_textured(mesh, load_coloured(scan, "m", "y"), given.out, "garment")
    seconds = time.process_time() - start
    image = np.asarray(Image.open(given.out / "garment_texture.png"))
    found = judge(recovery.garment, image, mesh, truth.pattern)
    print(f"error {found['mean']:.4f} mean, {found['p95']:.4f} p95; coverage {written.coverage:.4f}; {seconds:.1f} s")


if __name__ == "__main__":
    main()
