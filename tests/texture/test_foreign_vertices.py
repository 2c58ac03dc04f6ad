"""What a garment cut out of a person shows beyond its border is told from cloth."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.deliver.texture.foreign_vertices import CUT_MARGIN_WIDTH, find_foreign_vertices
from garmentq.core.scan.coloured import ColouredScan

COUNT, SPACING = 61, 5e-3


def sheet(colour) -> ColouredScan:
    """Return a sheet of 30 cm with vertices every 5 mm, their colours by place, with noise."""
    x, y = np.meshgrid(*[SPACING * np.arange(COUNT)] * 2, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.zeros(COUNT**2)], axis=1)
    index = np.arange(COUNT**2).reshape(COUNT, COUNT)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))])
    noise = np.random.default_rng(0).normal(0.0, 4.0, points.shape)
    colours = np.clip(np.round(colour(points) + noise), 0, 255).astype(np.uint8)
    return ColouredScan(points, faces, colours, np.zeros((len(faces), 3, 2)), np.full(len(faces), -1), is_cut=True)


def depth(points: np.ndarray) -> np.ndarray:
    """Return how far points are from the sheet's border [m]."""
    return np.minimum(points[:, :2], (COUNT - 1) * SPACING - points[:, :2]).min(axis=1)


SKIN, BLUE, WHITE = np.array([205.0, 170.0, 145.0]), np.array([70.0, 95.0, 170.0]), np.full(3, 230.0)


@pytest.mark.parametrize("skin", [0.0, 0.008, 0.013])
def test_skin_beside_the_cut_is_found_and_cloth_is_kept(skin):
    """Broken where skin that was cut with the cloth is kept, or over 1 % of the cloth is not."""
    scan = sheet(lambda points: np.where((depth(points) < skin)[:, None], SKIN, BLUE))
    found, true = find_foreign_vertices(scan), depth(scan.vertices) < skin
    assert found[true].all()
    assert found[~true].mean() < 0.01


def test_stripes_and_a_wide_trim_are_cloth():
    """Broken where what the cloth itself shows further in is taken for skin."""
    stripes = sheet(lambda points: np.where((np.round(points[:, :1] / SPACING) % 4 < 2), BLUE, WHITE))
    trimmed = sheet(lambda points: np.where((depth(points) < 2.2 * CUT_MARGIN_WIDTH)[:, None], WHITE, BLUE))
    assert find_foreign_vertices(stripes).mean() < 0.01
    assert find_foreign_vertices(trimmed).mean() < 0.01
