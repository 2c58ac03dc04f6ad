"""Recover the pattern and the cloth of drapes of our own simulator, made on another mesh.

Base patterns are drafted for other measures, drawn with a seed, draped on the built-in body with more vertices than a
recovery takes and with a cloth of known bending, and written as target packs. The recovery is told the mesh, the body's
mesh and the base pattern, and has to find what was drawn.

Run with one thread:
OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/own_drape.py [--seed 0] [TEMPLATE ...]
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from garmentq.cli.bench.packs import read_packs, read_true_pattern
from garmentq.cli.bench.pattern_match import measure_panels
from garmentq.cli.bench.truth import measure_recovery
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.garment.curves import edge_points, panel_area
from garmentq.core.garment.editing.darts import find_darts
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.measures import BodyMeasures
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.templates import draft_template, load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.stage import drape_graded, drape_template, remesh
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.scan.contours.target import Target

BODY = "builtin:female,height=1.70"
TEMPLATES = ("tshirt", "skirt", "tank")
"""What hangs from the shoulders with sleeves, from the waist, and from the shoulders without."""

VERTICES = 6000
"""Of the target; a recovery takes 4000."""

GIRTHS, DEPTHS = (1.02, 1.14), (1.0, 1.12)
"""Between which factors girths and widths, and depths from one height of the body to the next, are drawn: up to two
sizes larger than the body, so that it goes in and nothing is squeezed."""

STIFFER = 4.0
"""The cloth's k, by that of the fabric which the recovery assumes at first (its other parameters are the same)."""


def draw_pattern(name: str, rng: np.random.Generator) -> Pattern:
    """Draft a template for measures that are drawn one by one, from the nape down, around the body's."""
    body = BodyMeasures()
    drawn = {
        measure: getattr(body, measure) * rng.uniform(*GIRTHS)
        for measure in ("bust", "waist", "hip", "shoulder_half_width", "neck_half_width")
    }
    heights = ("nape_height", "armpit_height", "waist_height", "hip_height", "crotch_height")
    at = body.nape_height
    for above, below in pairwise(heights):
        at -= (getattr(body, above) - getattr(body, below)) * rng.uniform(*DEPTHS)
        drawn[below] = at
    return draft_template(name, replace(body, **drawn))


def write_pack(folder: Path, name: str, pattern: Pattern, fabric: Fabric) -> None:
    """Drape a pattern and write it as a target pack: mesh, body, and apart from them the truth."""
    wearer = WearerGeometry(builtin_body(BODY))
    worn = drape_template(pattern, wearer)
    normals = vertex_normals(worn.nodes, worn.faces)
    where_it_hangs = Target(worn.nodes, worn.faces, normals, worn.contours, (), pattern.category)
    garment, drape = drape_graded(remesh(worn, VERTICES), wearer, fabric, where_it_hangs)
    print(f"{name}: target of {len(garment.nodes)} vertices {drape.outcome.advice}", flush=True)
    folder.mkdir(parents=True, exist_ok=True)
    trimesh.Trimesh(garment.nodes, garment.faces, process=False).export(folder / "garment.ply")
    trimesh.Trimesh(wearer.body.vertices, wearer.body.faces, process=False).export(folder / "body.ply")
    panels: dict[str, Any] = {}
    for panel in pattern.panels:
        edges = [edge_points(panel, n, 100) for n in range(len(panel.edges))]
        outline = np.concatenate([edge[:-1] for edge in edges])
        panels[panel.name] = {"outline": outline.tolist(), "edges": [edge.tolist() for edge in edges]}
    stitches = [{"a": [seam.a.panel, seam.a.edge], "b": [seam.b.panel, seam.b.edge]} for seam in pattern.seams]
    (folder / "pattern.json").write_text(json.dumps({"unit": "m", "panels": panels, "stitches": stitches}))
    meta = {"category": pattern.category, "fabric": {"k": fabric.k}}
    (folder / "meta.json").write_text(json.dumps(meta))


