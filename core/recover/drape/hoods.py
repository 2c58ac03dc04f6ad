"""Put on hoods: they are placed around the head or behind the neck, and sewn to a garment that is worn already.

The panels of a garment are flattened before and behind the body. A hood's side pieces stand beside the head instead, in
planes along the middle plane, and its lower edge goes around the neck: its place follows from the neckline's."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...body.body import Body
from ...body.signed_distance import SignedDistance
from ...cloth.settings import STANDARD_GRAVITY
from ...garment.garment import Garment
from ...garment.orientation import place_points
from ...garment.panel_selection import select_panels
from ...garment.parts.hoods import HOOD_LABEL
from .harmonic import extend_harmonically
from .layer_contact import LayerContact
from .pbd import DistanceConstraints, PbdSettings, PbdState, simulate_pbd
from .unfolding import unfold_crossings

MIN_SIDEWAYS_SHARE = 0.9
"""Share of a panel's outward direction across the wearer from which the panel is a side piece [1]."""

ASIDE_STEP = 0.006
"""Distance from the body at which a hood's nodes are placed beside it, and the step by which they are moved [m]: more
than the contact thickness of the position-based steps."""

MAX_ASIDE_SHIFT = 0.12
"""Longest way out of the head to its side [m]: more than half its breadth, less than that of the shoulders."""

NO_PLANE_DISTANCE = 1.0
"""Distance that is returned to nodes that are not held [m]: beyond every contact."""


@dataclass(frozen=True)
class HoodSettings:
    """Describe how a hood is put on.

    Attributes:
        relax: Number of position-based steps in which it relaxes without weight.
        travel: Longest move of a node in such a step [m]: the edges of a hood that is placed behind the neck start a
            third too long, and cloth that contracts faster buckles to one side.
        fall: Number of steps in which it falls.
    """

    relax: int = 120
    travel: float = 2e-3
    fall: int = 60


