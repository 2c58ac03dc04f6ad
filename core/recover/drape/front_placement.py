"""Hold the edges of a front that is worn open where a scan shows them: nothing in a pattern says how far it is open."""

from __future__ import annotations

import numpy as np

from ...cloth.pins import Pins
from ...garment.garment import Garment
from ...scan.contours.target import Target

FRONT_EDGES = ("front.left", "front.right")
"""Open contours of the edges."""

FRONT_EDGE_STIFFNESS = 10.0
"""Stiffness of the springs that stand for the friction of a front's edges on what they lie on [N/m]: a node's share of
the weight of a jacket, some mN, moves it by less than a millimetre."""

FRONT_EDGE_DIRECTIONS = (1.0, 0.0, 1.0)
"""Weights of the springs along x, y and z [1]: the cloth hangs freely in height."""


def pin_front(garment: Garment, target: Target) -> Pins | None:
    """Return pins of an open front's edges at the same shares of the lengths of the scan's; None without such edges.

    Args:
        garment: The garment, its contours named.
        target: The scan, its contours named.
    """
    ours = [garment.contour(name) for name in FRONT_EDGES]
    seen = [target.contour(name) for name in FRONT_EDGES]
    nodes, points = [], []
    for own, other in zip(ours, seen, strict=True):
        if own is None or other is None or not other.trusted:
            return None
        nodes.append(own.vertices)
        arc = own.curve(garment.nodes).arc
        points.append(other.curve(target.vertices).at_shares(arc / arc[-1]))
    return Pins(np.concatenate(nodes), np.concatenate(points), FRONT_EDGE_STIFFNESS, FRONT_EDGE_DIRECTIONS)


def place_pinned(nodes: np.ndarray, pins: Pins) -> np.ndarray:
    """Return nodes [m], shape [node_count, 3], the pinned ones at their pins in the directions that these act along."""
    placed = nodes.copy()
    placed[pins.nodes] = np.where(np.array(pins.directions) > 0.0, pins.points, nodes[pins.nodes])
    return placed
