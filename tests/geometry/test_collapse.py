"""Fewer triangles for the same surface: its borders and its topology stay."""

import numpy as np
import pytest
from garmentq.core.geometry.collapse import collapse_edges
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.geometry.surface import TriangleSurface

AROUND, ROWS = 160, 80
RADIUS, HEIGHT = 0.2, 0.6


def make_tube(noise=0.0, radius=RADIUS):
    """Return an open tube of even triangles, its vertices moved at random by `noise` [m] but for the two rims."""
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    y = np.linspace(0.0, HEIGHT, ROWS)
    points = np.stack(np.broadcast_arrays(radius * np.sin(angle), y[:, None], radius * np.cos(angle)), axis=-1)
    points[1:-1] += noise * np.random.default_rng(0).standard_normal(points[1:-1].shape)
    i, j = np.meshgrid(np.arange(ROWS - 1), np.arange(AROUND), indexing="ij")
    a, b = i * AROUND + j, i * AROUND + (j + 1) % AROUND
    faces = np.stack([a, b, b + AROUND, a, b + AROUND, a + AROUND], axis=-1).reshape(-1, 3)
    return points.reshape(-1, 3), faces


@pytest.mark.parametrize("noise", [0.0, 0.001, 0.01])
def test_borders_and_topology_stay(noise):
    """Broken where a collapse tears a surface or pinches it, closes or moves an opening, also where noise is an edge
    long and every face points elsewhere."""
    vertices, faces = make_tube(noise)
    small = collapse_edges(vertices, faces, 3000)
    edges = HalfEdges.of(small.faces)
    assert len(small.faces) <= 3000 and edges.opposed.all() and edges.face_counts.max() == 2
    assert edges.face_pieces[0] == 1 and len(small.vertices) - len(edges.edges) + len(small.faces) == 0
    rims = np.r_[np.arange(AROUND), len(vertices) - AROUND + np.arange(AROUND)]
    assert np.array_equal(small.origin[edges.border_vertices], rims)
    assert np.array_equal(small.vertices[edges.border_vertices], vertices[rims])


def test_the_surface_stays_where_it_is():
    """Broken where thinning shrinks a surface: vertices lie within the sagitta of a side, and half of it more."""
    vertices, faces = make_tube()
    small = collapse_edges(vertices, faces, 3000)
    sides = HalfEdges.of(small.faces).edges
    longest = np.linalg.norm(np.diff(small.vertices[sides], axis=1), axis=2).max()
    distance = TriangleSurface(small.vertices, small.faces).distance(vertices)
    assert longest < 0.05 and distance.max() < longest**2 / (8 * RADIUS) * 1.5


def test_noise_is_averaged():
    """Broken where a vertex that stands for ten keeps its own noise."""
    vertices, faces = make_tube(0.001)
    small = collapse_edges(vertices, faces, 2500)
    inner = np.setdiff1d(np.arange(len(small.vertices)), HalfEdges.of(small.faces).border_vertices)
    off = np.hypot(*small.vertices[inner][:, [0, 2]].T) - RADIUS
    assert np.std(off) < 0.0006


def test_what_stands_for_what():
    """Broken where labels carried to the thinned vertices and back would land elsewhere, or two layers are joined."""
    vertices, faces = make_tube()
    lining, _ = make_tube(radius=RADIUS - 0.002)
    both = np.concatenate([vertices, lining]), np.concatenate([faces, faces + len(vertices)])
    small = collapse_edges(*both, 6000)
    assert np.array_equal(small.place[small.origin], np.arange(len(small.vertices)))
    outer = np.arange(len(both[0])) < len(vertices)
    assert np.array_equal(outer[small.origin][small.place], outer)
    assert np.linalg.norm(small.vertices[small.place] - both[0], axis=1).max() < 0.05


def test_a_small_mesh_comes_back_as_it_is():
    """Broken where a scan that needs no thinning is changed in its last digit."""
    vertices, faces = make_tube()
    small = collapse_edges(vertices, faces, len(faces))
    assert small.vertices is vertices and small.faces is faces


def test_the_same_twice():
    """Broken where chance, or the order of a set, decides."""
    first, second = (collapse_edges(*make_tube(0.001), 4000) for _ in range(2))
    assert np.array_equal(first.vertices, second.vertices) and np.array_equal(first.faces, second.faces)