@dataclass(frozen=True)
class HoodedGarment:
    """Describe a garment with a hood, and the part of it below the hood.

    Attributes:
        whole: The garment.
        below: Its panels but the hood's, with a mesh of their own.
        nodes: Node of the whole for each node of the part below, shape [below_node_count].
    """

    whole: Garment
    below: Garment
    nodes: np.ndarray

    def put_on(self, worn: np.ndarray, body: Body, distance: SignedDistance | None = None) -> np.ndarray:
        """Return all nodes, the hood placed on a garment that is worn [m], shape [node_count, 3].

        Side pieces keep the planes in which the pattern places them, shifted so that the nape is where it is worn, and
        are rounded towards the middle plane where they are sewn to each other or to a strip. Their lower edges are
        moved onto the neckline, their inner vertices follow harmonically, and so does the strip. What is then inside
        the head is moved out to its side.

        Args:
            worn: Nodes of the part below [m], shape [below_node_count, 3].
            body: The wearer.
            distance: Signed distance to the wearer, or None to leave what is inside.
        """
        garment, count = self.whole, len(self.whole.nodes)
        nodes, below = np.zeros((count, 3)), np.zeros(count, dtype=bool)
        nodes[self.nodes], below[self.nodes] = worn, True
        outward = _outward_sides(garment)
        hooded, side = _is_hood(garment)[garment.panel_of_uv], outward != 0.0
        places = np.zeros((len(garment.uv), 3))
        for index, panel in enumerate(garment.pattern.panels):
            members = garment.panel_of_uv == index
            places[members] = place_points(panel, garment.uv[members])
        middle = np.median(worn[:, 0])
        on_neck, on_side = below[garment.uv_node], np.bincount(garment.uv_node[side], minlength=count) > 0
        nape = np.flatnonzero(on_neck & side)
        nape = nape[nodes[garment.uv_node[nape], 2].argmin()]
        places[side, 1:] += (nodes[garment.uv_node[nape]] - places[nape])[1:]
        shared = np.bincount(garment.uv_node[hooded], minlength=count)[garment.uv_node] > 1
        seam = hooded & shared & ~on_neck & on_side[garment.uv_node]
        self._round(places, side, outward, seam)
        places[hooded, 0] += middle
        goal = np.zeros((count, 3))
        np.add.at(goal, garment.uv_node[side], places[side])
        goal /= np.maximum(np.bincount(garment.uv_node[side], minlength=count), 1)[:, None]
        goal[self.nodes] = worn
        fixed = hooded & (seam | on_neck)
        places += self._extend(goal[garment.uv_node] - places, fixed, hooded)
        nodes[garment.uv_node[hooded]] = places[hooded]
        if distance is not None:
            inner = np.setdiff1d(garment.uv_node[side], garment.uv_node[fixed])
            inner = inner[nodes[inner, 1] > body.joint("neck")[1]]
            sign = np.zeros(count)
            sign[garment.uv_node[side]] = outward[side]
            nodes[inner] = _move_aside(nodes[inner], sign[inner], distance)
        nodes[self.nodes] = worn
        return nodes

    def centre_back(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the nodes of the centre back seam, or of the strip there, and their distances to the wearer's left
        from the middle plane when it is flat [m], shape [n] each."""
        garment, count = self.whole, len(self.whole.nodes)
        hooded = _is_hood(garment)[garment.panel_of_uv]
        strip = np.flatnonzero(hooded & (_outward_sides(garment) == 0.0))
        left = np.zeros(count)
        for index in np.unique(garment.panel_of_uv[strip]):
            members = np.flatnonzero(garment.panel_of_uv == index)
            left[garment.uv_node[members]] = place_points(garment.pattern.panels[index], garment.uv[members])[:, 0]
        seam = np.flatnonzero(np.bincount(garment.uv_node[hooded], minlength=count) > 1)
        found = np.setdiff1d(garment.uv_node[strip] if len(strip) else seam, self.nodes)
        return found, left[found]

    def _round(self, places: np.ndarray, side: np.ndarray, outward: np.ndarray, seam: np.ndarray) -> None:
        """Round side pieces, in place, by a quarter of an ellipse from their planes to the seam at the centre back."""
        garment = self.whole
        strip = np.zeros(len(garment.nodes))
        ends = seam & ~side
        np.maximum.at(strip, garment.uv_node[ends], np.abs(places[ends, 0]))
        for index in np.unique(garment.panel_of_uv[side]):
            members = np.flatnonzero(garment.panel_of_uv == index)
            edge = members[seam[members]]
            away, nearest = cKDTree(garment.uv[edge]).query(garment.uv[members])
            least = strip[garment.uv_node[edge[nearest]]]
            width = np.abs(places[members, 0]) - least
            share = 1.0 - np.minimum(away / width, 1.0)
            places[members, 0] = outward[members] * (least + width * np.sqrt(1.0 - share**2))

    def _extend(self, values: np.ndarray, fixed: np.ndarray, hooded: np.ndarray) -> np.ndarray:
        """Extend values at fixed vertices harmonically over the hood's flat mesh, shape [uv_count, 3]; 0 elsewhere."""
        rank = np.cumsum(hooded) - 1
        faces = rank[self.whole.uv_faces[hooded[self.whole.uv_faces].all(axis=1)]]
        found = np.zeros_like(values)
        found[hooded] = extend_harmonically(faces, int(hooded.sum()), np.flatnonzero(fixed[hooded]), values[fixed])
        return found


def _is_hood(garment: Garment) -> np.ndarray:
    """Check which panels are a hood's, shape [panel_count]."""
    return np.array([panel.label == HOOD_LABEL for panel in garment.pattern.panels])


def _outward_sides(garment: Garment) -> np.ndarray:
    """Return the wearer's left (+1) or right (-1) of a hood's side pieces, shape [uv_count]; 0 at other vertices."""
    across = np.array([panel.rotation[0, 2] for panel in garment.pattern.panels])
    sideways = _is_hood(garment) & (np.abs(across) > MIN_SIDEWAYS_SHARE)
    found: np.ndarray = np.where(sideways, np.sign(across), 0.0)[garment.panel_of_uv]
    return found


def _move_aside(points: np.ndarray, outward: np.ndarray, body: SignedDistance) -> np.ndarray:
    """Move points inside a body out of it, along x to the given side; those with no way out near by stay."""
    found, left = points.copy(), np.ones(len(points), dtype=bool)
    for shift in np.arange(0.0, MAX_ASIDE_SHIFT, ASIDE_STEP):
        index = np.flatnonzero(left)
        moved = points[index].copy()
        moved[:, 0] += outward[index] * shift
        free = body.measure(moved)[0] > ASIDE_STEP
        found[index[free]] = moved[free]
        left[index[free]] = False
    return found


def take_off_hood(garment: Garment) -> HoodedGarment | None:
    """Return a garment with a hood and the part below it; None where there is no hood, or nothing else."""
    names = frozenset(panel.name for panel in garment.pattern.panels if panel.label != HOOD_LABEL)
    if not names or not _outward_sides(garment).any():
        return None
    below, nodes = select_panels(garment, names)
    return HoodedGarment(garment, below, nodes)


@dataclass(frozen=True)
class _HeldBody:
    """Describe a body and planes that keep some nodes at their distance from the middle plane.

    Attributes:
        body: The body.
        count: Number of the cloth's nodes; other points, such as centres of faces, are not held.
        nodes: Those that are held, shape [n].
        left: Their x [m], shape [n].
        thickness: Distance that cloth keeps from the body [m].
    """

    body: SignedDistance
    count: int
    nodes: np.ndarray
    left: np.ndarray
    thickness: float

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the distances to the body [m] and their gradients, and for nodes those to both planes."""
        distance, gradient = self.body.measure(points)
        if len(points) != self.count:
            return distance, gradient
        rows, ways = [distance], [gradient]
        for sign in (1.0, -1.0):
            row, way = np.full(self.count, NO_PLANE_DISTANCE), np.zeros((self.count, 3))
            row[self.nodes], way[:, 0] = self.thickness + sign * (points[self.nodes, 0] - self.left), sign
            rows.append(row)
            ways.append(way)
        return np.concatenate(rows), np.concatenate(ways)


def wear_hood(
    hooded: HoodedGarment,
    worn: np.ndarray,
    body: Body,
    distance: SignedDistance,
    threads: DistanceConstraints,
    *,
    follow: PbdSettings,
    settings: HoodSettings,
) -> PbdState:
    """Put a hood on a garment that is worn; return the state in which it has fallen.

    The hood is placed (`HoodedGarment.put_on`), relaxes without weight and falls, the garment below at rest, which its
    fall would pull off the shoulders. The centre back seam stays in the middle plane meanwhile: a hood behind the neck
    would otherwise fall over one shoulder.
    """
    seam, left = hooded.centre_back()
    around = _HeldBody(distance, len(hooded.whole.nodes), seam, left + np.median(worn[:, 0]), follow.thickness)
    start, layers = PbdState.at_rest(hooded.put_on(worn, body, distance)), LayerContact()
    slow = replace(follow, travel=settings.travel)
    nodes = simulate_pbd(threads, start, around, settings.relax, settings=slow, pins=hooded.nodes, layers=layers).nodes
    nodes = unfold_crossings(threads, nodes, distance, settings=follow, pins=hooded.nodes)
    start, weight = PbdState.at_rest(nodes), -STANDARD_GRAVITY[1]
    return simulate_pbd(
        threads, start, around, settings.fall, settings=follow, gravity=weight, pins=hooded.nodes, layers=layers
    )
