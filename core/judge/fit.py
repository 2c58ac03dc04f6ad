"""Measure how well the recovered meshes fit the truth, in space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..body.exposed import ExposedSurface
from ..garment.garment import Garment
from ..garment.meshes import Meshes
from ..garment.shown_sides import find_shown_sides, select_shown_faces
from ..geometry.geometry import corner_angles, deformation_gradients, principal_stretches
from ..geometry.intersections import self_intersections
from ..geometry.rim import Rim
from ..geometry.surface import ClosestPoints, TriangleSurface
from ..run.units import MM_PER_M
from ..scan.contours.target import Contour
from .chamfer import VertexCloud, chamfer_and_normals, meshing_floor, orientation
from .contours import contour_rms
from .crossings import count_crossings
from .penetration import measure_penetration

SURFACE_SAMPLES = 50_000
"""Number of samples per direction: the RMS of a sampled distance then scatters by less than 1 %."""


@dataclass(frozen=True)
class Reference:
    """Describe the reference for the measurement of recovered meshes.

    Attributes:
        surface: The truth's own mesh, not repaired.
        contours: Named contours, indices into `vertices`; only trusted ones are measured.
        skin: The wearer's exposed skin, which must not be penetrated, or None.
        seed: Seed of the samples and the floor.
        samples: Surface samples per direction.
        hidden: Whether each vertex of the truth's border is hidden, bool, shape [n]: the garment may continue beyond
            it, and is not measured there. None: no vertex is.
    """

    surface: TriangleSurface
    contours: Sequence[Contour] = ()
    skin: ExposedSurface | None = None
    seed: int = 0
    samples: int = SURFACE_SAMPLES
    hidden: np.ndarray | None = None

    @property
    def vertices(self) -> np.ndarray:
        """Return the truth's vertices [m], shape [n, 3]."""
        return self.surface.vertices

    @cached_property
    def rim(self) -> Rim | None:
        """Return the border beyond which the garment may continue, or None."""
        return None if self.hidden is None else Rim.between(self.surface.faces, self.hidden)

    def has_counterpart(self, points: ClosestPoints) -> np.ndarray:
        """Find the points that can be measured against the truth, given its points closest to them, shape [n]."""
        if self.rim is None:
            return np.ones(len(points.face), bool)
        return ~self.rim.is_ahead(self.surface, points)

    @cached_property
    def middles(self) -> np.ndarray:
        """Return the centres of the truth's faces [m], shape [face_count, 3]."""
        return np.asarray(self.surface.vertices[self.surface.faces].mean(axis=1))

    def crossing_distance(self, points: np.ndarray, reach: float) -> np.ndarray:
        """Return the distances of points from the truth's nearest face that crosses another [m]; above `reach`, any
        value above it. Only faces that may cross one with its centre within reach are tested (reach plus both
        radii)."""
        if not len(points):
            return np.zeros(0)
        distance = cKDTree(points).query(self.middles, distance_upper_bound=2.0 * reach)[0]
        candidates = np.flatnonzero(distance <= 2.0 * reach)
        distance, middles, faces = distance[candidates], self.middles[candidates], self.surface.faces[candidates]
        radius = np.linalg.norm(self.surface.vertices[faces] - middles[:, None], axis=2).max(axis=1, initial=0.0)
        may_cross = distance <= reach + radius + radius[distance <= reach].max(initial=0.0)
        crossing = self_intersections(self.surface.vertices, faces[may_cross])
        if not len(crossing):
            return np.full(len(points), np.inf)
        return np.asarray(cKDTree(middles[may_cross][crossing]).query(points)[0])

    @cached_property
    def cloud(self) -> VertexCloud:
        """Return the truth's vertices with their normals and search tree."""
        used = _used_vertices(self.surface)
        return VertexCloud(self.vertices[used], self.surface.vertex_normals[used])


def _used_vertices(surface: TriangleSurface) -> np.ndarray:
    """Return the vertices that faces use; others are not part of a surface."""
    return np.flatnonzero(np.bincount(surface.faces.ravel(), minlength=len(surface.vertices)))


def measure_fit(garment: Garment, meshes: Meshes, truth: Reference) -> dict[str, float | None]:
    """Measure the detail mesh, and with a prefix: simulation mesh `sim.`, re-draped `redrape.`, graded drape `graded.`.

    Args:
        garment: The recovered pattern, meshed and sewn; gives faces, rest triangles and contours, not nodes.
        meshes: Its nodes.
        truth: The reference.

    Returns:
        Flat dotted names to numbers, units in the name; None where a metric does not apply.
    """
    found: dict[str, float | None] = {"vertices": float(len(meshes.detail)), "faces": float(len(garment.faces))}
    found |= measure_mesh(garment, meshes.detail, truth)
    floors = meshing_floor(truth.surface, len(meshes.detail), np.random.default_rng(truth.seed))
    found["chamfer_vertex_floor_m2e3"] = 1e3 * floors[0]
    found["normal_cosine_floor"] = floors[1]
    for prefix, nodes in (("sim.", meshes.simulation), ("redrape.", meshes.redraped)):
        if nodes is not None:
            draped = measure_mesh(garment, nodes, truth)
            found |= {prefix + name: value for name, value in draped.items()}
    graded = _measure_place(garment, meshes.graded, truth)
    graded |= count_crossings(meshes.graded, garment.faces, truth.skin)
    graded |= measure_penetration(meshes.graded, garment.faces, truth.skin)
    found |= {f"graded.{name}": value for name, value in graded.items()}
    return dict(sorted(found.items()))


