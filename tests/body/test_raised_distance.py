"""The distance to a raised body, against one that is sampled anew."""

from __future__ import annotations

import numpy as np
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.body.raised_distance import RaisedDistance


def test_a_raised_grid_is_that_of_the_raised_mesh() -> None:
    """Breaks if heights are subtracted on the wrong side, at the wrong vertices, or fade beside the skin: a body raised
    by up to 12 mm has the same distance where cloth is."""
    body = builtin_body("builtin:female")
    grid = DistanceGrid.from_mesh(body.vertices, body.faces)
    height = body.vertices[:, 1]
    heights = 0.012 * np.exp(-0.5 * ((height - 1.2) / 0.15) ** 2)
    raised = RaisedDistance.of(body, grid).raise_by(heights)
    skin = body.raised(heights)
    exact = DistanceGrid.from_mesh(skin.vertices, skin.faces)
    middles = skin.vertices[skin.faces].mean(axis=1)
    for outside in (0.0, 0.01):
        points = middles + outside * exact.measure(middles)[1]
        difference = raised.distance(points) - exact.distance(points)
        assert np.sqrt((difference**2).mean()) < 1e-3
        assert np.sqrt(((grid.distance(points) - exact.distance(points)) ** 2).mean()) > 4e-3
    # where nothing is raised, nothing changes
    still = middles[heights[skin.faces].max(axis=1) < 1e-6]
    assert len(still) > 100
    assert np.abs(raised.distance(still) - grid.distance(still)).max() < 1e-5
