"""The box tree's closest points, beside libigl's and beside points of the triangles themselves."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from garmentq.core.geometry.box_tree import BoxTree
from hypothesis import given, settings
from hypothesis import strategies as st

STEPS = 12
"""Parts of a side of the lattice of points that are tried in each triangle."""


def draw(seed: int, flat: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices, faces and points; in `flat` dimensions. A third of the seeds put vertices on each other, faces
    name a vertex twice, and some triangles are needles of a nanometre."""
    rng = np.random.default_rng(seed)
    vertices, faces = rng.normal(size=(40, 3)), rng.integers(0, 40, (rng.integers(1, 90), 3))
    vertices[:8] = vertices[8:16] + 1e-9 * rng.normal(size=(8, 3))
    points = rng.normal(size=(60, 3)) * rng.choice([0.1, 1.0, 30.0])
    if seed % 3 == 0:
        vertices, points = np.round(vertices), np.round(2.0 * points) / 2.0
    vertices[:, flat:] = 0.0
    return vertices, faces, np.ascontiguousarray(points)


def lattice(triangles: np.ndarray) -> np.ndarray:
    """Return points of each triangle, corners and edges among them, shape [n, 3]."""
    v, w = (part.ravel() for part in np.meshgrid(*2 * [np.linspace(0.0, 1.0, STEPS + 1)]))
    inside = v + w <= 1.0 + 1e-12
    shares = np.stack([1.0 - v - w, v, w], axis=1)[inside]
    return np.einsum("pk,tkd->tpd", shares, triangles).reshape(-1, 3)


@given(st.integers(0, 10_000), st.sampled_from([1, 2, 3]))
@settings(max_examples=60, deadline=None)
def test_feet_are_on_their_faces_and_nothing_is_nearer(seed: int, flat: int) -> None:
    """Breaks if a box is too small, a branch is passed over, or a triangle without area loses its edges."""
    vertices, faces, points = draw(seed, flat)
    distance, face, foot, shares = BoxTree(vertices, faces).search(points)
    np.testing.assert_allclose(np.einsum("nk,nkd->nd", shares, vertices[faces[face]]), foot, atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(points - foot, axis=1), distance, rtol=1e-14, atol=1e-15)
    assert shares.min() >= 0.0 and np.abs(shares.sum(axis=1) - 1.0).max() < 1e-15
    tried = lattice(vertices[faces])
    nearest = np.linalg.norm(points[:, None] - tried, axis=2).min(axis=1)
    assert (distance <= nearest + 1e-12).all()


@given(st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_distances_are_those_of_libigl(seed: int) -> None:
    """Breaks if a foot is not the closest. libigl's is beside some needles farther, where ours is checked above."""
    vertices, faces, points = draw(seed)
    squared, _, _ = igl.point_mesh_squared_distance(points, vertices, faces)
    distance = BoxTree(vertices, faces).search(points)[0]
    assert (distance <= np.sqrt(squared) + 1e-12).all()
    a, b, c = vertices[faces].transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    sound = np.ascontiguousarray(faces[area > 1e-3])
    if len(sound):
        squared, _, _ = igl.point_mesh_squared_distance(points, vertices, sound)
        np.testing.assert_allclose(BoxTree(vertices, sound).search(points)[0], np.sqrt(squared), atol=1e-12)


@given(st.integers(0, 10_000))
@settings(max_examples=40, deadline=None)
def test_refitting_and_hints_change_no_distance(seed: int) -> None:
    """Breaks if boxes stay where the vertices were, or a first bound hides a nearer face."""
    vertices, faces, points = draw(seed)
    rng = np.random.default_rng(seed)
    fresh = BoxTree(vertices, faces).search(points)
    moved = BoxTree(rng.normal(size=vertices.shape), faces).refit(vertices)
    for hints in (None, rng.integers(0, len(faces), len(points)), fresh[1]):
        found = moved.search(points, hints)
        np.testing.assert_allclose(found[0], fresh[0], rtol=1e-14, atol=1e-15)
        np.testing.assert_allclose(np.linalg.norm(points - found[2], axis=1), fresh[0], rtol=1e-14, atol=1e-15)
    again = BoxTree(vertices, faces).search(points)
    assert all(np.array_equal(one, other) for one, other in zip(fresh, again, strict=True))


def test_a_tree_without_faces_answers_nobody() -> None:
    """Breaks if a search reads beyond the end of no triangles."""
    empty = BoxTree(np.zeros((3, 3)), np.zeros((0, 3), dtype=np.int64))
    assert len(empty.search(np.zeros((0, 3)))[0]) == 0
    with pytest.raises(IndexError):
        empty.search(np.zeros((2, 3)))
