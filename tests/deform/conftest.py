"""A smooth tube around a post: a garment, its swollen form as a target with another triangulation, and a body."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.judge.fit import measure_distance
from garmentq.core.scan.contours.target import Target


def swell(points: np.ndarray) -> np.ndarray:
    """Bend and scale points smoothly: 8 % wider, 3 % shorter, leaning, with eight folds that grow to the hem."""
    offset = points - [0.0, 0.95, 0.0]
    angle = np.arctan2(points[:, 0], points[:, 2])
    radius = 1.08 + 0.025 * np.sin(8.0 * angle) * np.clip(0.8 - offset[:, 1] / 0.3, 0.0, 1.3)
    lean = 0.2 * offset[:, 1] ** 2
    return np.stack([offset[:, 0] * radius + lean, 0.95 + 0.97 * offset[:, 1], offset[:, 2] * radius], axis=1)


def make_target(vertices, faces, contours) -> Target:
    """Return a target with area-weighted normals."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    normals = trimesh.geometry.weighted_vertex_normals(
        len(vertices), mesh.faces, mesh.face_normals, np.repeat(mesh.area_faces[:, None], 3, axis=1)
    )
    return Target(vertices, faces, np.asarray(normals), contours, (), "skirt")


@pytest.fixture(scope="session")
def to_target():
    """Return the maker of targets."""
    return make_target


@pytest.fixture(scope="session")
def scene(tube, tube_pattern):
    """Return (garment, target, body): edges of 2.5 cm, a target of 2 cm edges, a thin egg as the body."""
    garment = tube(tube_pattern(), edge_length=0.025)
    other = tube(tube_pattern(), edge_length=0.02)
    egg = trimesh.creation.icosphere(subdivisions=3, radius=0.12)
    body = ExposedSurface(egg.vertices * [1.0, 2.0, 1.0] + [0.0, 0.95, 0.0], np.array(egg.faces))
    return garment, make_target(swell(other.nodes), other.faces, other.contours), body


@pytest.fixture(scope="session")
def rms():
    """Return the RMS distances [mm] between a mesh and a target, (ours to theirs, theirs to ours)."""

    def measure(nodes, faces, target):
        found = measure_distance(nodes, faces, target.vertices, target.faces, samples=5000)
        return found["surface_rms_mm.s2t"], found["surface_rms_mm.t2s"]

    return measure


@pytest.fixture(scope="session")
def fitted(scene):
    """Return the default result on the scene."""
    from garmentq.core.recover.deform.deformer import deform

    return deform(*scene)
