"""Find the side of the wearer for each vertex, and flatten panels that are turned around the wearer, such as gores."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np

from ...garment.garment import Garment
from ...garment.orientation import place_points
from ...geometry.rigid import plane_rotation

TURNED_PANEL_COSINE = 0.95
"""Cosine between the level outward direction of a panel and the wearer's depth axis, below which the panel is turned
around the wearer, by 18 degrees or more: panels drafted for front or back have 1."""

EDGE_ON_PANEL_COSINE = 0.3
"""Cosine between the outward direction of a panel and the wearer's depth axis, below which front or back follows from
the depth at which the panel is placed, not from its direction."""

MIN_UPRIGHT_SHARE = 0.7
"""Share of a seam's length by which it rises, from which its two panels stand beside each other. Also the level share
of a panel's outward direction from which the panel stands upright."""


def find_sides(garment: Garment) -> np.ndarray:
    """Return whether each vertex of a garment's flat mesh is worn in front (+1) or behind (-1), shape [n].

    A panel is in front or behind as a whole, unless it is turned around the wearer: there each vertex takes the side
    where it is placed. Of an edge that crosses from front to back one end is 0, so that no edge joins the two.
    """
    outward, depth = _facing_cosines(garment), np.array([panel.translation[2] for panel in garment.pattern.panels])
    middle = depth.mean()
    side: np.ndarray = np.where(np.abs(outward) > EDGE_ON_PANEL_COSINE, np.sign(outward), np.sign(depth - middle))[
        garment.panel_of_uv
    ]
    turned = _is_turned(garment)[garment.panel_of_uv]
    if not turned.any():
        return side
    placed = _placed_vertices(garment)[:, 2] - middle
    edges = garment.uv_faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    crosses = placed[edges].prod(axis=1) < 0.0
    nearer = np.take_along_axis(edges, np.abs(placed[edges]).argmin(axis=1)[:, None], axis=1)[crosses, 0]
    placed[nearer] = 0.0
    found: np.ndarray = np.where(turned, np.sign(placed), side)
    return found


def fan_out(garment: Garment, flat: np.ndarray) -> np.ndarray:
    """Return the flat places of a garment's vertices [m], shape [n, 2], with turned panels side by side as a fan.

    Seen from the front, turned gores are foreshortened, and their slanted sides overlap. Flat they form a fan in front
    and one behind, like the halves of a circle. Each fan is unrolled from the panel that faces most to front or back:
    the next panel is placed where the points of their common seam fit best (rigidly, by least squares). A panel at the
    wearer's side, partly in front and partly behind, belongs to both.

    Args:
        garment: The sewn garment, panels as its file places them.
        flat: The vertices as seen from the front [m], shape [n, 2]; returned unchanged where no panel is turned.
    """
    ring = _find_ring(garment)
    if ring is None:
        return flat
    side = find_sides(garment)
    fans = [fan for sign in (1.0, -1.0) if (fan := _unroll(garment, ring, side, sign)) is not None]
    if len(fans) == 2:
        fans[1] = fans[1].aligned_to(fans[0], garment.uv_node)
    fan = _Fan.joined(fans)
    places = (fan.places - fan.places.mean(axis=0)) @ plane_rotation(-float(fan.angles.mean())).T
    places += flat[fan.vertices].mean(axis=0)
    total, count = np.zeros_like(flat), np.bincount(fan.vertices, minlength=len(flat))
    np.add.at(total, fan.vertices, places)
    return np.where(count[:, None] > 0, total / np.maximum(count, 1)[:, None], flat)


@dataclass(frozen=True)
class _Ring:
    """Describe panels that stand around the wearer: their indices, and the pairs that an upright seam joins."""

    panels: tuple[int, ...]
    adjacent: frozenset[tuple[int, int]]


