"""What the repair mends, and that it leaves a clean mesh alone."""

import numpy as np
import pytest
import trimesh
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.scan.refusal import PiecesTooMany
from garmentq.core.scan.repair import (
    MAX_MESH_PIECE_COUNT,
    boundary_pieces,
    enclosed_volume,
    is_facing_body,
    repair_surface,
)
from hypothesis import given, settings
from hypothesis import strategies as st


def tube(around=16, rows=9, radius=0.2, height=0.6):
    """Return an open, outward tube around y."""
    angle = 2 * np.pi * np.arange(around) / around
    ring = np.stack([radius * np.sin(angle), np.zeros(around), radius * np.cos(angle)], axis=1)
    vertices = np.concatenate([ring + [0, y, 0] for y in np.linspace(0, height, rows)])
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(around), indexing="ij")
    a, b = i * around + j, i * around + (j + 1) % around
    c, d = a + around, b + around
    return vertices, np.stack([a, b, d, a, d, c], axis=-1).reshape(-1, 3)


def is_clean(vertices, faces):
    """Return whether every edge has one or two faces that run against each other, and every vertex one fan."""
    edges = HalfEdges.of(faces)
    keys = edges.tail * len(vertices) + edges.head
    return edges.face_counts.max() <= 2 and len(np.unique(keys)) == len(keys)


def test_clean_mesh_comes_back_unchanged():
    """A repair that touches a clean mesh would move every later index."""
    vertices, faces = tube()
    surface = repair_surface(vertices, faces)
    assert surface.repairs == ()
    assert np.array_equal(surface.vertices, vertices) and np.array_equal(surface.faces, faces)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_broken_tube_is_mended(seed):
    """Soup of duplicated vertices, turned, doubled, degenerate and flying faces must become the tube again."""
    rng = np.random.default_rng(seed)
    vertices, faces = tube()
    soup = vertices[faces].reshape(-1, 3)
    index = np.arange(len(soup)).reshape(-1, 3)
    turned = rng.random(len(index)) < 0.3
    index[turned] = index[turned][:, ::-1]
    doubled = index[rng.integers(0, len(index), 4)]
    degenerate = index[rng.integers(0, len(index), 3)][:, [0, 1, 1]]
    stray = len(soup) + np.array([[0, 1, 2]])
    soup = np.concatenate([soup, rng.normal(size=(3, 3)) * 0.02 + [1.0, 0.0, 0.0]])
    index = np.concatenate([index, doubled, degenerate, stray])
    surface = repair_surface(soup, rng.permutation(index))
    assert len(surface.vertices) == len(vertices) and len(surface.faces) == len(faces)
    assert is_clean(surface.vertices, surface.faces)
    assert enclosed_volume(surface.vertices, surface.edges) > 0
    text = " ".join(surface.repairs)
    for word in ("duplicate", "degenerate", "doubled", "agree", "stray"):
        assert word in text


def test_fin_on_an_edge_is_removed():
    """A flap on an inner edge must go, and the sheet that carried it must stay whole."""
    vertices, faces = tube()
    fin = np.array([[faces[40, 0], faces[40, 1], len(vertices)]])
    surface = repair_surface(np.vstack([vertices, [0.5, 0.3, 0.5]]), np.vstack([faces, fin]))
    assert len(surface.faces) == len(faces) and len(surface.vertices) == len(vertices)
    assert is_clean(surface.vertices, surface.faces)
    assert any("non-manifold face" in sentence for sentence in surface.repairs)


def test_touching_fans_are_split():
    """Two tubes that share one vertex must become two fans, or every walk around that vertex goes wrong."""
    vertices, faces = tube()
    other = vertices + [0.0, 0.6, 0.0]
    lower_rim = np.arange(16) + 16 * 8
    joined = faces + len(vertices)
    joined[joined == len(vertices)] = lower_rim[0]
    moved = other.copy()
    moved[1:16] += [0.0, 0.05, 0.0]
    surface = repair_surface(np.vstack([vertices, moved]), np.vstack([faces, joined]))
    assert "Split 1 non-manifold vertex." in surface.repairs
    assert len(surface.faces) == 2 * len(faces)
    assert len(surface.vertices) == 2 * len(vertices)


