"""Small patterns in the GarmentCode format: every kind of curve, clockwise panels, a gathered seam, a T-shirt."""

from __future__ import annotations

import copy

import pytest


def _skirt() -> dict:
    """Two panels and a waistband in centimetres: the back is drawn clockwise, the front is gathered into its band."""
    line = lambda a, b, **more: {"endpoints": [a, b], **more}  # noqa: E731
    circle = {"type": "circle", "params": [60.0, 0, 1]}
    front = {
        "translation": [-25, 50, 20],
        "rotation": [0, 0, 0],
        "vertices": [[0, 0], [50, 0], [45, 40], [5, 40]],
        "edges": [
            line(0, 1, curvature={"type": "quadratic", "params": [[0.5, -0.06]]}),
            line(1, 2),
            line(2, 3),
            line(3, 0),
        ],
        "label": "leg",
        "colour": "red",
    }
    back = {
        "translation": [-25, 50, -20],
        "rotation": [0, 0, 0],
        "vertices": [[0, 0], [5, 40], [45, 40], [50, 0]],
        "edges": [
            line(0, 1),
            line(1, 2),
            line(2, 3),
            line(3, 0, curvature={"type": "cubic", "params": [[0.3, 0.05], [0.7, 0.05]]}),
        ],
    }
    band = {
        "translation": [-16, 95, 15],
        "rotation": [0, 0, 0],
        "vertices": [[0, 0], [32, 0], [32, 5], [0, 5]],
        "edges": [
            line(0, 1, curvature=circle),
            line(1, 2),
            line(2, 3, curvature=circle | {"params": [60.0, 0, 0]}),
            line(3, 0),
        ],
    }
    side = lambda panel, edge: {"panel": panel, "edge": edge}  # noqa: E731
    stitches = [
        [side("front", 1), side("back", 2)],
        [side("front", 3), side("back", 0)],
        [side("front", 2), side("band", 0)],
    ]
    return {
        "pattern": {
            "panels": {"front": front, "back": back, "band": band},
            "stitches": stitches,
            "panel_order": ["front"],
        },
        "parameters": {"length": {"value": 1}},
        "parameter_order": ["length"],
        "properties": {"curvature_coords": "relative", "units_in_meter": 100, "author": "a test"},
    }


def _tee() -> dict:
    """A T-shirt with half sleeves and the older list curvature; edges of the back run against its vertex order."""
    body = [[-20, 0], [20, 0], [20, 40], [17, 58], [8, 60], [-8, 60], [-17, 58], [-20, 40]]
    edges = [
        {"endpoints": [0, 1]},
        {"endpoints": [1, 2]},
        {"endpoints": [2, 3], "curvature": [0.4, 0.15]},
        {"endpoints": [3, 4]},
        {"endpoints": [4, 5], "curvature": [0.5, 0.4]},
        {"endpoints": [5, 6]},
        {"endpoints": [6, 7], "curvature": [0.6, 0.15]},
        {"endpoints": [7, 0]},
    ]
    front = {"translation": [0, 80, 20], "rotation": [0, 0, 0], "vertices": body, "edges": edges}
    back = {
        "translation": [0, 80, -20],
        "rotation": [0, 180, 0],
        "vertices": body,
        "edges": [dict(edge) for edge in edges],
    }
    left = [[0, 0], [15, 3], [15, 17], [0, 18.2]]
    right = [[-x, y] for x, y in left]
    cap = 0.12
    sleeve = [{"endpoints": [0, 1]}, {"endpoints": [1, 2]}, {"endpoints": [2, 3]}]
    panels = {"front": front, "back": back}
    panels["sleeve_left"] = {
        "translation": [30, 120, 20],
        "rotation": [0, 0, 0],
        "vertices": left,
        "edges": [*copy.deepcopy(sleeve), {"endpoints": [3, 0], "curvature": [0.6, -cap]}],
    }
    panels["sleeve_right"] = {
        "translation": [-30, 120, 20],
        "rotation": [0, 0, 0],
        "vertices": right,
        "edges": [
            {"endpoints": [0, 3], "curvature": [0.4, -cap]},
            {"endpoints": [3, 2]},
            {"endpoints": [2, 1]},
            {"endpoints": [1, 0]},
        ],
    }
    side = lambda panel, edge: {"panel": panel, "edge": edge}  # noqa: E731
    stitches = [
        [side("front", 1), side("back", 7)],
        [side("front", 7), side("back", 1)],
        [side("front", 3), side("back", 5)],
        [side("front", 5), side("back", 3)],
        [side("front", 2), side("sleeve_left", 3)],
        [side("front", 6), side("sleeve_right", 0)],
    ]
    return {
        "pattern": {"panels": panels, "stitches": stitches},
        "properties": {"curvature_coords": "relative", "units_in_meter": 100},
    }


@pytest.fixture
def skirt_file() -> dict:
    """Return a fresh GarmentCode skirt."""
    return _skirt()


@pytest.fixture
def tee_file() -> dict:
    """Return a fresh T-shirt with a back, a front and two half sleeves."""
    return _tee()
