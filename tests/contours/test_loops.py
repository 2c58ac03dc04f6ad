"""Boundary loops, smoothed lengths and the disk that spans a loop."""

import numpy as np
import pytest
from garmentq.core.scan.contours.loop import find_loops, smoothed_length, span_disk
from hypothesis import given, settings
from hypothesis import strategies as st


def grid(size):
    """Return a flat square grid of counter-clockwise triangles, [size + 1] squared vertices."""
    i, j = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    a = (i * (size + 1) + j).ravel()
    b, c, d = a + 1, a + size + 1, a + size + 2
    y, x = np.meshgrid(np.arange(size + 1.0), np.arange(size + 1.0), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    return vertices, np.stack([a, b, d, a, d, c], axis=-1).reshape(-1, 3)


def signed_area(points):
    """Return the area of a loop in the plane, positive when counter-clockwise."""
    x, y = points[:, 0], points[:, 1]
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def boundary(faces):
    """List the directed edges without an opposite."""
    edges = {(int(f[i]), int(f[(i + 1) % 3])) for f in faces for i in range(3)}
    return {(a, b) for a, b in edges if (b, a) not in edges}


def without_squares(faces, size, squares):
    """Take squares (row, column) out of a grid."""
    gone = {2 * (i * size + j) + k for i, j in squares for k in (0, 1)}
    return faces[[f not in gone for f in range(len(faces))]]


def test_outer_rim_has_the_surface_on_its_left():
    """A loop that runs the wrong way would turn every disk normal round."""
    vertices, faces = grid(5)
    (loop,) = find_loops(faces)
    assert len(loop) == 20 and signed_area(vertices[loop]) == 25.0
    (turned,) = find_loops(faces[:, ::-1])
    assert signed_area(vertices[turned]) == -25.0


def test_closed_surface_has_no_loop():
    """A sphere must have no contour."""
    faces = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
    assert find_loops(faces) == () and find_loops(np.zeros((0, 3), int)) == ()


def test_touching_holes_are_two_loops():
    """Two holes that share a corner must be told apart, or a hem swallows the hole beside it."""
    vertices, faces = grid(6)
    loops = find_loops(without_squares(faces, 6, [(2, 2), (3, 3)]))
    assert [len(loop) for loop in loops] == [24, 4, 4]
    assert [signed_area(vertices[loop]) for loop in loops] == [36.0, -1.0, -1.0]


def test_hole_at_the_rim_is_split_off():
    """A hole that touches the rim in one vertex must not become part of it."""
    vertices, faces = grid(6)
    # The triangles at the corner vertex (0, 2) that keep the hole away from the rim are left, two of them gone.
    loops = find_loops(without_squares(faces, 6, [(0, 1), (1, 2)]))
    areas = sorted(signed_area(vertices[loop]) for loop in loops)
    assert areas == [-1.0, 35.0]


def test_doubled_pinch_is_split_by_place():
    """Where a repair has doubled a pinched vertex, positions must still tell the two holes apart."""
    vertices, faces = grid(6)
    cut = without_squares(faces, 6, [(2, 2), (3, 3)])
    pinch = 3 * 7 + 3
    upper = (cut == pinch).any(axis=1) & (vertices[cut].mean(axis=1)[:, 0] < 3.0)
    doubled = np.where((cut == pinch) & upper[:, None], len(vertices), cut)
    more = np.vstack([vertices, vertices[pinch]])
    assert [len(loop) for loop in find_loops(doubled)] == [24, 8]
    assert [len(loop) for loop in find_loops(doubled, more)] == [24, 4, 4]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), max_size=20), st.integers(0, 1000))
def test_loops_hold_every_boundary_edge_once(squares, seed):
    """Whatever is cut out, the loops must be simple and cover the boundary exactly."""
    vertices, faces = grid(6)
    kept = without_squares(faces, 6, squares)
    kept = np.random.default_rng(seed).permutation(kept)[: max(1, len(kept) - seed % 7)]
    loops = find_loops(kept)
    walked = [(int(a), int(b)) for loop in loops for a, b in zip(loop, np.roll(loop, -1), strict=True)]
    assert sorted(walked) == sorted(boundary(kept))
    assert all(len(set(loop.tolist())) == len(loop) for loop in loops)
    # Green's theorem: the loops together enclose exactly the area of the faces.
    assert np.isclose(sum(signed_area(vertices[loop]) for loop in loops), 0.5 * len(kept))


def circle(radius, count, tilt=0.0):
    """Return points on a circle, tilted about x."""
    angle = 2 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(angle), np.sin(angle) * np.sin(tilt), np.sin(angle) * np.cos(tilt)], axis=1)


@pytest.mark.parametrize("radius", [0.05, 0.1, 0.3])
def test_circle_keeps_its_length(radius):
    """Smoothing must not shorten a design's curve by more than the stated (width / R)^2 / 48."""
    length = smoothed_length(circle(radius, 200, 0.4) + [1.0, 2.0, 3.0])
    assert abs(length / (2 * np.pi * radius) - 1) < 1.3 * (0.03 / radius) ** 2 / 48 + 5e-4


def test_teeth_of_a_cut_do_not_count():
    """A contour cut along triangles is 1.5 times too long and must still measure what it goes around."""
    rng = np.random.default_rng(5)
    points = circle(0.16, 200) + rng.uniform(-0.006, 0.006, size=(200, 3))
    raw = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1).sum()
    assert raw > 1.4 * 2 * np.pi * 0.16
    assert abs(smoothed_length(points) / (2 * np.pi * 0.16) - 1) < 0.05


def test_length_does_not_depend_on_start_or_place():
    """The same curve walked from another point, turned or moved must measure the same."""
    points = circle(0.16, 150) * [1.0, 1.0, 0.6] + 0.01 * np.sin(np.arange(150) / 7.0)[:, None]
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    length = smoothed_length(points)
    assert np.isclose(smoothed_length(points @ turn.T + 5.0), length, rtol=1e-9)
    assert np.isclose(smoothed_length(np.roll(points, 40, axis=0)), length, rtol=2e-3)


def test_disk_of_a_planar_loop_is_flat_and_oriented():
    """The spanning disk must be the loop's own plane region, its normal along the loop's area vector."""
    points = circle(0.2, 90)
    vertices, faces = span_disk(points)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = 0.5 * np.cross(b - a, c - a)
    expected = 0.5 * np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    assert np.abs(vertices[:, 1]).max() < 1e-12
    assert np.allclose(normals.sum(axis=0), expected, rtol=5e-3)
    assert (normals @ expected > 0).all()
