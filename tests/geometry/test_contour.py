"""The lines along which a mesh passes through itself."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.geometry.contour import measure_contour
from garmentq.core.geometry.intersections import intersecting_pairs


def cross(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a large triangle and a strip of three that stands across it, a little shaken."""
    points = np.array([[-2, 0, -2], [3, 0, -2], [0, 0, 3], [-1, -1, 0], [-1, 1, 0], [0, -1, 0], [0, 1, 0], [1, 0.8, 0]])
    faces = np.array([[0, 1, 2], [3, 5, 4], [5, 6, 4], [5, 7, 6]])
    return points + np.random.default_rng(seed).normal(0, 0.05, points.shape), faces


def test_length_of_a_square_cut_through_the_middle():
    """A segment that is left out or counted twice breaks this."""
    points = np.array([[-5.0, 0, -5], [5, 0, -5], [0, 0, 5], [-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    faces = np.array([[0, 1, 2], [3, 4, 5], [3, 5, 6]])
    pairs = intersecting_pairs(points, faces)
    assert len(pairs) == 2
    assert measure_contour(points, faces, pairs)[0] == pytest.approx(2.0, abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_gradient_against_differences(seed):
    """A wrong share of an end of an edge or of a face's corner breaks this; so does one that moves the whole."""
    points, faces = cross(seed)
    pairs = intersecting_pairs(points, faces)
    assert len(pairs) == 3
    _, gradient = measure_contour(points, faces, pairs)
    for v in range(len(points)):
        for d in range(3):
            step = np.zeros_like(points)
            step[v, d] = 1e-6
            ends = [measure_contour(points + s * step, faces, pairs)[0] for s in (1, -1)]
            assert gradient[v, d] == pytest.approx((ends[0] - ends[1]) / 2e-6, abs=1e-6)
    assert np.abs(gradient.sum(0)).max() < 1e-12
