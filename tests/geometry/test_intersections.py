"""Faces that pass through other faces."""

from __future__ import annotations

import igl
import numpy as np
from garmentq.core.geometry.intersections import intersecting_pairs, self_intersections


def test_two_triangles_cross_only_where_one_edge_passes_through_the_other():
    """Breaks if touching or a near miss counts, or a crossing is found from one side only."""
    flat = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0]], dtype=float)
    through = np.array([[0.5, 0.5, -1], [0.5, 0.5, 1], [3, 3, 0.5]])
    faces = np.array([[0, 1, 2], [3, 4, 5]])
    for corners in ((flat, through), (through, flat)):
        np.testing.assert_array_equal(self_intersections(np.concatenate(corners), faces), [0, 1])
        np.testing.assert_array_equal(intersecting_pairs(np.concatenate(corners), faces), [[0, 1]])
    assert len(self_intersections(np.concatenate([flat, through + [2.0, 2.0, 0.0]]), faces)) == 0
    assert len(self_intersections(np.concatenate([flat, through + [0.0, 0.0, 1.0]]), faces)) == 0
    assert len(self_intersections(np.zeros((0, 3)), np.zeros((0, 3), dtype=int))) == 0


def test_faces_that_share_a_vertex_are_not_counted():
    """Breaks if neighbours folded through each other about a shared edge or corner count as crossing."""
    vertices = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [1, 1, -1], [1, 1, 1]], dtype=float)
    assert len(self_intersections(vertices, np.array([[0, 1, 2], [0, 3, 4]]))) == 0
    assert len(self_intersections(vertices, np.array([[0, 1, 2], [0, 1, 4]]))) == 0


def test_self_intersections_agree_with_libigl_on_random_triangles():
    """Breaks if a crossing is missed or invented; 1770 pairs of random triangles."""
    generator = np.random.default_rng(0)
    vertices = generator.normal(size=(180, 3))
    faces = np.arange(180).reshape(60, 3)
    crossing = set()
    for i in range(60):
        for j in range(i):
            corners = [vertices[k][None] for k in (*faces[i], *faces[j])]
            if igl.tri_tri_overlap_test_3d(*corners):
                crossing |= {i, j}
    assert 0 < len(crossing) and set(self_intersections(vertices, faces).tolist()) == crossing


def test_a_folded_sheet_does_not_intersect_itself_until_it_passes_through():
    """Breaks if neighbours that share a vertex are counted, or a real crossing is not."""
    x, y = np.meshgrid(np.linspace(0, 1, 25), np.linspace(0, 1, 5), indexing="ij")
    sheet = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    index = np.arange(125).reshape(25, 5)
    a, b, c, d = (q.ravel() for q in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    assert len(self_intersections(sheet, faces)) == 0
    rolled = np.stack([np.cos(7.5 * sheet[:, 0]), sheet[:, 1], np.sin(7.5 * sheet[:, 0])], axis=1)
    assert len(self_intersections(rolled * (1 + 0.1 * sheet[:, :1]), faces)) == 0
    rolled[:, 0] += np.where(sheet[:, 0] > 0.9, -0.3, 0.0)
    assert len(self_intersections(rolled, faces)) > 0
