"""Measure how well the recovered meshes fit the truth, in space."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..body import ExposedSurface, penetration_depth
from ..mesh import TriangleSurface, self_intersections, vertex_normals
from ..pattern import Garment
from ..segment import Contour
from .chamfer import chamfer_and_normals, meshing_floor, orientation
from .contours import contour_rms
from .surface import (
    face_angles,
    stretches,
)

SURFACE_SAMPLES = 50_000
"""Samples per direction: the RMS of a sampled distance then scatters by less than 1 %."""

MM = 1e3


def measure_fit(
    garment: Garment,
    graded: np.ndarray,
    detail: np.ndarray,
    simulation: np.ndarray | None,
    truth_vertices: np.ndarray,
    truth_faces: np.ndarray,
    truth_contours: Sequence[Contour],
    body: ExposedSurface | None,
    seed: int = 0,
    samples: int = SURFACE_SAMPLES,
    redraped: np.ndarray | None = None,
) -> dict[str, float | None]:
    """Measure the detail mesh, and with a prefix: simulation mesh `sim.`, re-draped `redrape.`, graded drape `graded.`.

    Args:
        garment: The recovered pattern, meshed and sewn; gives faces, rest triangles and contours.
        graded: Nodes of the graded drape [m], shape [node_count, 3].
        detail: Nodes of the detail mesh [m], shape [node_count, 3].
        simulation: Nodes of the simulation mesh [m], shape [node_count, 3], or None.
        truth_vertices: The truth's own vertices, not repaired [m], shape [n, 3].
        truth_faces: The truth's faces, shape [m, 3].
        truth_contours: Named contours, indices into `truth_vertices`; only trusted ones are measured.
        body: The wearer's exposed skin, which must not be penetrated, or None.
        seed: Seeds the samples and the floor.
        samples: Surface samples per direction.
        redraped: Nodes of the pattern draped from its rest placement [m], shape [node_count, 3], or None.

    Returns:
        Flat dotted names to numbers, units in the name; None where a metric does not apply.
    """
    truth = (truth_vertices, truth_faces)
    found: dict[str, float | None] = {"vertices": float(len(detail)), "faces": float(len(garment.faces))}
    found |= _measure_mesh(garment, detail, *truth, truth_contours, body, seed, samples)
    chamfer_floor, normal_floor = meshing_floor(*truth, len(detail), np.random.default_rng(seed))
    found["chamfer_vertex_floor_m2e3"] = 1e3 * chamfer_floor
    found["normal_cosine_floor"] = normal_floor
    for prefix, nodes in (("sim.", simulation), ("redrape.", redraped)):
        if nodes is not None:
            draped = _measure_mesh(garment, nodes, *truth, truth_contours, body, seed, samples)
            found |= {prefix + name: value for name, value in draped.items()}
    drape = measure_distance(graded, garment.faces, *truth, seed=seed, samples=samples)
    found |= {f"graded.{name}": value for name, value in drape.items()}
    found |= _measure_contours(garment, graded, truth_vertices, truth_contours, "graded.")
    found["graded.self_intersecting_faces"] = float(len(self_intersections(graded, garment.faces)))
    found["graded.body_penetration_mm"] = _penetration(graded, garment.faces, body)
    return dict(sorted(found.items()))


def measure_distance(
    vertices: np.ndarray,
    faces: np.ndarray,
    truth_vertices: np.ndarray,
    truth_faces: np.ndarray,
    seed: int = 0,
    samples: int = SURFACE_SAMPLES,
) -> dict[str, float | None]:
    """Measure the distance between two surfaces, both ways, from area-uniform samples to the exact other surface.

    s2t is from ours to the truth, t2s from the truth to ours: a missing sleeve shows only in t2s.
    """
    generator = np.random.default_rng(seed)
    ours, theirs = TriangleSurface(vertices, faces), TriangleSurface(truth_vertices, truth_faces)
    samples_of = [surface.sample(samples, generator)[0] for surface in (ours, theirs)]
    distances = {"s2t": theirs.closest(samples_of[0]).distance, "t2s": ours.closest(samples_of[1]).distance}
    found: dict[str, float | None] = {}
    for way, distance in distances.items():
        found[f"surface_rms_mm.{way}"] = MM * float(np.sqrt(np.mean(distance**2)))
        found[f"surface_p95_mm.{way}"] = MM * float(np.quantile(distance, 0.95))
    found["hausdorff_mm"] = MM * float(max(distance.max() for distance in distances.values()))
    return found


def _measure_mesh(
    garment: Garment,
    nodes: np.ndarray,
    truth_vertices: np.ndarray,
    truth_faces: np.ndarray,
    truth_contours: Sequence[Contour],
    body: ExposedSurface | None,
    seed: int,
    samples: int,
) -> dict[str, float | None]:
    """Give every metric of one mesh that has the garment's topology."""
    faces = garment.faces
    normals, truth_normals = vertex_normals(nodes, faces), vertex_normals(truth_vertices, truth_faces)
    # A vertex that no face uses is no part of the surface, neither ours nor the truth's.
    used, truth_used = np.unique(faces), np.unique(truth_faces)
    chamfer, cosine = chamfer_and_normals(
        nodes[used], normals[used], truth_vertices[truth_used], truth_normals[truth_used]
    )
    found: dict[str, float | None] = {"chamfer_vertex_m2e3": 1e3 * chamfer, "normal_cosine": cosine}
    found |= measure_distance(nodes, faces, truth_vertices, truth_faces, seed=seed, samples=samples)
    found |= _measure_contours(garment, nodes, truth_vertices, truth_contours, "")
    stretch = stretches(nodes, faces, garment.rest)
    found["stretch_p001"] = float(np.quantile(stretch[:, 1], 0.001))
    found["stretch_p999"] = float(np.quantile(stretch[:, 0], 0.999))
    found["flipped_faces"] = float(count_flipped(nodes, faces, truth_vertices, truth_faces))
    found["self_intersecting_faces"] = float(len(self_intersections(nodes, faces)))
    found["min_angle_deg"] = float(np.degrees(np.quantile(face_angles(nodes, faces).min(axis=1), 0.01)))
    found["body_penetration_mm"] = _penetration(nodes, faces, body)
    return found


def count_flipped(vertices: np.ndarray, faces: np.ndarray, truth_vertices: np.ndarray, truth_faces: np.ndarray) -> int:
    """Count faces whose normal points against the truth's at the point closest to their centre.

    Which way the truth as a whole is wound is settled by vote first.
    """
    ours, truth = TriangleSurface(vertices, faces), TriangleSurface(truth_vertices, truth_faces)
    closest = truth.closest(vertices[faces].mean(axis=1)).face
    cosines = np.einsum("ij,ij->i", ours.face_normals, truth.face_normals[closest])
    return int(np.sum(orientation(cosines) * cosines < 0.0))


def _measure_contours(
    garment: Garment, nodes: np.ndarray, truth_vertices: np.ndarray, truth_contours: Sequence[Contour], prefix: str
) -> dict[str, float | None]:
    found = contour_rms(nodes, garment.contours, truth_vertices, truth_contours)
    return {f"{prefix}contour_rms_mm.{name}": MM * value for name, value in found.items()}


def _penetration(nodes: np.ndarray, faces: np.ndarray, body: ExposedSurface | None) -> float | None:
    return None if body is None else MM * penetration_depth(nodes, faces, body)
