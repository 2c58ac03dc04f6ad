"""What of a cloth may touch itself, and how: the law's numbers and the mesh, without positions."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ...geometry.connectivity import HalfEdges
from ..settings import SelfContactSettings
from ..topology import Topology
from .patches import Patches, partition_cloth

PAIR_AREA_SHARE = 0.125
"""Weight of a pair as a share of the mean area of its nodes. Of two sheets that lie on each other each node has one
face of the other sheet, and a sheet of equal triangles has 3 edges a node, which cross some 7 of the other's: 2 + 7
pairs for the area of a node, so that the pressure is about that of the law."""

MAX_REACH_HEIGHT_SHARE = 0.5
"""Largest reach of a node as a share of the least height of the triangles around it: what is flat is not in contact."""

PAIR_MARGIN_SHARE = 0.1
"""Share of the mean edge that is the margin of found pairs. A larger margin holds more pairs and needs fewer
searches."""


@dataclass(frozen=True)
class SelfContact:
    """Describe a cloth that touches itself: part of the `Scene`. Layers are pieces of one cloth.

    Areas and reach are those of the rest shape it was made with; a derivative by the rest shape counts them as given,
    as friction's limits and anchors, for they set the law's numbers and no property of the cloth.

    Attributes:
        settings: The law.
        faces: Node indices, shape [face_count, 3].
        edges: Each edge once, shape [edge_count, 2].
        areas: Area of each node [m2], shape [node_count].
        lengths: Mean length of the edges around each node [m], shape [node_count].
        reach: Distance at which each node begins to touch [m], shape [node_count].
        margin: Distance around a place up to which pairs found there are complete [m].
        patches: Groups of its faces, by which pairs are looked for.
        crossed: Faces that cross others, for which contact waits until they no longer do, shape [face_count].
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
        """Describe a mesh with its rest shape."""
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
        """Return the same cloth with contact off for these faces, shape [crossed_count], and what belongs to them."""
        off = np.zeros(len(self.faces), dtype=bool)
        off[crossed] = True
        return self if np.array_equal(off, self.crossed) else replace(self, crossed=off)

    @cached_property
    def open_parts(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Mark the nodes, faces and edges that are tested: all but those of faces that cross."""
        nodes = np.ones(len(self.areas), dtype=bool)
        nodes[self.faces[self.crossed]] = False
        return nodes, ~self.crossed, nodes[self.edges].any(axis=1)
