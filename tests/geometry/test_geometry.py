"""Areas, normals, derivatives and curvatures against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.geometry.geometry import (
    area_vectors,
    bending_matrix,
    corner_angles,
    cotangent_laplacian,
    deformation_gradients,
    edge_curvature,
    face_areas,
    face_normals,
    gradient_operator,
    mean_curvature,
    polar_rotations,
    principal_stretches,
    right_stretch,
    shape_gradients,
    signed_areas,
    signed_volume,
    unit,
    vertex_areas,
    vertex_normals,
)
from hypothesis import given
from hypothesis import strategies as st

RADIUS = 0.3


@pytest.fixture(scope="module")
def sphere():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=RADIUS)
    return np.array(ball.vertices), np.array(ball.faces)


@pytest.fixture(scope="module")
def tube():
    """An open cylinder of even triangles."""
    around, up = 96, 40
    angle, row = np.meshgrid(np.arange(around), np.arange(up + 1), indexing="xy")
    turn = 2 * np.pi * (angle + 0.5 * (row % 2)) / around
    height = np.sqrt(3) * np.pi * RADIUS / around * row
    vertices = np.stack([RADIUS * np.cos(turn), RADIUS * np.sin(turn), height], axis=-1).reshape(-1, 3)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(around), np.arange(up), indexing="xy"))
    a, b = j * around + i, j * around + (i + 1) % around
    c, d = a + around, b + around
    odd = (j % 2 == 1)[:, None]
    one = np.where(odd, np.stack([a, b, d], 1), np.stack([a, b, c], 1))
    two = np.where(odd, np.stack([a, d, c], 1), np.stack([b, d, c], 1))
    return vertices, np.concatenate([one, two])


@pytest.fixture(scope="module")
def flat():
    """An uneven mesh of the unit square."""
    count = 9
    line = np.linspace(0, 1, count)
    points = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
    inner = (points > 0).all(1) & (points < 1).all(1)
    points[inner] += np.random.default_rng(0).uniform(-0.03, 0.03, (inner.sum(), 2))
    i, j = (part.ravel() for part in np.meshgrid(np.arange(count - 1), np.arange(count - 1), indexing="ij"))
    a = i * count + j
    b, c, d = a + 1, a + count, a + count + 1
    return points, np.concatenate([np.stack([a, c, d], 1), np.stack([a, d, b], 1)])


def test_a_tetrahedron():
    """A normal that points inwards, or an area by a factor, breaks this."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    normals, areas = face_normals(vertices, faces)
    assert np.allclose(areas, [0.5, 0.5, np.sqrt(3) / 2, 0.5], atol=1e-15)
    assert np.allclose(normals[[0, 1, 3]], [[0, 0, -1], [0, -1, 0], [-1, 0, 0]])
    assert np.allclose(normals[2], 1 / np.sqrt(3))
    # the area vectors of a closed surface cancel
    assert np.abs(area_vectors(vertices, faces).sum(0)).max() < 1e-15
    assert np.allclose(corner_angles(vertices, faces).sum(1), np.pi)
    assert signed_volume(vertices + 5.0, faces) == pytest.approx(1 / 6)
    assert signed_volume(vertices, faces[:, ::-1]) == pytest.approx(-1 / 6)
    assert np.allclose(vertex_areas(vertices, faces).sum(), areas.sum())