@dataclass(frozen=True)
class _Fan:
    """Describe the flat panels in front, or behind, seen from the front.

    Attributes:
        vertices: Its flat vertices, shape [k].
        places: Their positions [m], shape [k, 2].
        angles: Angle by which their panels are turned [rad], shape [k].
    """

    vertices: np.ndarray
    places: np.ndarray
    angles: np.ndarray

    @classmethod
    def joined(cls, fans: list[_Fan]) -> _Fan:
        """Return some fans as one."""
        return cls(*(np.concatenate([getattr(fan, name) for fan in fans]) for name in ("vertices", "places", "angles")))

    def aligned_to(self, other: _Fan, uv_node: np.ndarray) -> _Fan:
        """Return the fan moved so that the points it shares with another, or is sewn to, fit best."""
        _, a, b = np.intersect1d(uv_node[self.vertices], uv_node[other.vertices], return_indices=True)
        if not len(a):
            return self
        start, goal = self.places[a].mean(axis=0), other.places[b].mean(axis=0)
        angle = _angle_between(self.places[a] - start, other.places[b] - goal)
        return _Fan(self.vertices, (self.places - start) @ plane_rotation(angle).T + goal, self.angles + angle)


def _facing_cosines(garment: Garment) -> np.ndarray:
    return np.array([panel.rotation[2, 2] for panel in garment.pattern.panels])


def _is_turned(garment: Garment) -> np.ndarray:
    """Check which panels are turned around the wearer, shape [panel_count]."""
    normals = np.array([panel.rotation[:, 2] for panel in garment.pattern.panels])
    level = np.hypot(normals[:, 0], normals[:, 2])
    return np.asarray((level > MIN_UPRIGHT_SHARE) & (np.abs(normals[:, 2]) < TURNED_PANEL_COSINE * level))


def _placed_vertices(garment: Garment) -> np.ndarray:
    """Return the flat vertices where the pattern's file places them [m], shape [n, 3]."""
    placed = np.zeros((len(garment.uv), 3))
    for index, panel in enumerate(garment.pattern.panels):
        in_panel = garment.panel_of_uv == index
        placed[in_panel] = place_points(panel, garment.uv[in_panel])
    return placed


def _find_ring(garment: Garment) -> _Ring | None:
    """Find the turned panels and those beside them; None where no panel is turned."""
    turned = set(np.flatnonzero(_is_turned(garment)).tolist())
    if not turned:
        return None
    index = {panel.name: i for i, panel in enumerate(garment.pattern.panels)}
    placed, beside = _placed_vertices(garment), set()
    for seam in garment.pattern.seams:
        line = placed[garment.edge_uv[seam.a]]
        length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
        pair = {index[seam.a.panel], index[seam.b.panel]}
        if abs(line[-1, 1] - line[0, 1]) > MIN_UPRIGHT_SHARE * length and pair & turned:
            beside |= set(permutations(pair, 2))
    return _Ring(tuple(sorted(turned.union(*beside))), frozenset(beside))


def _unroll(garment: Garment, ring: _Ring, side: np.ndarray, sign: float) -> _Fan | None:
    """Lay the front (sign 1) or back (-1) of a ring side by side; None where it has no vertices there."""
    pieces, outward = {}, sign * _facing_cosines(garment)
    for panel in ring.panels:
        vertices = np.flatnonzero((garment.panel_of_uv == panel) & (sign * side >= 0.0))
        if (sign * side[vertices] > 0.0).any():
            pieces[panel] = vertices
    laid: dict[int, _Fan] = {}
    waiting = [(panel, panel) for panel in sorted(pieces, key=lambda panel: -outward[panel])[:1]]
    while waiting:
        panel, before = waiting.pop(0)
        if panel in laid:
            continue
        upward = garment.pattern.panels[panel].rotation[1, :2]
        upward = upward / np.linalg.norm(upward)
        places = garment.uv[pieces[panel]] @ np.array([[sign * upward[1], -sign * upward[0]], upward]).T
        fan = _Fan(pieces[panel], places, np.zeros(len(places)))
        laid[panel] = fan.aligned_to(laid[before], garment.uv_node) if laid else fan
        waiting += [(other, panel) for other in sorted(pieces) if (panel, other) in ring.adjacent]
    if not laid:
        return None
    return _Fan.joined(list(laid.values()))


def _angle_between(source: np.ndarray, goal: np.ndarray) -> float:
    """Return the angle [rad] that turns points onto others, both about the origin, by least squares."""
    cross = source[:, 0] * goal[:, 1] - source[:, 1] * goal[:, 0]
    return float(np.arctan2(cross.sum(), (source * goal).sum()))
