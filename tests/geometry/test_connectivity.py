"""Half-edges: twins, borders, hinges and pieces of meshes whose answers are known."""

from __future__ import annotations

import numpy as np
from garmentq.core.geometry.connectivity import HalfEdges, adjacency_matrix, find_components
from hypothesis import given
from hypothesis import strategies as st

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def strip(count: int) -> np.ndarray:
    """Return a grid of count x count squares, two triangles each."""
    i, j = (part.ravel() for part in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    a = i * (count + 1) + j
    b, c, d = a + 1, a + count + 1, a + count + 2
    return np.concatenate([np.stack([a, c, d], 1), np.stack([a, d, b], 1)])


def test_the_numbering():
    """A half-edge that starts at another corner than its number says breaks this."""
    edges = HalfEdges.of(TETRAHEDRON)
    for face in range(4):
        for k in range(3):
            h = 3 * face + k
            assert edges.tail[h] == TETRAHEDRON[face, k]
            assert edges.head[h] == TETRAHEDRON[face, (k + 1) % 3]
            assert edges.opposite[h] == TETRAHEDRON[face, (k + 2) % 3]
            assert edges.following[h] == 3 * face + (k + 1) % 3


def test_a_closed_surface_has_twins_everywhere():
    """A missing twin, or one that runs the same way, breaks this."""
    edges = HalfEdges.of(TETRAHEDRON)
    assert len(edges.edges) == 6 and not len(edges.border) and not edges.border_vertices.any()
    assert np.array_equal(edges.twin[edges.twin], np.arange(12))
    assert np.array_equal(edges.tail[edges.twin], edges.head)
    assert np.array_equal(edges.edge[edges.twin], edges.edge)
    assert len(edges.hinges) == 6
    assert edges.face_pieces[0] == edges.vertex_pieces[0] == 1


def test_the_border_of_a_square():
    """A border edge lost, doubled or turned breaks this."""
    edges = HalfEdges.of(strip(5))
    assert len(edges.border) == 20 and edges.border_vertices.sum() == 20
    assert (edges.twin[edges.border] == -1).all() and (edges.twin < 0).sum() == 20
    # with the surface on the left each border vertex is left once and reached once
    assert np.array_equal(np.sort(edges.tail[edges.border]), np.sort(edges.head[edges.border]))
    assert edges.vertex_count - len(edges.edges) + len(edges.faces) == 1


def test_three_sheets_at_one_edge():
    """An edge of three faces that has a twin, is a border, or bends in one pair only breaks this."""
    edges = HalfEdges.of(np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]]))
    crowded = int(edges.edge[0])
    assert edges.face_counts[crowded] == 3
    assert edges.twin[0] == edges.twin[3] == edges.twin[6] == -1
    assert np.array_equal(edges.hinges, [[0, 3], [3, 6]])
    assert np.array_equal(edges.hinge_vertices, [[0, 1, 2, 3], [1, 0, 3, 4]])
    assert len(edges.pairs) == 0 and edges.face_pieces[0] == 3


def test_faces_that_disagree_are_a_pair_without_a_twin():
    """A one-sided edge that is taken for sound, or for a border, breaks this."""
    edges = HalfEdges.of(np.array([[0, 1, 2], [0, 1, 3]]))
    assert np.array_equal(edges.pairs, [[0, 3]]) and not edges.opposed.any()
    assert (edges.twin == -1).all() and 0 not in edges.border


def test_two_faces_over_the_same_vertices_have_no_hinge():
    """A hinge between a face and its double, whose angle is not defined, breaks this."""
    edges = HalfEdges.of(np.array([[0, 1, 2], [0, 2, 1]]))
    assert len(edges.pairs) == 3 and len(edges.hinges) == 0


def test_no_faces():
    """A mesh without faces must have no edges instead of an error."""
    edges = HalfEdges.of(np.zeros((0, 3), int), 4)
    assert len(edges.edges) == len(edges.border) == len(edges.hinges) == len(edges.twin) == 0
    assert edges.vertex_pieces[0] == 4 and edges.adjacency.nnz == 0


def test_pieces_and_neighbours():
    """Two sheets that are taken for one, or a neighbour that is counted twice, break this."""
    one = strip(3)
    edges = HalfEdges.of(np.concatenate([one, one + 16]))
    assert edges.face_pieces[0] == edges.vertex_pieces[0] == 2
    assert np.array_equal(edges.face_pieces[1], np.repeat([0, 1], len(one)))
    assert edges.adjacency.max() == 1.0 and (edges.adjacency != edges.adjacency.T).nnz == 0
    assert edges.adjacency.nnz == 2 * len(edges.edges)
    assert find_components(3, np.array([0]), np.array([2]))[1].tolist() == [0, 1, 0]
    assert adjacency_matrix(np.array([[0, 1]]), 2).toarray().tolist() == [[0, 1], [1, 0]]


@given(st.lists(st.tuples(*[st.integers(0, 7)] * 3).filter(lambda face: len(set(face)) == 3), min_size=1, max_size=30))
def test_twins_are_mutual_and_opposite(faces):
    """Any soup of triangles: a twin that is not mutual, not opposite or at a border breaks this."""
    edges = HalfEdges.of(np.array(faces))
    found = np.flatnonzero(edges.twin >= 0)
    assert np.array_equal(edges.twin[edges.twin[found]], found)
    assert np.array_equal(edges.tail[edges.twin[found]], edges.head[found])
    assert not np.isin(edges.border, found).any()
    assert np.array_equal(edges.face_counts.sum(), edges.faces.size)
    assert np.array_equal(np.sort(edges.edges, axis=1), edges.edges)
    assert (edges.edge[edges.hinges[:, 0]] == edges.edge[edges.hinges[:, 1]]).all()