def test_sliver_leaves_no_crack():
    """Taking out a triangle of no height must not leave a slit whose rim would look like a hole."""
    vertices, faces = tube()
    a, b, c = faces[50]
    middle = len(vertices)
    points = np.vstack([vertices, 0.5 * (vertices[a] + vertices[b])])
    faces = np.vstack([np.delete(faces, 50, axis=0), [[a, middle, c], [middle, b, c], [a, b, middle]]])
    surface = repair_surface(points, faces)
    assert any("degenerate" in sentence for sentence in surface.repairs)
    assert is_clean(surface.vertices, surface.faces)
    assert len(boundary_pieces(surface.vertices, surface.edges)[3]) == 2


def test_moebius_band_is_cut_open():
    """A one-sided surface cannot be oriented; it must be cut, never handed on with faces that disagree."""
    count = 40
    angle = 2 * np.pi * np.arange(count) / count
    way = np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=1)
    across = np.cos(angle / 2)[:, None] * way + np.sin(angle / 2)[:, None] * [0.0, 1.0, 0.0]
    vertices = np.concatenate([way + 0.3 * across, way - 0.3 * across])
    i = np.arange(count - 1)
    faces = np.concatenate([np.stack([i, i + 1, count + i], 1), np.stack([i + 1, count + i + 1, count + i], 1)])
    last = [[count - 1, count, 2 * count - 1], [count, 0, 2 * count - 1]]
    surface = repair_surface(vertices, np.vstack([faces, last]))
    assert is_clean(surface.vertices, surface.faces)
    assert any("one-sided" in sentence for sentence in surface.repairs)


def test_inward_tube_is_turned():
    """An open garment turned inside out must face outward again, without any body."""
    vertices, faces = tube()
    surface = repair_surface(vertices, faces[:, ::-1])
    assert np.array_equal(surface.faces, faces)
    assert "Turned the surface outward." in surface.repairs


def test_enclosed_volume_of_a_tube_is_its_cylinders():
    """The lids must close the tube exactly, or the vote of an open garment means nothing."""
    vertices, faces = tube(around=64)
    area = 0.5 * 64 * 0.2**2 * np.sin(2 * np.pi / 64)
    assert np.isclose(enclosed_volume(vertices + [3.0, -2.0, 1.0], HalfEdges.of(faces)), area * 0.6)
    ball = trimesh.creation.icosphere(3)
    assert np.isclose(enclosed_volume(ball.vertices, HalfEdges.of(ball.faces)), ball.volume)


def test_vote_of_the_body():
    """A garment that faces its body must be found out whatever its shape."""
    body, body_faces = tube(radius=0.15, height=1.0)
    vertices, faces = tube()
    front = vertices[faces].mean(axis=1)[:, 2] > 0.05
    assert not is_facing_body(vertices, faces[front], body, body_faces)
    assert is_facing_body(vertices, faces[front][:, ::-1], body, body_faces)


def test_thousands_of_pieces_are_refused_and_hundreds_are_quick():
    """Broken where each piece looks at the whole surface: a file of a few MB then takes minutes."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    inward = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])

    def scatter(count):
        places = np.stack([3.0 * np.arange(count), np.zeros(count), np.zeros(count)], axis=1)
        vertices = (corners[None] + places[:, None]).reshape(-1, 3)
        return vertices, (inward[None] + 4 * np.arange(count)[:, None, None]).reshape(-1, 3)

    vertices, faces = scatter(300)
    repaired = repair_surface(vertices, faces)
    edges = repaired.vertices[repaired.faces]
    volumes = np.einsum("ij,ij->i", edges[:, 0], np.cross(edges[:, 1], edges[:, 2])).reshape(-1, 4).sum(axis=1) / 6.0
    np.testing.assert_allclose(volumes, 1.0 / 6.0)
    with pytest.raises(PiecesTooMany):
        repair_surface(*scatter(MAX_MESH_PIECE_COUNT + 1))
