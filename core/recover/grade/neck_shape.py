"""Measure the cloth at a garment's neck: upright, turned over, slit, or as the garment's own."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...body.body import JOINTS, Body
from ...geometry.connectivity import HalfEdges, shortest_paths
from ...geometry.geometry import face_areas, face_normals
from ...geometry.surface import ClosestPoints, TriangleSurface
from ...scan.contours.edge_turn import EdgeTurn
from ...scan.contours.target import Contour, Target
from ...scan.contours.turned import join_turned_faces

SLOPE_BANDS = (0.0, 0.03, 0.06, 0.12)
"""Limits of the bands along the edge in which the cloth's slope is measured, distances along the cloth [m]: a stand is
3 cm wide, a fall 5, its points end 9 cm from the edge of the garment below."""

MAX_SLIT_WIDTH = 0.02
"""Distance of the edges of a closed placket [m]: its overlap."""


@dataclass(frozen=True)
class NeckShape:
    """Describe the cloth at a garment's neck.

    Attributes:
        slopes: Mean cosine of the outward normal with the trunk's direction in each of `SLOPE_BANDS`, shape [3]. A
            neckline's cloth slopes by 0.5 to 0.8, a strip that stands by 0 to 0.4, and what is turned over, whose
            outside faces the body, below 0.
        turned: Area that is turned over [m2].
        depth: Depth of its lowest place below the neck joint [m]; 0 where nothing is turned over.
        standing: Area over the skin of the neck that is not turned over [m2].
        height: Mean height of the edge above the neck joint along the trunk [m].
        length: Of the edge [m].
        corners: Number of its corners.
        slit: Length of a slit in front [m], below what is turned over also of one that falls open; 0 where there is
            none.
        is_open: Whether the front is open down to the hem.
    """

    slopes: np.ndarray
    turned: float
    depth: float
    standing: float
    height: float
    length: float
    corners: int
    slit: float
    is_open: bool

    @classmethod
    def of(cls, target: Target, body: Body) -> NeckShape | None:
        """Measure a target; None without a neck that the scan shows."""
        neck = target.contour("neck")
        if neck is None or not neck.trusted or not len(target.faces):
            return None
        vertices, faces = target.vertices, target.faces
        centres, areas = vertices[faces].mean(axis=1), face_areas(vertices, faces)
        skin = TriangleSurface(body.vertices, body.faces)
        found = skin.closest(centres)
        turned = join_turned_faces(vertices, faces, neck, skin, found)
        loop = vertices[neck.vertices]
        is_open = target.contour("front.left") is not None
        slit = 0.0 if is_open else measure_slit(loop)
        lowest = centres[turned, 1].min(initial=np.inf)
        if turned.any() and not is_open:
            slit = max(slit, float(lowest - loop[:, 1].min()))
        return cls(
            slopes=_measure_slopes(target, neck, body),
            turned=float(areas[turned].sum()),
            depth=float(body.joint("neck")[1] - lowest) if turned.any() else 0.0,
            standing=float(areas[_is_over_neck(found, body) & ~turned].sum()),
            height=float(((loop - body.joint("neck")) @ _trunk_direction(body)).mean()),
            length=neck.length,
            corners=len(EdgeTurn.of_target(neck, target).corners()),
            slit=slit,
            is_open=is_open,
        )

    def to_vector(self) -> np.ndarray:
        """Return what is compared with drapes, shape [9]: roots of areas, and the logarithm of the length, whose errors
        are alike for small and large ones."""
        sizes = (self.turned**0.5, self.standing**0.5, self.height, float(np.log(self.length)), self.depth)
        return np.array([*self.slopes, *sizes, min(self.corners, 2)])


def _trunk_direction(body: Body) -> np.ndarray:
    """Return the unit direction from the middle of the trunk to the neck, shape [3]."""
    up = body.joint("neck") - body.joint("spine2")
    return np.asarray(up / np.linalg.norm(up))


def _is_over_neck(found: ClosestPoints, body: Body) -> np.ndarray:
    """Return which of the closest points of a body are on the skin of neck or head, shape [n]."""
    columns = [JOINTS.index(name) for name in ("neck", "head")]
    return np.asarray(body.weights[body.faces[found.face]].mean(axis=1)[:, columns].sum(axis=1) > 0.5)


def _measure_slopes(target: Target, neck: Contour, body: Body) -> np.ndarray:
    """Return the slopes of the bands; where cloth ends nearer to the edge, that of the band before."""
    vertices, faces = target.vertices, target.faces
    edges = HalfEdges.of(faces, len(vertices))
    first, second = edges.edges.T
    lengths = np.linalg.norm(vertices[first] - vertices[second], axis=1)
    travel = shortest_paths(edges, lengths, neck.vertices, 1.5 * SLOPE_BANDS[-1])[0][faces].mean(axis=1)
    normals, areas = face_normals(vertices, faces)
    slope, found = normals @ _trunk_direction(body), [0.0]
    for start, end in pairwise(SLOPE_BANDS):
        near = (travel >= start) & (travel < end)
        found.append(float(np.average(slope[near], weights=areas[near])) if near.any() else found[-1])
    return np.array(found[1:])


def measure_slit(loop: np.ndarray) -> float:
    """Measure the longest slit of an edge [m]: a stretch that runs within `MAX_SLIT_WIDTH` beside another, from its
    lowest point upwards.

    Args:
        loop: Points along the closed edge [m], shape [n, 3].
    """
    low, count = int(loop[:, 1].argmin()), len(loop)
    length, first, second = 0.0, low, low
    for _ in range(count // 2):
        before, after = (first - 1) % count, (second + 1) % count
        # the side whose next point is lower climbs first, so that both stay at one height
        if loop[before, 1] < loop[after, 1]:
            first = before
        else:
            second = after
        if float(np.linalg.norm(loop[first] - loop[second])) > MAX_SLIT_WIDTH:
            break
        length = float(min(loop[first, 1], loop[second, 1]) - loop[low, 1])
    return length
