"""Recover a garment whose colours are a function of its true flat place, and measure what the texture shows there.

The truth is a result's garment as it is worn, its scan that surface with edges of a quarter, each panel's colours going
from 0 to 255 along and across. The recovery is told the scan, the body's mesh and the base pattern.

Run with one thread:
OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/texture.py RESULT BASE.json --out DIR
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
import trimesh
from garmentq.core.export import write_recovery
from garmentq.core.export.sewn_mesh import SewnMesh
from garmentq.core.export.textured import write_textured
from garmentq.core.pattern import Garment, Pattern
from garmentq.core.pipeline import recover
from garmentq.core.recovery import Request
from garmentq.core.scan.coloured import load_coloured
from garmentq.core.settings import RecoverySettings
from garmentq.core.texture import find_texels
from garmentq.core.wear import Worn, load_worn
from PIL import Image


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


def write_scan(worn: Worn, path: Path) -> None:
    """Write the worn garment as a scan with colours of its vertices."""
    garment = worn.garment
    rows = np.column_stack([garment.nodes[garment.uv_node], garment.uv, garment.panel_of_uv])
    faces = garment.uv_faces
    for _ in range(2):
        rows, faces = trimesh.remesh.subdivide(rows, faces)
    colours = colour_places(rows[:, 3:5], np.round(rows[:, 5]).astype(int), worn.pattern, panel_boxes(worn.pattern))
    colours = np.round(colours).astype(np.uint8)
    trimesh.Trimesh(rows[:, :3], faces, vertex_colors=colours, process=False).export(path)


def judge(garment: Garment, image: np.ndarray, mesh: SewnMesh, truth: Worn) -> dict[str, float]:
    """Return mean and 95 % quantile of the error of across and along, as shares of the range."""
    texels = find_texels(mesh.unit_uv[0], garment.uv_faces, len(image), 0.0)
    flat = np.einsum("nk,nkd->nd", texels.barycentric, garment.uv[garment.uv_faces[texels.face]])
    panel = garment.panel_of_face[texels.face]
    true = colour_places(flat, panel, garment.pattern, panel_boxes(truth.pattern))
    error = np.abs(image[texels.row, texels.column, :2].astype(float) - true[:, :2]) / 255.0
    return {"mean": float(error.mean()), "p95": float(np.quantile(error, 0.95))}


def main() -> None:
    """Recover, bake and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("result", type=Path)
    parser.add_argument("base", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    truth, scan = load_worn(given.result), given.out / "scan.ply"
    write_scan(truth, scan)
    settings = RecoverySettings(units="m", up="y")
    recovery = recover(Request(scan, given.result / "body.ply", given.base, settings))
    write_recovery(recovery, given.out / "result")
    mesh = SewnMesh("detail", recovery.garment, recovery.meshes.detail, recovery.fabric)
    start = time.process_time()
    written = write_textured(mesh, load_coloured(scan, "m", "y"), given.out, "garment")
    seconds = time.process_time() - start
    image = np.asarray(Image.open(given.out / "garment_texture.png"))
    found = judge(recovery.garment, image, mesh, truth)
    print(f"error {found['mean']:.4f} mean, {found['p95']:.4f} p95; coverage {written.coverage:.4f}; {seconds:.1f} s")


if __name__ == "__main__":
    main()