def measure_distance(
    vertices: np.ndarray,
    faces: np.ndarray,
    truth_vertices: np.ndarray,
    truth_faces: np.ndarray,
    seed: int = 0,
    samples: int = SURFACE_SAMPLES,
) -> dict[str, float | None]:
    """Measure the distance between two surfaces, both ways, from area-uniform samples to the exact other surface. s2t
    is from ours to the truth, t2s from the truth to ours: a missing sleeve shows only in t2s."""
    truth = Reference(TriangleSurface(truth_vertices, truth_faces), seed=seed, samples=samples)
    return _measure_distance(TriangleSurface(vertices, faces), truth)


def _measure_distance(found_surface: TriangleSurface, truth: Reference) -> dict[str, float | None]:
    generator = np.random.default_rng(truth.seed)
    samples, true_samples = (surface.sample(truth.samples, generator)[0] for surface in (found_surface, truth.surface))
    closest = truth.surface.closest(samples)
    there = truth.has_counterpart(closest)
    if not there.any():  # no point of ours is where the truth is known
        there[:] = True
    distances = {"s2t": closest.distance[there], "t2s": found_surface.distance(true_samples)}
    found: dict[str, float | None] = {}
    for direction, distance in distances.items():
        found[f"surface_rms_mm.{direction}"] = MM_PER_M * float(np.sqrt(np.mean(distance**2)))
        found[f"surface_p95_mm.{direction}"] = MM_PER_M * float(np.quantile(distance, 0.95))
    found["hausdorff_mm"] = MM_PER_M * float(max(distance.max() for distance in distances.values()))
    if truth.rim is not None:
        found["hidden_percent"] = 100.0 * (1.0 - float(np.mean(truth.has_counterpart(closest))))
    return found


def measure_mesh(garment: Garment, nodes: np.ndarray, truth: Reference) -> dict[str, float | None]:
    """Return every metric of one mesh with the garment's topology."""
    faces = garment.faces
    surface = TriangleSurface(nodes, faces)
    used = _used_vertices(surface)
    if truth.rim is not None:
        there = truth.has_counterpart(truth.surface.closest(nodes[used]))
        used = used[there] if there.any() else used
    chamfer, cosine = chamfer_and_normals(VertexCloud(nodes[used], surface.vertex_normals[used]), truth.cloud)
    found: dict[str, float | None] = {"chamfer_vertex_m2e3": 1e3 * chamfer, "normal_cosine": cosine}
    found |= _measure_place(garment, nodes, truth)
    stretch = principal_stretches(deformation_gradients(nodes, faces, garment.rest))
    found["stretch_p001"] = float(np.quantile(stretch[:, 1], 0.001))
    found["stretch_p999"] = float(np.quantile(stretch[:, 0], 0.999))
    sides = find_shown_sides(garment.at(nodes), truth.surface, truth.surface.vertex_normals)
    found["flipped_faces"] = float(count_flipped(nodes, select_shown_faces(faces, sides), truth))
    found |= count_crossings(nodes, faces, truth.skin)
    found["min_angle_deg"] = float(np.degrees(np.quantile(corner_angles(nodes, faces).min(axis=1), 0.01)))
    return found | measure_penetration(nodes, faces, truth.skin)


def _measure_place(garment: Garment, nodes: np.ndarray, truth: Reference) -> dict[str, float | None]:
    """Return the distances of surface and contours from the truth's."""
    surface = TriangleSurface(nodes, garment.faces)
    found = _measure_distance(surface, truth)
    contours = contour_rms(nodes, garment.contours, truth.vertices, truth.contours)
    return found | {f"contour_rms_mm.{name}": MM_PER_M * value for name, value in contours.items()}


def count_flipped(vertices: np.ndarray, faces: np.ndarray, truth: Reference) -> int:
    """Count faces whose normal is opposite to the truth's at the point closest to their centre. The truth's orientation
    as a whole is decided by vote first. Faces within an edge of where the truth crosses itself, as scans of cloth
    between the thighs do, are left out: there a mesh without crossings must be on the other side of a layer."""
    surface, centres = TriangleSurface(vertices, faces), vertices[faces].mean(axis=1)
    closest = truth.surface.closest(centres)
    cosines = np.einsum("ij,ij->i", surface.face_normals, truth.surface.face_normals[closest.face])
    there = truth.has_counterpart(closest)
    against = centres[there][orientation(cosines[there]) * cosines[there] < 0.0]
    edge = float(np.linalg.norm(vertices[faces] - vertices[np.roll(faces, 1, axis=1)], axis=2).mean())
    return int(np.sum(truth.crossing_distance(against, edge) >= edge))
