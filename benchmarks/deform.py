"""Time the deformer and its parts on a smooth tube with folds: `python benchmarks/deform.py [--thesis]`.

Prints CPU seconds of one thread at about 1K, 3K and 8K nodes, the figures to reach, and what was reached. No file
is needed. Set OMP_NUM_THREADS=1 to compare with the table in docs/lab/deform.md.
"""

from __future__ import annotations

import sys
import time

import numpy as np
import trimesh
from garmentq.core.body.body import Body
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.geometry.geometry import gradient_operator, vertex_normals
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.judge.fit import measure_distance
from garmentq.core.recover.deform.deformer import deform
from garmentq.core.recover.deform.poisson import PoissonSystem
from garmentq.core.recover.deform.settings import DeformSettings
from garmentq.core.scan.contours.target import Contour, Target

RADIUS, HEIGHT, FLOOR = 0.16, 0.6, 0.4
SIZES = {"1K": (0.0265, 3.0), "3K": (0.0153, 6.0), "8K": (0.0094, 15.0)}
"""Edge length [m] and seconds to reach of each size (the deformer, whole)."""


def make_tube(edge_length: float) -> Garment:
    """Sew two rectangles into a tube around the y axis, with its contours named."""
    width = np.pi * RADIUS
    points = np.array([[0.0, 0.0], [width, 0.0], [width, HEIGHT], [0.0, HEIGHT]])
    edges = (Edge(contour="hem"), Edge(), Edge(contour="waist"), Edge())
    panels = tuple(Panel(name, points, edges) for name in ("front", "back"))
    seams = tuple(Seam(EdgeRef("front", a), EdgeRef("back", b)) for a, b in ((1, 3), (3, 1)))
    garment = mesh_pattern(Pattern("tube", panels, seams), edge_length=edge_length)
    angle = np.pi * (garment.uv[:, 0] / width + garment.panel_of_uv) - np.pi / 2
    place = np.stack([RADIUS * np.sin(angle), FLOOR + garment.uv[:, 1], RADIUS * np.cos(angle)], axis=1)
    nodes = np.zeros((len(garment.nodes), 3))
    nodes[garment.uv_node] = place
    contours = []
    for name, y in (("hem", FLOOR), ("waist", FLOOR + HEIGHT)):
        rim = np.flatnonzero(np.abs(nodes[:, 1] - y) < 1e-9)
        contours.append(Contour(name, rim[np.argsort(np.arctan2(nodes[rim, 0], nodes[rim, 2]))], 2 * width))
    return garment.at(nodes, tuple(contours))


def make_target(edge_length: float) -> Target:
    """Swell, bend and fold the tube, with another triangulation."""
    tube = make_tube(edge_length)
    x, y, z = tube.nodes.T
    angle, down = np.arctan2(x, z), (FLOOR + HEIGHT - y) / HEIGHT
    swell = 1.08 + 0.1 * down * np.sin(9 * angle + 2 * down) + 0.01 * np.sin(23 * angle)
    vertices = np.stack([x * swell + 0.03 * np.sin(5 * y), y + 0.01 * np.cos(3 * angle), z * swell], axis=1)
    return Target(vertices, tube.faces, vertex_normals(vertices, tube.faces), tube.contours, (), "skirt")


def make_body() -> Body:
    """Stand a post inside the tube."""
    post = trimesh.creation.icosphere(subdivisions=5, radius=0.13)
    vertices, faces = post.vertices * [1.0, 6.0, 1.0] + [0.0, 0.7, 0.0], np.array(post.faces)
    joints, weights = np.zeros((24, 3)), np.zeros((len(vertices), 24))
    pose = np.tile(np.eye(4), (24, 1, 1))
    return Body(vertices, faces, joints, weights, pose, vertices, faces, joints, weights, np.eye(3))


def cpu_ms(call, repeats: int = 10) -> float:
    """Return the CPU milliseconds of a call, mean of several after one to warm up."""
    call()
    start = time.process_time()
    for _ in range(repeats):
        call()
    return 1e3 * (time.process_time() - start) / repeats


def main() -> None:
    """Print the tables."""
    settings = DeformSettings.thesis() if "--thesis" in sys.argv else DeformSettings()
    body = ExposedSurface.of(make_body())
    deform(make_tube(0.05), make_target(0.045), body, settings=DeformSettings(iterations=5, polish_iterations=1))
    print("| nodes | factor ms | solve ms | tree ms | closest ms | crossings ms | whole s (to reach) | s2t / t2s mm |")
    print("|---|---|---|---|---|---|---|---|")
    for edge_length, goal in SIZES.values():
        garment, target = make_tube(edge_length), make_target(0.9 * edge_length)
        gradient, areas = gradient_operator(garment.rest, garment.faces, len(garment.nodes))
        system, rows = PoissonSystem(gradient, areas), np.asarray(gradient @ garment.nodes)
        surface = TriangleSurface(target.vertices, target.faces)
        parts = [
            cpu_ms(lambda g=gradient, a=areas: PoissonSystem(g, a)),
            cpu_ms(lambda s=system, r=rows: s.positions(r)),
            cpu_ms(lambda t=target: TriangleSurface(t.vertices, t.faces)),
            cpu_ms(lambda s=surface, n=garment.nodes: s.closest(n)),
            cpu_ms(lambda n=garment.nodes, f=garment.faces: self_intersections(n, f)),
        ]
        start = time.process_time()
        found = deform(garment, target, body, settings=settings)
        seconds = time.process_time() - start
        error = measure_distance(found.nodes, garment.faces, target.vertices, target.faces)
        ends = f"{error['surface_rms_mm.s2t']:.2f} / {error['surface_rms_mm.t2s']:.2f}"
        times = " | ".join(f"{part:.1f}" for part in parts)
        print(f"| {len(garment.nodes)} | {times} | {seconds:.1f} ({goal:.0f}) | {ends} |", flush=True)


if __name__ == "__main__":
    main()
