"""Recover what is no garment, or not worn as one: each must be refused with a code, or fail a gate.

OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/odd_objects.py [NAME ...]

A sphere with three holes, four copies of a T-shirt 2 mm apart, a tube that hangs around the body and touches it
nowhere, and a skirt upside down. Status 1 where one passes, or where the T-shirt and the skirt themselves fail.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.stage import drape_template, remesh
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.run.errors import BadInput

Mesh = tuple[np.ndarray, np.ndarray]

VERTICES = 3000
"""Of the garments: a coarse scan's, so that a row takes less than a minute."""
RADIUS = 0.33
"""Of the sphere [m]: it holds the trunk and reaches from thighs to breast."""
HOLES = ((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
"""Directions of its holes: body comes out of two, and one looks ahead."""


def make_worn(name: str, body: Body) -> Mesh:
    """Return a template on the body."""
    garment = remesh(drape_template(load_template(name), WearerGeometry(body)), VERTICES)
    return garment.nodes, garment.faces


def make_sphere(body: Body) -> Mesh:
    """Return a sphere around the pelvis with three holes."""
    ball = trimesh.creation.icosphere(subdivisions=4, radius=RADIUS)
    centres = ball.triangles_center / np.linalg.norm(ball.triangles_center, axis=1, keepdims=True)
    kept = np.max([centres @ np.array(way) for way in HOLES], axis=0) < 0.8
    ball = trimesh.Trimesh(ball.vertices + body.joint("pelvis"), ball.faces[kept], process=True)
    return np.array(ball.vertices), np.array(ball.faces)


def make_copies(body: Body) -> Mesh:
    """Return four T-shirts, one 2 mm above the other."""
    points, faces = make_worn("tshirt", body)
    normals = vertex_normals(points, faces)
    copies = np.concatenate([points + 0.002 * k * normals for k in range(4)])
    return copies, np.concatenate([faces + k * len(points) for k in range(4)])


def make_tube(body: Body, radius: float = 0.45) -> Mesh:
    """Return an open tube around the body from the knees to the waist."""
    tube = trimesh.creation.cylinder(radius=radius, height=0.6, sections=120)
    tube = tube.subdivide().subdivide().subdivide()
    side = np.abs(tube.face_normals[:, 2]) < 0.5
    tube = trimesh.Trimesh(tube.vertices, tube.faces[side], process=True)
    points = np.array(tube.vertices)[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
    return points + body.joint("pelvis") - [0.0, 0.2, 0.0], np.array(tube.faces)


def make_upside_down(body: Body) -> Mesh:
    """Return a skirt with its hem at the waist."""
    points, faces = make_worn("skirt", body)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return middle + (points - middle) * [1.0, -1.0, -1.0], faces


ODD: dict[str, Callable[[Body], Mesh]] = {
    "sphere": make_sphere, "copies": make_copies, "tube": make_tube, "upside_down": make_upside_down
}  # fmt: skip
SOUND: dict[str, Callable[[Body], Mesh]] = {
    "tshirt": lambda body: make_worn("tshirt", body), "skirt": lambda body: make_worn("skirt", body)
}  # fmt: skip


def judge(mesh: Mesh, body: Body, folder: Path) -> tuple[str, list[str]]:
    """Recover a surface; return what became of it, and the gates that failed."""
    trimesh.Trimesh(*mesh, process=False).export(folder / "garment.ply")
    trimesh.Trimesh(body.vertices, body.faces, process=False).export(folder / "body.ply")
    try:
        request = Request(folder / "garment.ply", folder / "body.ply", None, RecoverySettings(method="deform"))
        found = recover(request)
    except BadInput as error:
        return f"refused, {error.code}", [error.code]
    failed = [f"{gate.name} {gate.value:.3g}" for gate in found.report.gates if gate.verdict == "fail"]
    return f"{found.target.category}, {found.report.cpu_seconds:.0f} s", failed


def main() -> int:
    """Print a row for each object; return 1 where one went otherwise."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=[*ODD, *SOUND])
    body, wrong = builtin_body("builtin:female,height=1.70"), 0
    for name in parser.parse_args().names:
        with tempfile.TemporaryDirectory() as folder:
            outcome, failed = judge((ODD | SOUND)[name](body), body, Path(folder))
        wrong += bool(failed) != (name in ODD)
        print(f"{name}: {outcome}; fails {', '.join(failed) or 'nothing'}", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
