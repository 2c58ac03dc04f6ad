"""Cloth before it is scanned, on shapes whose cuts and layers are known."""

import numpy as np
import pytest
import trimesh
from garmentq.training.cloth import border_vertices, clip, hem_height, tuck_under, wave_field


def ball(radius=1.0):
    """Return a ball's surface."""
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces, np.int64)


def sheet(height, size=1.0, count=21):
    """Return a level sheet at a height, its faces upward."""
    x, z = np.meshgrid(np.linspace(-size, size, count), np.linspace(-size, size, count), indexing="ij")
    at = np.arange(count * count).reshape(count, count)
    a, b, c, d = at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([c, b, d], axis=1)])
    return np.column_stack([x.ravel(), np.full(x.size, height), z.ravel()]), faces


@pytest.mark.parametrize("height", [-0.3, 0.0, 0.55])
def test_a_cut_ball_is_a_cap(height):
    """Broken where a cut drops or doubles triangles (a cap has 2 pi r h), or its border leaves the plane."""
    vertices, faces = ball()
    cap = clip((vertices, faces), vertices[:, 1] - height)
    area = trimesh.Trimesh(*cap, process=False).area
    assert area == pytest.approx(2 * np.pi * (1 - height), rel=5e-3)
    assert cap[0][border_vertices(cap), 1] == pytest.approx(height, abs=1e-6)


def test_a_cut_through_vertices_leaves_no_slivers():
    """Broken where a level that passes exactly through vertices makes degenerate triangles or splits the border."""
    vertices, faces = sheet(0.0)
    half = clip((vertices, faces), vertices[:, 0])
    assert trimesh.Trimesh(*half, process=False).area == pytest.approx(2.0, abs=1e-6)
    assert clip((vertices, faces), np.full(len(vertices), -1.0))[1].shape == (0, 3)


def test_what_is_covered_lies_below():
    """Broken where an inner layer shows through the one over it, or is moved where nothing covers it."""
    inner, outer = sheet(0.01, size=1.0), sheet(0.0, size=0.5)
    tucked, _ = tuck_under(inner, outer)
    under = (np.abs(inner[0][:, [0, 2]]) < 0.49).all(axis=1)
    beyond = (np.abs(inner[0][:, [0, 2]]) > 0.55).any(axis=1)
    assert (tucked[under, 1] < 0.0).all()
    assert (tucked[beyond] == inner[0][beyond]).all()


def test_a_hem_is_thick_at_the_border_alone():
    """Broken where a turned-up hem has no edge: its height within its width, none beyond."""
    mesh = sheet(0.0)
    height = hem_height(mesh, 0.25, 0.002)
    inside = 1.0 - np.abs(mesh[0][:, [0, 2]]).max(axis=1)
    assert height[inside < 0.2] == pytest.approx(0.002)
    assert (height[inside > 0.26] == 0).all()


def test_waves_have_unit_size():
    """Broken where wrinkles and noise are not of the size that is asked for."""
    rng = np.random.default_rng(0)
    values = np.concatenate([wave_field(rng.random((4000, 3)) * 3, (0.05, 0.2), rng) for _ in range(8)])
    assert values.std() == pytest.approx(1.0, abs=0.1)
    assert abs(values.mean()) < 0.1
