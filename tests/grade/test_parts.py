"""Parts of a garment that are graded as one, and what a kink between them costs, on two tubes sewn together."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.grade.registration import bending_operators, find_parts
from garmentq.core.pattern import Edge, EdgeRef, Garment, Panel, Pattern, Seam, mesh_pattern

SIDE = 0.3
"""Side of each square panel [m]."""


@pytest.fixture(scope="module")
def garment() -> Garment:
    """Sew two tubes of two squares each, one below the other."""
    points = SIDE * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    names = ("upper_front", "upper_back", "lower_front", "lower_back")
    seams = []
    for tube in ("upper", "lower"):
        for a, b in ((1, 3), (3, 1)):
            seams.append(Seam(EdgeRef(f"{tube}_front", a), EdgeRef(f"{tube}_back", b)))
    for side in ("front", "back"):
        seams.append(Seam(EdgeRef(f"upper_{side}", 0), EdgeRef(f"lower_{side}", 2)))
    panels = tuple(Panel(name, points, (Edge(),) * 4) for name in names)
    return mesh_pattern(Pattern("tubes", panels, tuple(seams)), 400)


def cost(garment: Garment, values: np.ndarray, across: float) -> float:
    """Give the bending energy of a displacement told at the uv vertices."""
    on_nodes = np.zeros(len(garment.nodes))
    on_nodes[garment.uv_node] = values
    return float(on_nodes @ bending_operators(garment, across)[0] @ on_nodes)


def test_a_front_and_its_back_are_one_part(garment):
    """Broken where one seam joins two parts, or two do not."""
    part = find_parts(garment.pattern)
    assert part[0] == part[1] != part[2] == part[3]


def test_a_kink_is_free_between_parts_only(garment):
    """Broken where panels of one part may kink, or parts are held together by more than their share."""
    lower = garment.panel_of_uv >= 2
    below = np.where(lower, SIDE - garment.uv[:, 1], 0.0)
    round_ = np.where(garment.panel_of_uv % 2 == 0, garment.uv[:, 0], SIDE - garment.uv[:, 0])
    whole = cost(garment, below, 1.0)
    assert whole > 0.1
    assert cost(garment, below, 0.0) < 1e-9 * whole
    assert cost(garment, below, 0.01) == pytest.approx(0.01 * whole)
    assert cost(garment, round_, 0.0) > 0.1
