"""Noise of a target: found, smoothed where it is large, and left alone where it is small."""

import igl
import numpy as np
import pytest
from garmentq.core.scan.contours.noise import smooth_noise

AROUND, UP, EDGE = 72, 43, 0.014


def tube(fold: float = 0.005) -> tuple[np.ndarray, np.ndarray]:
    """Return an open tube with edges of about 14 mm and folds of so many metres, 9 cm apart."""
    angle, height = np.meshgrid(2 * np.pi * np.arange(AROUND) / AROUND, EDGE * np.arange(UP))
    radius = EDGE * AROUND / (2 * np.pi) + fold * np.cos(11 * angle)
    vertices = np.stack([radius * np.sin(angle), height, radius * np.cos(angle)], axis=-1).reshape(-1, 3)
    row, step = np.meshgrid(np.arange(UP - 1), np.arange(AROUND), indexing="ij")
    a, b = row * AROUND + step, row * AROUND + (step + 1) % AROUND
    return vertices, np.stack([a, b, b + AROUND, a, b + AROUND, a + AROUND], axis=-1).reshape(-1, 3)


def rms(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> float:
    """Return the RMS distance of points to a surface [m]."""
    return float(np.sqrt(igl.point_mesh_squared_distance(points, vertices, faces)[0].mean()))


@pytest.mark.parametrize("deviation", [0.008, 0.010])
def test_large_noise_is_measured_and_halved(deviation: float) -> None:
    """Broken where the estimate is off by more than a sixth, or the smoothing takes the folds with the noise."""
    vertices, faces = tube()
    noisy = vertices + np.random.default_rng(1).normal(0, deviation, vertices.shape)
    smooth, noise = smooth_noise(noisy, faces)
    assert noise == pytest.approx(deviation, rel=0.17)
    assert rms(smooth, vertices, faces) < 0.5 * rms(noisy, vertices, faces)


@pytest.mark.parametrize(("fold", "left"), [(0.0, 0.2), (0.02, 0.5)])
def test_a_surface_is_smoothed_by_as_much_as_it_allows(fold: float, left: float) -> None:
    """Broken where a plain surface is smoothed like a folded one: one weight for both leaves twice the error on one."""
    vertices, faces = tube(fold)
    noisy = vertices + np.random.default_rng(1).normal(0, 0.008, vertices.shape)
    smooth, _ = smooth_noise(noisy, faces)
    assert rms(smooth, vertices, faces) < left * rms(noisy, vertices, faces)


def test_openings_do_not_shrink() -> None:
    """Broken where a border is drawn into the surface: then hems and cuffs would come out short."""
    vertices, faces = tube()
    noisy = vertices + np.random.default_rng(1).normal(0, 0.008, vertices.shape)
    smooth, _ = smooth_noise(noisy, faces)
    for rim in (slice(0, AROUND), slice(-AROUND, None)):
        assert abs(smooth[rim, 1].mean() - vertices[rim, 1].mean()) < 0.003
        assert np.linalg.norm(smooth[rim][:, [0, 2]], axis=1).mean() == pytest.approx(
            np.linalg.norm(vertices[rim][:, [0, 2]], axis=1).mean(), rel=0.03
        )


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_clean_surfaces_and_small_noise_are_left_alone(scale: float) -> None:
    """Broken where folds, or the long edges of a coarse mesh, pass for noise."""
    vertices, faces = tube()
    assert smooth_noise(scale * vertices, faces)[1] == 0.0
    noisy = vertices + np.random.default_rng(1).normal(0, 0.002, vertices.shape)
    again, noise = smooth_noise(noisy, faces)
    assert noise == 0.0 and np.array_equal(again, noisy)