def recover_pack(folder: Path, fabric: Fabric, drawn: Pattern, keep_cut: bool) -> dict[str, Any]:
    """Recover a pack by the hybrid method and hold pattern and cloth against the truth, the pattern that was drawn."""
    pack = read_packs(folder)[0]
    settings = RecoverySettings(method="hybrid", fabric=fabric.name, keep_cut=keep_cut or None)
    recovery = recover(Request(pack.garment, pack.body, pack.template, settings))
    metrics, _ = measure_recovery(recovery, pack, own_template=True)
    truth = read_true_pattern(pack)
    assert truth is not None
    known = {each.name: each for each in recovery.estimates}
    found, true = (sum(abs(panel_area(panel)) for panel in each.panels) for each in (recovery.pattern, drawn))
    return {
        "whole pattern": found / true - 1.0,
        "area error": metrics["panel_area_error"],
        "outline [mm]": metrics["panel_outline_mm"],
        "k / true k": known["k"].value / pack.fabric["k"] if "k" in known else None,
        "std of ln k": known["k"].std if "k" in known else None,
        "k known": "k" in known and known["k"].identifiable,
        "H known": any(each.identifiable for key, each in known.items() if key.startswith("H")),
        "drape [mm]": metrics["sim.surface_rms_mm.s2t"],
        "redrape [mm]": metrics["redrape.surface_rms_mm.s2t"],
        "darts": _list_darts(recovery.pattern),
        "true darts": _list_darts(drawn),
        "CPU [s]": recovery.report.cpu_seconds,
        "panels": {key: round(v["area_error"], 4) for key, v in measure_panels(recovery.pattern, truth).items()},
        "warnings": recovery.report.warnings,
    }


def _list_darts(pattern: Pattern) -> list[str]:
    """Return each dart's panel, intake, length and angle, and how far its mouth is from the panel's middle line."""
    found = []
    for dart in find_darts(pattern):
        first, _, last = dart.ends(pattern)
        width, length = dart.width(pattern), dart.length(pattern)
        angle, away = np.degrees(2 * np.arctan(width / 2 / length)), 0.5 * (first + last)[0]
        found.append(f"{dart.panel} {1e3 * width:.0f} x {1e3 * length:.0f} mm, {angle:.1f} deg, at {1e3 * away:+.0f}")
    return found


def main() -> None:
    """Print a row for each template."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("templates", nargs="*", default=TEMPLATES)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--base", help="template that it is recovered from, cut otherwise; default: its own")
    parser.add_argument("--keep-cut", action="store_true", help="add no dart, and close none")
    parser.add_argument("--stiffer", type=float, default=STIFFER)
    parser.add_argument("--out", type=Path, help="folder to keep the packs in; those that are there are not made again")
    chosen = parser.parse_args()
    out = chosen.out or Path(tempfile.mkdtemp())
    assumed = get_fabric(RecoverySettings().fabric)
    for name in chosen.templates:
        # One stream for each template: its pattern does not depend on which others are asked for.
        pattern = draw_pattern(name, np.random.default_rng([chosen.seed, *name.encode()]))
        base, folder = load_template(chosen.base or name), out / f"{name}_{chosen.seed}"
        if not (folder / "meta.json").exists():
            write_pack(folder, name, pattern, replace(assumed, k=chosen.stiffer * assumed.k))
        save_pattern(base, folder / "template.json")
        away = [panel_area(panel) / panel_area(base.panel(panel.name)) - 1.0 for panel in pattern.panels]
        print(f"{name}: panels {', '.join(f'{x:+.3f}' for x in away)} from the base pattern's", flush=True)
        for key, value in recover_pack(folder, assumed, pattern, chosen.keep_cut).items():
            print(f"  {key}: {round(value, 4) if isinstance(value, float) else value}", flush=True)


if __name__ == "__main__":
    main()
