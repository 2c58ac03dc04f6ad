"""Recover flared garments that another simulator draped, scanned at three densities with noise.

A skirt, a dress and wide trousers are flared from our base patterns, hung by position-based dynamics (M. Macklin et
al., XPBD, 2016, with one iteration in each of many small steps): springs along the triangles' sides and across them,
nothing of `core.cloth`. Their triangles are then split, and every vertex moves by 0.2 mm of noise. The recovery is
told mesh, body and the base pattern without flare; printed are which hems it trusts, and how far its outlines are from
the flared pattern's.

Run with one thread:
OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/flared.py [--out FOLDER] [GARMENT ...]
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np
import trimesh
from garmentq.cli.bench.packs import read_packs
from garmentq.cli.bench.truth import measure_recovery
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.curves import edge_points
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.recover.drape.stage import drape_template, remesh
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.scan.contours.contours import name_contours
from numba import njit

BODY = "builtin:female,height=1.70"
GARMENTS = {"skirt": ("skirt", 0.0, 0.5), "dress": ("dress", 0.5, 0.5), "wide_legs": ("trousers", 0.45, 0.5)}
"""Template, the share of each panel's height (from the top) below which it is flared, and by how much at the hem."""

VERTICES = 4600
"""Of the drape: some 9 thousand faces."""
SPLITS = (0, 2, 3)
"""Times each triangle is split into four: 9, 139 and 556 thousand faces."""
NOISE = 2e-4
"""Standard deviation of each coordinate [m]: a good structured-light scanner's."""
STEPS, STEP = 5000, 1 / 1000
"""Five seconds, in steps [s] short enough that one sweep keeps cloth from stretching by more than 1 %."""
SOFT = 3e-3
"""Compliance of the springs across a triangle's side [m/N] for a vertex of 0.05 g: a light fabric's bending."""


def flare(pattern: Pattern, start: float, amount: float) -> Pattern:
    """Return a pattern whose panels widen linearly below a share of their height, about the middle of their top."""
    points = np.array(pattern.points)
    for panel in pattern.panels:
        outline = np.concatenate([edge_points(panel, n, 20) for n in range(len(panel.edges))])
        top, height = outline[:, 1].max(), np.ptp(outline[:, 1])
        middle = 0.5 * (outline[:, 0].min() + outline[:, 0].max())
        owned = np.isclose(points[:, None], panel.points[None], atol=1e-12).all(axis=2).any(axis=1)
        below = np.clip((top - points[:, 1]) / height - start, 0.0, 1.0) / (1.0 - start)
        points[owned, 0] += (amount * below * (points[:, 0] - middle))[owned]
    return pattern.with_points(points)


@njit(cache=True)
def step(points, before, pairs, rests, soft, free, feet, normals, gap, dt):  # type: ignore[no-untyped-def]
    """Advance all vertices by one step: inertia and weight, springs one after another, and the body's skin."""
    for v in range(len(points)):
        for k in range(3):
            speed = 0.998 * (points[v, k] - before[v, k])
            before[v, k] = points[v, k]
            if free[v]:
                points[v, k] += speed - (9.81 * dt * dt if k == 1 else 0.0)
    for c in range(len(pairs)):
        a, b = pairs[c, 0], pairs[c, 1]
        wa, wb = (1.0 if free[a] else 0.0), (1.0 if free[b] else 0.0)
        x, y, z = points[a, 0] - points[b, 0], points[a, 1] - points[b, 1], points[a, 2] - points[b, 2]
        length = np.sqrt(x * x + y * y + z * z)
        if wa + wb == 0.0 or length == 0.0:
            continue
        pull = (length - rests[c]) / (length * (wa + wb + soft[c] * 5e-5 / (dt * dt)))
        for k, d in enumerate((x, y, z)):
            points[a, k] -= wa * pull * d
            points[b, k] += wb * pull * d
    for v in range(len(points)):
        if free[v]:
            away = 0.0
            for k in range(3):
                away += (points[v, k] - feet[v, k]) * normals[v, k]
            if away < gap:
                for k in range(3):
                    points[v, k] += (gap - away) * normals[v, k]
                    before[v, k] += 0.6 * (points[v, k] - before[v, k])


