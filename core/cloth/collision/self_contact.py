"""Mesh and settings of the contact of a cloth with itself, without positions."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ...geometry.connectivity import HalfEdges
from ..settings import SelfContactSettings
from ..topology import Topology
from .patches import Patches, partition_cloth

PAIR_AREA_SHARE = 0.125
"""Weight of a pair as a share of the mean area of its nodes. Of two sheets in contact each node has one face of the
other sheet; a sheet of equal triangles has 3 edges per node, which cross about 7 of the other's: 2 + 7 pairs per node
area, so that the pressure is about that of the law."""

MAX_REACH_HEIGHT_SHARE = 0.5
"""Largest reach of a node as a share of the least height of the triangles around it: flat cloth is not in contact."""

PAIR_MARGIN_SHARE = 0.1
"""Margin of found pairs as a share of the mean edge. A larger margin gives more pairs and fewer searches."""


@dataclass(frozen=True)
class SelfContact:
    """Describe a cloth that touches itself: part of the `Scene`. Layers are pieces of one cloth. Areas and reach are
    computed once, from the first rest shape. Derivatives by the rest shape take them as constants, as they take
    friction's limits and anchors: they scale the law and are no property of the cloth.

    Attributes:
        faces: Node indices, shape [face_count, 3].
        edges: Each edge once, shape [edge_count, 2].
        areas: Area of each node [m2], shape [node_count].
        lengths: Mean length of the edges around each node [m], shape [node_count].
        reach: Distance at which each node's contact begins [m], shape [node_count].
        margin: Displacement up to which found pairs stay complete [m].
        patches: Groups of its faces, for the search of pairs.
        crossed: Faces that cross others, whose contact is off until they no longer do, shape [face_count].
    """

    settings: SelfContactSettings
    faces: np.ndarray
    edges: np.ndarray
    areas: np.ndarray
    lengths: np.ndarray
    reach: np.ndarray
    margin: float
    patches: Patches = field(repr=False)
    crossed: np.ndarray = field(repr=False)

    @classmethod
    def of(cls, topology: Topology, settings: SelfContactSettings = SelfContactSettings()) -> SelfContact:  # noqa: B008
        """Return the self-contact of a mesh with its rest shape."""
        faces, rest, count = topology.faces, topology.rest, topology.node_count
        half = HalfEdges.of(faces, count)
        sides = np.linalg.norm(rest.corners - np.roll(rest.corners, -1, axis=1), axis=2)
        heights = 2.0 * rest.areas / sides.max(axis=1)
        reach = np.full(count, float(settings.thickness))
        np.minimum.at(reach, faces, np.repeat(MAX_REACH_HEIGHT_SHARE * heights[:, None], 3, axis=1))
        lengths = np.bincount(half.edge, weights=sides.ravel()) / half.face_counts
        degree = np.bincount(half.edges.ravel(), minlength=count)
        around = np.bincount(half.edges.ravel(), np.repeat(lengths, 2), minlength=count) / np.maximum(degree, 1)
        margin = min(PAIR_MARGIN_SHARE * float(lengths.mean()), 2.0 * settings.thickness)
        edges = np.ascontiguousarray(half.edges, dtype=np.int64)
        off, patches = np.zeros(len(faces), dtype=bool), partition_cloth(half, rest.corners)
        return cls(settings, faces, edges, rest.node_areas, around, reach, margin, patches, off)

    def wait(self, crossed: np.ndarray) -> SelfContact:
        """Return the same cloth with contact off for these faces, shape [crossed_count], their nodes and edges."""
        off = np.zeros(len(self.faces), dtype=bool)
        off[crossed] = True
        return self if np.array_equal(off, self.crossed) else replace(self, crossed=off)

    @cached_property
    def open_parts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return which nodes, faces and edges are tested: all but those of crossed faces."""
        nodes = np.ones(len(self.areas), dtype=bool)
        nodes[self.faces[self.crossed]] = False
        return nodes, ~self.crossed, nodes[self.edges].any(axis=1)
