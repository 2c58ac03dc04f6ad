"""The border of a surface at which it ends for the eye alone."""

from __future__ import annotations

import numpy as np
from garmentq.core.geometry.rim import Rim
from garmentq.core.geometry.surface import TriangleSurface


def square(count: int = 11) -> TriangleSurface:
    """Lay a square metre in z = 0."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, count), np.linspace(0.0, 1.0, count))
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + count + 1], axis=1),
            np.stack([corner, corner + count + 1, corner + count], axis=1),
        ]
    )
    return TriangleSurface(np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1), faces)


def test_points_lie_ahead_of_the_marked_side_alone() -> None:
    """Fails if another side, the surface itself or what lies above it counted as beyond the rim."""
    surface = square()
    rim = Rim.between(surface.faces, surface.vertices[:, 1] == 1.0)
    points = np.array([[0.52, 1.2, 0.0], [0.3, 1.2, 0.0], [0.52, -0.2, 0.0], [0.52, 0.5, 0.1], [0.52, 0.95, 0.0]])
    np.testing.assert_array_equal(rim.is_ahead(surface, surface.closest(points)), [True, True, False, False, False])


def test_a_curled_rim_hides_what_lies_ahead_of_it() -> None:
    """Fails if a place just inside the rim ended the hidden part; what is near such a place is seen, and measured."""
    surface = square()
    rim = Rim.between(surface.faces, surface.vertices[:, 1] == 1.0)
    near_rim = np.array(
        [[0.5, 0.993, 0.1], [0.5, 0.993, 0.005], [0.5, 0.9, 0.1], [0.5, 0.978, 0.06], [0.5, 0.978, 0.03]]
    )
    ahead = rim.is_ahead(surface, surface.closest(near_rim))
    np.testing.assert_array_equal(ahead, [True, False, False, True, False])