def drape(
    nodes: np.ndarray, faces: np.ndarray, rest: np.ndarray, held: np.ndarray, wearer: WearerGeometry
) -> np.ndarray:
    """Return where cloth comes to rest [m]; `rest` are the flat triangles [m], `held` nodes that stay in place."""
    edges = HalfEdges.of(faces, len(nodes))
    sides = np.linalg.norm(np.roll(rest, -1, axis=1) - rest, axis=2).ravel()
    along = np.bincount(edges.edge, sides) / np.bincount(edges.edge)
    hinge = edges.twin >= 0
    hinge &= np.arange(len(hinge)) < np.where(hinge, edges.twin, 0)
    across = np.stack([edges.opposite[hinge], edges.opposite[edges.twin[hinge]]], axis=1)
    corner = np.roll(rest, -2, axis=1).reshape(-1, 3 if rest.shape[-1] == 3 else 2)
    tail, head = rest.reshape(corner.shape), np.roll(rest, -1, axis=1).reshape(corner.shape)
    side = (head - tail) / np.linalg.norm(head - tail, axis=1, keepdims=True)
    foot = ((corner - tail) * side).sum(axis=1)
    height = np.linalg.norm(corner - tail - foot[:, None] * side, axis=1)
    twin = edges.twin[hinge]
    wide = np.hypot(height[hinge] + height[twin], foot[hinge] - (sides[twin] - foot[twin]))
    pairs = np.concatenate([edges.edges, across])
    rests = np.concatenate([along, wide])
    soft = np.r_[np.zeros(len(along)), np.full(len(wide), SOFT)]
    order = np.random.default_rng(0).permutation(len(pairs))
    pairs, rests, soft = pairs[order], rests[order], soft[order]
    free = np.ones(len(nodes), bool)
    free[held] = False
    skin = TriangleSurface(wearer.body.vertices, wearer.body.faces)
    points, before = nodes.copy(), nodes.copy()
    for number in range(STEPS):
        if number % 20 == 0:
            at = skin.closest(points)
            feet, normals = at.foot, skin.face_normals[at.face]
        step(points, before, pairs, rests, soft, free, feet, normals, 0.003, STEP)
    speed = np.linalg.norm(points - before, axis=1) / STEP
    print(f"  at rest to {1e3 * np.median(speed):.1f} mm/s; sides longer than flat by", end=" ")
    now = np.linalg.norm(np.diff(points[edges.edges], axis=1)[:, 0], axis=1)
    print(f"{100 * np.median(now / along - 1):.2f} %", flush=True)
    return points


def write_packs(out: Path, name: str) -> None:
    """Drape a flared garment and write a pack for each density."""
    template, start, amount = GARMENTS[name]
    pattern = flare(load_template(template), start, amount)
    wearer = WearerGeometry(builtin_body(BODY))
    garment = remesh(drape_template(pattern, wearer), VERTICES)
    contours, _ = name_contours(garment.nodes, garment.faces, wearer.body)
    held = np.concatenate([np.zeros(0, np.int64), *(c.vertices for c in contours if c.name == "waist")])
    print(f"{name}: {len(garment.faces)} faces", flush=True)
    vertices, faces = drape(garment.nodes, garment.faces, garment.rest, held, wearer), garment.faces
    panels = {}
    for panel in pattern.panels:
        edges = [edge_points(panel, n, 25) for n in range(len(panel.edges))]
        panels[panel.name] = {"outline": np.concatenate([edge[:-1] for edge in edges]).tolist(),
                              "edges": [edge.tolist() for edge in edges]}  # fmt: skip
    stitches = [{"a": [seam.a.panel, seam.a.edge], "b": [seam.b.panel, seam.b.edge]} for seam in pattern.seams]
    for times in range(max(SPLITS) + 1):
        if times:
            vertices, faces = trimesh.remesh.subdivide(vertices, faces)
        if times in SPLITS:
            folder = out / f"{name}_{len(faces) // 1000}k"
            folder.mkdir(parents=True, exist_ok=True)
            noisy = vertices + NOISE * np.random.default_rng(times).standard_normal(vertices.shape)
            trimesh.Trimesh(noisy, faces, process=False).export(folder / "garment.ply")
            trimesh.Trimesh(wearer.body.vertices, wearer.body.faces, process=False).export(folder / "body.ply")
            save_pattern(load_template(template), folder / "template.json")
            (folder / "pattern.json").write_text(json.dumps({"unit": "m", "panels": panels, "stitches": stitches}))
            (folder / "meta.json").write_text(json.dumps({"category": pattern.category}))


def main() -> None:
    """Print a row for each garment and density."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("garments", nargs="*", default=list(GARMENTS))
    parser.add_argument("--out", type=Path, help="folder to keep the packs in; those that are there are not made again")
    parser.add_argument("--method", default="deform")
    chosen = parser.parse_args()
    out = chosen.out or Path(tempfile.mkdtemp())
    for name in chosen.garments:
        if not list(out.glob(f"{name}_*")):
            write_packs(out, name)
        for folder in sorted(out.glob(f"{name}_*"), key=lambda path: path.stat().st_mtime):
            pack = read_packs(folder)[0]
            found = recover(Request(pack.garment, pack.body, pack.template, RecoverySettings(method=chosen.method)))
            metrics, _ = measure_recovery(found, pack, own_template=True)
            trust = {contour.name: contour.trusted for contour in found.target.contours}
            shown = ("panel_outline_mm", "panel_area_error", "surface_rms_mm.s2t", "surface_rms_mm.t2s")
            values = ", ".join(f"{key} {metrics[key]:.3f}" for key in shown if metrics.get(key) is not None)
            print(f"{folder.name}: {trust}, {values}, {found.report.cpu_seconds:.0f} s", flush=True)


if __name__ == "__main__":
    main()
