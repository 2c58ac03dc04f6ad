"""Find seams whose place on a smooth surface the curvature of the cloth or what is on it shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...body.body import Body
from ...garment.garment import Garment
from ...garment.pattern import EdgeRef
from ...scan.contours.target import Target
from .parts import find_armhole_pairs
from .seam_traces import find_seam_traces
from .shoulder_points import find_shoulder_points
from .trunk_curvature import TrunkCurvature
from .waist_seam import find_waist_line, is_waist_seam


@dataclass(frozen=True)
class SeenSeam:
    """Describe nodes of a seam and the plane in which the cloth shows each.

    Attributes:
        nodes: Their indices, shape [n].
        normals: Unit normals of the planes, shape [n, 3].
        offsets: Of the planes along their normals [m], shape [n].
    """

    nodes: np.ndarray
    normals: np.ndarray
    offsets: np.ndarray

    @classmethod
    def in_plane(cls, nodes: np.ndarray, normal: np.ndarray, offset: float) -> SeenSeam:
        """Return nodes that are seen in one plane."""
        return cls(nodes, np.tile(normal, (len(nodes), 1)), np.full(len(nodes), offset))

    def distance(self, nodes: np.ndarray) -> np.ndarray:
        """Return the distances of its nodes from their planes [m], given all nodes [m]; shape [n]."""
        return np.asarray((nodes[self.nodes] * self.normals).sum(axis=1) - self.offsets)


def find_traced_seams(garment: Garment, target: Target) -> tuple[SeenSeam, ...]:
    """Find the nodes of a drafted garment's seams whose place the target's colours or stripes show.

    Args:
        garment: The mesh, nodes on the target.
        target: The scan's surface.
    """
    traces = [trace for _, trace in find_seam_traces(garment, target).values()]
    return tuple(SeenSeam(one.nodes, one.across, (one.places * one.across).sum(axis=1)) for one in traces)


def find_seen_seams(garment: Garment, target: Target, body: Body) -> tuple[SeenSeam, ...]:
    """Find the nodes of a drafted garment whose place on the target its curvature shows.

    These are the height of a smooth waist seam, for in front two panels can share the cloth at any height, and the
    width of the shoulders, which an armhole can cross anywhere.

    Args:
        garment: The mesh, nodes on the target.
        target: The scan's surface.
        body: The wearer.
    """
    pattern = garment.pattern
    waist = [seam.a for seam in pattern.seams if is_waist_seam(pattern, seam)]
    armholes = find_armhole_pairs(pattern)
    if not waist and not armholes:
        return ()
    cloth = TrunkCurvature.of(target, body)
    found = []
    line = find_waist_line(cloth) if waist else None
    if line is not None:
        nodes = np.unique(garment.uv_node[np.concatenate([garment.edge_uv[ref] for ref in waist])])
        found.append(SeenSeam.in_plane(nodes[line.is_seen_at(garment.nodes[nodes])], line.normal, line.offset))
    points = find_shoulder_points(cloth) if armholes else None
    if points is not None:
        ends = np.unique([_nodes_of_points(garment)[list(pair)] for pairs in armholes for pair in pairs])
        across, up, _ = ((garment.nodes[ends] - cloth.origin) @ cloth.axes.T).T
        for sign, place in zip((1.0, -1.0), points, strict=True):
            on_side = sign * across > 0.0
            top = ends[on_side][int(np.argmax(up[on_side]))]
            offset = float(cloth.origin @ cloth.axes[0] + place[0])
            found.append(SeenSeam.in_plane(np.array([top]), cloth.axes[0], offset))
    return tuple(found)


def _nodes_of_points(garment: Garment) -> np.ndarray:
    """Return the node at each control point of the pattern, shape [point_count]."""
    return np.array(
        [
            garment.uv_node[garment.edge_uv[EdgeRef(panel.name, i)][0]]
            for panel in garment.pattern.panels
            for i in range(len(panel.points))
        ]
    )