def test_a_face_without_area_has_no_normal():
    """A division by zero, or a direction of noise, breaks this."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    normals, areas = face_normals(vertices, np.array([[0, 1, 2]]))
    assert not normals.any() and not areas.any()
    assert not vertex_normals(vertices, np.array([[0, 1, 2]])).any()
    assert not unit(np.zeros((2, 3))).any()


def test_a_sphere(sphere):
    """A mean curvature other than 1 / r, of the wrong sign, or normals off the radius break this."""
    vertices, faces = sphere
    outward = vertices / RADIUS
    assert face_areas(vertices, faces).sum() == pytest.approx(4 * np.pi * RADIUS**2, rel=3e-3)
    assert (vertex_normals(vertices, faces) * outward).sum(1).min() > 0.9999
    # at the twelve vertices of five faces a third of the area is not the dual cell's
    even = np.bincount(faces.ravel()) == 6
    curvature = mean_curvature(vertices, faces)
    assert np.median(curvature) == pytest.approx(1 / RADIUS, rel=5e-3)
    assert np.abs(curvature[even] * RADIUS - 1).max() < 0.1
    assert np.allclose(mean_curvature(vertices, faces[:, ::-1]), -curvature)
    assert edge_curvature(vertices, outward, faces) == pytest.approx(1 / RADIUS)


def test_a_tube(tube):
    """A mean curvature other than 1 / (2 r) inside, or one on the open borders, breaks this."""
    vertices, faces = tube
    border = HalfEdges.of(faces).border_vertices
    assert border.sum() == 192
    curvature = mean_curvature(vertices, faces)
    assert np.abs(curvature[~border] * 2 * RADIUS - 1).max() < 2e-3
    assert not curvature[border].any()
    normals = vertex_normals(vertices, faces)
    assert (normals[~border, :2] * vertices[~border, :2]).sum(1) / RADIUS == pytest.approx(1.0, abs=1e-9)


def test_the_gradient_of_a_linear_field_is_exact(flat):
    """A row of the operator out of place, or of the wrong sign, breaks this."""
    points, faces = flat
    operator, areas = gradient_operator(points[faces], faces, len(points))
    slope = (operator @ (points @ [2.0, -3.0] + 1.0)).reshape(-1, 2)
    assert np.allclose(slope, [2.0, -3.0], atol=1e-12)
    assert areas.sum() == pytest.approx(1.0)
    assert np.allclose(signed_areas(points[faces]), areas)
    assert np.allclose(signed_areas(points[faces][:, ::-1]), -areas)


def test_the_laplacian_of_a_linear_field_vanishes_inside(flat):
    """Cotangents at the wrong corner, or a matrix that is not G^T A G, break this."""
    points, faces = flat
    laplacian = cotangent_laplacian(points[faces], faces, len(points))
    border = HalfEdges.of(faces).border_vertices
    assert np.abs((laplacian @ (points @ [2.0, -3.0]))[~border]).max() < 1e-12
    assert np.abs(laplacian @ np.ones(len(points))).max() < 1e-12
    operator, areas = gradient_operator(points[faces], faces, len(points))
    assert np.abs(laplacian - operator.T @ (np.repeat(areas, 2)[:, None] * operator.toarray())).max() < 1e-12
    assert np.linalg.eigvalsh(laplacian.toarray()).min() > -1e-12
    space = np.column_stack([points, points @ [0.4, 0.1]])  # a tilted plane has other angles
    assert np.abs((cotangent_laplacian(space[faces], faces, len(points)) @ space)[~border]).max() < 1e-12


def test_bending_of_a_parabola(flat):
    """int |lap d|^2 dA of d = x^2 / 2 is the area away from the border: a weight by a factor breaks this."""
    line = np.linspace(0, 1, 41)
    points = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(40), np.arange(40), indexing="ij"))
    a = i * 41 + j
    faces = np.concatenate([np.stack([a, a + 41, a + 42], 1), np.stack([a, a + 42, a + 1], 1)])
    space = np.column_stack([points, np.zeros(len(points))])
    weights = np.where(HalfEdges.of(faces).border_vertices, 0.0, 1.0 / vertex_areas(space, faces))
    bending = bending_matrix(cotangent_laplacian(points[faces], faces, len(points)), weights)
    field = 0.5 * points[:, 0] ** 2
    assert field @ bending @ field == pytest.approx(1.0, abs=0.06)


@given(st.floats(0.5, 2.0), st.floats(0.5, 2.0), st.floats(-3.0, 3.0))
def test_stretch_and_rotation_of_a_face(wide, long, turn):
    """F = R U with the wrong factor first, or principal stretches in the wrong order, break this."""
    rest = np.array([[[0.0, 0.0], [1.0, 0.1], [0.2, 0.9]]])
    cos, sin = np.cos(turn), np.sin(turn)
    own = np.array([[cos, -sin], [sin, cos]])
    stretch = own @ np.diag([wide, long]) @ own.T
    frame = np.array([[0.0, 1.0], [0.6, 0.0], [0.8, 0.0]])
    nodes = rest[0] @ (frame @ stretch).T + 0.5
    gradients = deformation_gradients(nodes, np.array([[0, 1, 2]]), rest)
    assert np.allclose(gradients[0], frame @ stretch)
    assert np.allclose(right_stretch(gradients)[0], stretch)
    assert np.allclose(polar_rotations(gradients)[0], frame)
    assert np.allclose(principal_stretches(gradients)[0], sorted([wide, long], reverse=True))


def test_shape_gradients_sum_to_nothing_and_stay_finite():
    """A sliver whose gradient is infinite, or a partition of unity that is none, breaks this."""
    rest = np.array([[[0.0, 0.0], [1.0, 0.0], [0.3, 0.7]], [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]])
    gradients = shape_gradients(rest)
    assert np.isfinite(gradients).all()
    assert np.abs(gradients.sum(axis=1)).max() < 1e-9
    spans = np.stack([rest[0, 1] - rest[0, 0], rest[0, 2] - rest[0, 0]], axis=1)
    assert np.allclose(gradients[0, 1:], np.linalg.inv(spans))
