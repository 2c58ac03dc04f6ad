"""A waist seam is told by the cloth's Gaussian curvature along a line, which neither folds nor noise feign."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.templates import find_cut
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.core.recover.grade.trunk_curvature import TrunkCurvature
from garmentq.core.recover.grade.waist_seam import find_waist_line, has_curved_waist, sew_waist
from garmentq.core.scan.contours.target import Target

BODY = builtin_body("builtin:female,height=1.70")


def tube(
    slope: float,
    rng: np.random.Generator,
    *,
    folds: float = 0.0,
    noise: float = 0.0,
    up: float = 0.0,
    tilt: float = 0.0,
) -> TrunkCurvature:
    """Return cloth around the trunk, 0.6 m long, that widens by `slope` above and below a line at the waist.

    `folds` [m] runs eight times around at every height alike, `noise` [m] moves every vertex; `up` [m] lifts the line,
    which rises forwards by `tilt`.
    """
    around, along = 160, 61
    measures = measure_wearer(BODY)
    radius, line = measures.waist / (2.0 * np.pi) + 0.02, measures.waist_height + up
    angle = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)[None, :]
    below = np.linspace(0.3, -0.3, along)[:, None]
    wide = radius + slope * np.abs(below) + folds * np.cos(8.0 * angle)
    height = line + below + tilt * wide * np.sin(angle)
    vertices = np.stack([wide * np.cos(angle), height, wide * np.sin(angle)], axis=2).reshape(-1, 3)
    grid = np.arange(around * along).reshape(along, around)
    a, b, c, d = grid[:-1], np.roll(grid, -1, 1)[:-1], np.roll(grid, -1, 1)[1:], grid[1:]
    faces = np.concatenate([np.stack([a, c, b], 2).reshape(-1, 3), np.stack([a, d, c], 2).reshape(-1, 3)])
    vertices = vertices + noise * rng.normal(size=vertices.shape)
    return TrunkCurvature.of(Target(vertices, faces, np.zeros_like(vertices), (), (), "dress"), BODY)


@pytest.mark.parametrize(
    ("slope", "folds", "noise", "up", "found"),
    [
        (0.4, 0.0, 0.0, 0.0, True),
        (0.4, 0.0, 0.001, 0.03, True),
        (0.0, 0.02, 0.0, 0.0, False),
        (0.0, 0.0, 0.001, 0.0, False),
        (-0.1, 0.0, 0.0, 0.0, False),
        (0.4, 0.0, 0.0, 0.3, False),
    ],
)
def test_a_line_of_curvature_at_the_waist(slope, folds, noise, up, found):
    """Broken where two cones sewn at the waist are no seam, or a tube with folds, noise, a bulge or a bust is one."""
    cloth = tube(slope, np.random.default_rng(0), folds=folds, noise=noise, up=up)
    assert has_curved_waist(cloth) is found
    assert (find_waist_line(cloth) is not None) is found


@pytest.mark.parametrize(
    ("noise", "up", "tilt"), [(0.0, 0.0, 0.0), (0.0, 0.03, 0.15), (0.0005, -0.02, -0.1), (0.001, 0.02, 0.0)]
)
def test_the_line_lies_where_the_cloth_is_curved(noise, up, tilt):
    """Broken where the plane is not as high or not as steep as the line, or the sides count as seen."""
    cloth = tube(0.4, np.random.default_rng(1), noise=noise, up=up, tilt=tilt)
    line = find_waist_line(cloth)
    assert line is not None
    radius = cloth.measures.waist / (2.0 * np.pi) + 0.02
    middle, left = BODY.joint("pelvis"), np.array([1.0, 0.0, 0.0])
    for forwards in (-radius, radius):
        height = cloth.measures.waist_height + up + tilt * forwards
        there = np.array([[0.0, height, forwards]])
        assert abs(there[0] @ line.normal - line.offset) < 0.006
    assert line.is_seen_at(middle[None])[0] and not line.is_seen_at((middle + 0.17 * left)[None])[0]


def test_what_is_sewn_at_the_waist():
    """Broken where a sheath gets no darts, a circle skirt gets some, or a user's own waist is overruled."""
    sheath, circle = find_cut("dress+skirt=a-line"), find_cut("dress+skirt=half-circle,waist=seam")
    assert (str(sew_waist(sheath, ()).waist), str(sew_waist(sheath, ()).shaping)) == ("seam", "darts")
    assert str(sew_waist(circle, ()).shaping) == "none"
    assert sew_waist(sheath, ("waist",)) == sheath
    assert sew_waist(find_cut("trousers"), ()) == find_cut("trousers")
