"""The body's distance grid: accuracy, smoothness, sign, what lies outside."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from garmentq.core.body.distance import DistanceBad, DistanceGrid


@pytest.fixture(scope="module")
def capsule():
    mesh = trimesh.creation.capsule(height=0.3, radius=0.08, count=[48, 48])
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


@pytest.fixture(scope="module")
def grid(capsule):
    return DistanceGrid.from_mesh(*capsule)


def true_distance(points, low, high, radius=0.08):
    """Distance to a capsule whose axis runs from low to high along z."""
    axis = points * [1.0, 1.0, 0.0]
    axis[:, 2] = points[:, 2] - np.clip(points[:, 2], low, high)
    return np.linalg.norm(axis, axis=1) - radius


def near_points(capsule, count=4000, reach=0.012):
    rng = np.random.default_rng(0)
    mesh = trimesh.Trimesh(*capsule, process=False)
    points, face = trimesh.sample.sample_surface(mesh, count, seed=1)
    return points + mesh.face_normals[face] * rng.uniform(-reach, reach, (count, 1))


def test_accuracy_near_the_surface(grid, capsule):
    """A missing prefilter (errors of a millimetre) or a band that is too thin breaks this."""
    points = near_points(capsule)
    z = capsule[0][:, 2]
    exact = true_distance(points, z.min() + 0.08, z.max() - 0.08)
    error = np.abs(grid.distance(points) - exact)
    assert np.quantile(error, 0.99) < 4e-4  # the mesh's own facets are 0.17 mm off the capsule


def test_two_continuous_derivatives(grid, capsule):
    """A trilinear or wrongly scaled lookup breaks this: gradient and Hessian against central differences."""
    points = near_points(capsule, 200)
    _, gradient, hessian = grid.evaluate(points)
    for d in range(3):
        step = np.zeros(3)
        step[d] = 1e-6
        above, below = grid.evaluate(points + step), grid.evaluate(points - step)
        assert np.abs((above[0] - below[0]) / 2e-6 - gradient[:, d]).max() < 1e-6
        assert np.abs((above[1] - below[1]) / 2e-6 - hessian[:, d]).max() < 1e-3


def test_sign_everywhere(grid):
    """Cells beyond the exact band with the wrong sign break this."""
    assert grid.distance(np.array([[0.0, 0.0, 0.15]]))[0] < -0.05  # the axis, 8 cm deep
    assert grid.distance(np.array([[0.15, 0.0, 0.15]]))[0] > 0.05
    assert grid.distance(np.array([[5.0, 0.0, 0.0], [np.nan, 0.0, 0.0]])).min() > 0.5  # outside the grid


def test_holes_and_orientation_do_not_matter(grid, capsule):
    """A scan's body has holes, and some writers turn all faces inwards."""
    vertices, faces = capsule
    points = near_points(capsule, 500, 0.005)
    plain = grid.distance(points)
    inside_out = DistanceGrid.from_mesh(vertices, faces[:, ::-1])
    assert np.abs(inside_out.distance(points) - plain).max() < 1e-9
    centre = vertices[faces].mean(1)
    hole = np.linalg.norm(centre - centre[0], axis=1) < 0.012
    holed = DistanceGrid.from_mesh(vertices, faces[~hole])
    away = np.linalg.norm(points - centre[0], axis=1) > 0.05
    assert np.abs(holed.distance(points) - plain)[away].max() < 2e-4


def test_moved(grid):
    """Broken where a moved body has another field than that of the body where it was."""
    points = np.array([[0.09, 0.0, 0.1], [0.07, 0.02, 0.05]])
    shift = np.array([0.1, -0.2, 0.3])
    assert grid.moved(shift).distance(points + shift) == pytest.approx(grid.distance(points))


def test_empty_mesh_is_refused():
    """No faces, or NaN, end in one clear error."""
    with pytest.raises(DistanceBad):
        DistanceGrid.from_mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=int))
