"""Closest points, samples and normals of a triangle surface, against shapes whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from garmentq.core.geometry.surface import TriangleSurface, barycentric_coordinates
from hypothesis import given, settings
from hypothesis import strategies as st


def sphere(radius: float = 0.3, subdivisions: int = 4) -> TriangleSurface:
    """Return a fine icosphere."""
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return TriangleSurface(np.array(mesh.vertices), np.array(mesh.faces))


def square() -> TriangleSurface:
    """Return the unit square in z = 0, facing +z, of two triangles."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    return TriangleSurface(vertices, np.array([[0, 1, 2], [0, 2, 3]]))


def crumpled(seed: int) -> TriangleSurface:
    """Return triangles that share no order: some thin, some crossing."""
    rng = np.random.default_rng(seed)
    return TriangleSurface(rng.normal(size=(30, 3)), rng.permuted(np.tile(np.arange(30), (20, 1)), axis=1)[:, :3])


def test_closest_points_of_a_sphere_lie_towards_its_centre() -> None:
    """Breaks if feet are vertices, or distances squared: they end within the sagitta of a facet, 0.6 mm."""
    surface, rng = sphere(), np.random.default_rng(0)
    points = rng.normal(size=(500, 3))
    found = surface.closest(points)
    radius = np.linalg.norm(points, axis=1)
    np.testing.assert_allclose(found.distance, np.abs(radius - 0.3), atol=6e-4)
    np.testing.assert_allclose(found.foot, 0.3 * points / radius[:, None], atol=2e-2)
    np.testing.assert_allclose(found.distance, np.linalg.norm(points - found.foot, axis=1), atol=1e-12)


def test_closest_points_of_a_square_are_its_projection() -> None:
    """Breaks if a foot leaves the surface at an edge or a corner: it is the point clamped to the square."""
    points = np.random.default_rng(1).uniform(-1.0, 2.0, size=(300, 3))
    found = square().closest(points)
    wanted = np.clip(points, 0.0, 1.0) * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(found.foot, wanted, atol=1e-14)
    assert len(square().closest(np.zeros((0, 3))).face) == 0


@given(st.integers(0, 1000))
@settings(max_examples=25, deadline=None)
def test_no_sample_is_nearer_than_the_closest_point(seed: int) -> None:
    """Breaks if the tree passes over a face, or coordinates and foot disagree; also on thin and crossing triangles."""
    surface, rng = crumpled(seed), np.random.default_rng(seed)
    points = rng.normal(size=(40, 3))
    found = surface.closest(points)
    samples, _ = surface.sample(400, rng)
    assert (np.linalg.norm(points[:, None] - samples[None], axis=2).min(axis=1) >= found.distance - 1e-9).all()
    np.testing.assert_allclose(found.barycentric.sum(axis=1), 1.0, atol=1e-12)
    assert found.barycentric.min() >= 0.0
    np.testing.assert_allclose(found.interpolate(surface.vertices, surface.faces), found.foot, atol=1e-9)
    matrix = found.interpolation(surface.faces, len(surface.vertices))
    np.testing.assert_allclose(matrix @ surface.vertices, found.foot, atol=1e-9)


def test_barycentric_coordinates_stay_in_the_triangle_and_stand_a_flat_one() -> None:
    """Breaks if rounding makes a coordinate negative, or a triangle without area divides by zero."""
    corners = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [0, 0, 0], [0, 0, 0]]], dtype=float)
    found = barycentric_coordinates(np.array([[1.0 + 1e-9, -1e-9, 0.0], [0.0, 0.0, 0.0]]), corners)
    np.testing.assert_allclose(found, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]], atol=1e-8)
    assert found.min() >= 0.0


def test_a_moved_surface_is_a_new_one() -> None:
    """Breaks if the tree of moved vertices answers for the old ones, the old for the new, or a border is lost."""
    surface, rng = crumpled(3), np.random.default_rng(3)
    points, vertices = rng.normal(size=(200, 3)), rng.normal(size=(30, 3))
    before, border = surface.closest(points), surface.border_faces
    moved, fresh = surface.moved(vertices), TriangleSurface(vertices, surface.faces)
    np.testing.assert_array_equal(moved.distance(points), fresh.distance(points))
    np.testing.assert_array_equal(moved.face_normals, fresh.face_normals)
    np.testing.assert_array_equal(moved.border_faces, border)
    np.testing.assert_array_equal(surface.closest(points).foot, before.foot)


def test_samples_are_uniform_by_area_and_seeded() -> None:
    """Breaks if small triangles got as many samples as large ones, or the seed did not fix them."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [3, 0, 0], [6, 0, 0], [3, 3, 0]], dtype=float)
    surface = TriangleSurface(vertices, np.array([[0, 1, 2], [3, 4, 5]]))
    points, face = surface.sample(20000, np.random.default_rng(3))
    again, _ = surface.sample(20000, np.random.default_rng(3))
    assert np.array_equal(points, again)
    assert np.mean(face == 1) == pytest.approx(0.9, abs=0.001)
    assert points[face == 1].mean(axis=0) == pytest.approx(vertices[3:].mean(axis=0), abs=0.02)


def test_normals_and_areas_are_those_of_a_sphere() -> None:
    """Breaks if normals point inwards or areas are not summed to the whole, 4 pi r^2 less 0.3 %."""
    surface = sphere()
    out = surface.vertices / 0.3
    np.testing.assert_allclose(surface.vertex_normals, out, atol=1e-2)
    assert (surface.face_normals * out[surface.faces].mean(axis=1)).sum(axis=1).min() > 0.99
    assert surface.vertex_areas.sum() == pytest.approx(surface.face_areas.sum())
    assert surface.face_areas.sum() == pytest.approx(4 * np.pi * 0.09, rel=5e-3)


def test_faces_on_the_border_are_those_with_two_corners_there() -> None:
    """Breaks if a closed surface has a border, or a face that touches it with one corner only counts."""
    assert not sphere(subdivisions=1).border_faces.any()
    x, y = np.meshgrid(np.arange(5.0), np.arange(5.0), indexing="ij")
    index = np.arange(25).reshape(5, 5)
    a, b, c, d = (q.ravel() for q in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    sheet = TriangleSurface(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), faces)
    edge = (sheet.vertices[:, :2] == 0).any(axis=1) | (sheet.vertices[:, :2] == 4).any(axis=1)
    np.testing.assert_array_equal(sheet.border_faces, edge[faces].sum(axis=1) > 1)
    assert 0 < sheet.border_faces.sum() < len(faces)
