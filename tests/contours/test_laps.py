"""The border of a wrapped front is divided where it crosses itself."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.scan.contours.laps import divide_lap

BODY = builtin_body("builtin:female,height=1.70")
CROSSING = np.array([0.0, -0.15])
"""Where both edges cross, to the wearer's left and above the neck joint [m]."""


def draw_border(reach: float) -> np.ndarray:
    """Return the border of two fronts whose edges go on for a reach to either side of their crossing [m]."""
    gap = 0.002
    corners = np.array(
        [
            [0.08, 0.02, -0.01], [*CROSSING, 0.08], [-reach, CROSSING[1] - 2.0 * reach, 0.08],
            [-0.7 * reach, CROSSING[1] - 2.2 * reach, 0.08], [0.7 * reach, CROSSING[1] - 2.2 * reach, 0.08],
            [reach, CROSSING[1] - 2.0 * reach, 0.08 + gap], [*CROSSING, 0.08 + gap], [-0.08, 0.02, -0.01],
            [0.0, 0.0, -0.06],
        ]
    )  # fmt: skip
    shares = np.linspace(0.0, 1.0, 20, endpoint=False)[:, None]
    ends = np.roll(corners, -1, axis=0)
    line = np.concatenate([a + shares * (b - a) for a, b in zip(corners, ends, strict=True)])
    return BODY.joint("neck") + line + [0.0007, 0.0, 0.0] * np.sin(np.arange(len(line)))[:, None]


@pytest.mark.parametrize("start", [0, 47, 131])
def test_a_border_is_divided_where_its_edges_cross(start: int) -> None:
    """Breaks where the parts depend on the loop's first vertex, or miss the crossing."""
    points = np.roll(draw_border(0.2), -start, axis=0)
    parts = divide_lap(points, BODY)
    assert parts is not None
    assert sorted({*parts.seen, *parts.covered}) == list(range(len(points)))
    off = points - BODY.joint("neck")
    assert off[parts.seen, 1].min() > CROSSING[1] - 0.02
    for end in (parts.seen[[0, -1]], parts.covered[[0, -1]]):
        assert np.linalg.norm(off[end][:, :2] - CROSSING, axis=1).max() < 0.02


def test_a_double_breasted_front_and_a_plain_neck_are_no_laps() -> None:
    """Breaks where fronts that lap by 5 cm count as wrapped, or a V is divided at its point."""
    assert divide_lap(draw_border(0.05), BODY) is None
    points = draw_border(0.2)
    off = points - BODY.joint("neck")
    assert divide_lap(points[off[:, 1] > CROSSING[1] + 0.002], BODY) is None
