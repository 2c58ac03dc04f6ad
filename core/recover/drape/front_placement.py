"""Find where the edges of a front that is worn open are held: a scan shows how far it is open, a pattern does not."""

from __future__ import annotations

import numpy as np

from ...body.body import Body
from ...cloth.pins import Pins
from ...garment.garment import Garment
from ...scan.contours.target import Target

FRONT_EDGES = ("front.left", "front.right")
"""Open contours of the edges."""

FRONT_EDGE_STIFFNESS = 10.0
"""Stiffness of the springs that stand for the friction of a front's edges on what they lie on [N/m]: a node's share of
the weight of a jacket, some mN, moves it by less than a millimetre."""

EDGE_GAP = 0.004
"""Least distance of the two edges, sideways [m]: twice that of layers that rest on each other. Edges that a scan shows
nearer, or lapped, meet: a pull through each other would not come to rest."""


def pin_front(garment: Garment, target: Target, body: Body) -> Pins | None:
    """Return pins of an open front's edges at the same shares of the lengths of the scan's; None without such edges.

    Args:
        garment: The garment, its contours named.
        target: The scan, its contours named.
        body: The wearer.
    """
    ours = [one for name in FRONT_EDGES if (one := garment.contour(name)) is not None]
    seen = [one for name in FRONT_EDGES if (one := target.contour(name)) is not None and one.trusted]
    if len(ours) < len(FRONT_EDGES) or len(seen) < len(FRONT_EDGES):
        return None
    curves = [one.curve(target.vertices) for one in seen]
    nodes, points = [], []
    lateral = body.sideways("shoulder")
    lateral = lateral / np.linalg.norm(lateral)
    for own, curve, other, side in zip(ours, curves, curves[::-1], (0.5, -0.5), strict=True):
        arc = own.curve(garment.nodes).arc
        place, opposite = curve.at_shares(arc / arc[-1]), other.at_shares(1.0 - arc / arc[-1])
        gap = 2.0 * side * ((place - opposite) @ lateral)
        nodes.append(own.vertices)
        points.append(place + side * np.maximum(0.0, EDGE_GAP - gap)[:, None] * lateral)
    along = abs(float(lateral[0])), 0.0, abs(float(lateral[2]))  # sideways; the cloth hangs freely in height and depth
    return Pins(np.concatenate(nodes), np.concatenate(points), FRONT_EDGE_STIFFNESS, along)


def place_pinned(nodes: np.ndarray, pins: Pins) -> np.ndarray:
    """Return nodes [m], shape [node_count, 3], the pinned ones at their pins in the directions that these act along."""
    placed = nodes.copy()
    weights, before = np.array(pins.directions), nodes[pins.nodes]
    placed[pins.nodes] = np.where(weights == 1.0, pins.points, before + weights * (pins.points - before))
    return placed
