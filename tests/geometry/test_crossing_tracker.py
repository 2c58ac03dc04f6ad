"""The pairs of a mesh that moves, tested where it moved, against all pairs tested anew."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.geometry.intersections import MAX_RETESTED_SHARE, CrossingTracker, intersecting_pairs


def crumpled_sheet(rng: np.random.Generator, side: int = 14) -> tuple[np.ndarray, np.ndarray]:
    """Return a square sheet, crumpled so that it crosses itself."""
    i, j = (part.ravel() for part in np.meshgrid(np.arange(side - 1), np.arange(side - 1), indexing="ij"))
    a = i * side + j
    faces = np.concatenate([np.stack([a, a + side, a + side + 1], 1), np.stack([a, a + side + 1, a + 1], 1)])
    x, y = np.divmod(np.arange(side * side), side)
    flat = np.stack([x, y, 0.0 * x], axis=1).astype(float)
    return flat + rng.normal(0.0, 0.5, flat.shape), faces


def ordered(pairs: np.ndarray) -> list[tuple[int, int]]:
    """Return pairs as a sorted list."""
    return sorted(map(tuple, pairs.tolist()))


@pytest.mark.parametrize("share", [0.02, 0.2, 0.9])
def test_moved_vertices_alone_are_tested(share: float) -> None:
    """Breaks if a pair of two moved faces counts twice or not at all, or a pair that came apart is kept."""
    rng = np.random.default_rng(3)
    vertices, faces = crumpled_sheet(rng)
    tracker, seen = CrossingTracker(faces), set()
    for _ in range(12):
        found = ordered(tracker.find_pairs(vertices))
        assert found == ordered(intersecting_pairs(vertices, faces))
        assert tracker.find_faces(vertices).tolist() == sorted({face for pair in found for face in pair})
        seen.add(len(found))
        moved = rng.random(len(vertices)) < share
        vertices = vertices + moved[:, None] * rng.normal(0.0, 0.3, vertices.shape)
    assert len(seen) > 3  # the sheet's crossings did change


def test_pairs_of_chosen_faces() -> None:
    """Breaks if a pair without a chosen face is listed, or one with a chosen face is missed."""
    rng = np.random.default_rng(5)
    vertices, faces = crumpled_sheet(rng)
    changed = rng.random(len(faces)) < 0.5 * MAX_RETESTED_SHARE
    every = intersecting_pairs(vertices, faces)
    assert ordered(intersecting_pairs(vertices, faces, changed)) == ordered(every[changed[every].any(axis=1)])
    assert not len(intersecting_pairs(vertices, faces, np.zeros(len(faces), dtype=bool)))
