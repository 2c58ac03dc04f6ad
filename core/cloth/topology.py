"""Constants of a deforming mesh: its rest shape, its hinges and the pattern of its matrix."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..garment.creases import crease_angles
from ..garment.garment import Garment
from ..geometry.connectivity import HalfEdges
from ..geometry.geometry import lump, shape_gradients, signed_areas
from ..run.errors import BadInput
from .block_pattern import BlockPattern

__all__ = ["RestShape", "Topology", "TopologyBad"]

MIN_TRIANGLE_HEIGHT_SHARE = 1e-4
"""Smallest height of a flat triangle as a share of its longest edge. A lower one is so stiff that the rest of the
matrix is lost in round-off."""


class TopologyBad(BadInput):
    """The cloth mesh cannot be simulated; repair its faces and try again."""

    code = "simulate.topology_bad"


class FaceElements(NamedTuple):
    """Faces as the membrane's kernel takes them: nodes, gradients of the shape functions, areas and block slots."""

    nodes: np.ndarray
    shape: np.ndarray
    areas: np.ndarray
    slots: np.ndarray


class HingeElements(NamedTuple):
    """Hinges as the bending's kernel takes them: nodes, scale, rest angle and block slots; see `Hinges`."""

    nodes: np.ndarray
    scale: np.ndarray
    angles: np.ndarray
    slots: np.ndarray


@dataclass(frozen=True)
class RestShape:
    """Describe the flat triangles of a cloth.

    Attributes:
        corners: Weft along the first axis, warp along the second [m], shape [face_count, 3, 2].
        gradients: Gradients of the three linear shape functions [1/m], shape [face_count, 3, 2].
        areas: Areas [m2], shape [face_count].
        node_areas: A third of the area of the faces around each node [m2], shape [node_count].
    """

    corners: np.ndarray
    gradients: np.ndarray
    areas: np.ndarray
    node_areas: np.ndarray

    @classmethod
    def of(cls, corners: np.ndarray, faces: np.ndarray, node_count: int) -> RestShape:
        """Compute the rest shape of flat triangles [m], shape [face_count, 3, 2], of faces [face_count, 3].

        Raises:
            TopologyBad: where a face has no area.
        """
        corners = np.ascontiguousarray(corners, dtype=np.float64)
        areas = signed_areas(corners)
        sides = corners[:, 1:] - corners[:, :1]
        # `not`, so that a NaN area is refused too
        if not (2.0 * np.abs(areas) > MIN_TRIANGLE_HEIGHT_SHARE * (sides**2).sum(2).max(1)).all():
            raise TopologyBad("a face of the flat pattern has no area; mesh the panel again.")
        areas = np.abs(areas)
        return cls(corners, shape_gradients(corners), areas, lump(areas, faces, node_count))


@dataclass(frozen=True)
class Hinges:
    """Describe the edges about which two faces turn against each other.

    Attributes:
        nodes: Start, end, opposite in the first face, opposite in the second, shape [hinge_count, 4].
        faces: The two faces, shape [hinge_count, 2].
        corners: The corner of each face at which the edge starts, shape [hinge_count, 2].
        angles: Rest angle between the two normals [rad], shape [hinge_count].
    """

    nodes: np.ndarray
    faces: np.ndarray
    corners: np.ndarray
    angles: np.ndarray

    @classmethod
    def of(cls, faces: np.ndarray, node_count: int, angles: np.ndarray | None = None) -> Hinges:
        """Find the hinges of faces [face_count, 3]; their rest angles [rad] are zero where None."""
        found = HalfEdges.of(faces, node_count)
        at, corners = found.hinges // 3, found.hinges % 3
        angles = np.zeros(len(at)) if angles is None else np.asarray(angles, dtype=np.float64)
        return cls(found.hinge_vertices, at, corners, angles)

    def edges(self, rest: RestShape) -> np.ndarray:
        """Return each hinge's edge in the flat triangles of both its faces [m], shape [2, hinge_count, 2]."""
        flat = rest.corners
        return np.stack([flat[f, (c + 1) % 3] - flat[f, c] for f, c in zip(self.faces.T, self.corners.T, strict=True)])

    def scale(self, rest: RestShape) -> np.ndarray:
        """Return |e|^2 / (A1 + A2) (eq. 3.4), |e|^2 the mean of both sides', shape [hinge_count]."""
        return np.asarray((self.edges(rest) ** 2).sum(-1).mean(0) / rest.areas[self.faces].sum(1))


@dataclass(frozen=True)
class Topology:
    """Describe a cloth mesh: the nodes that its elements couple, its rest shape and its hinges.

    Attributes:
        faces: Node indices, shape [face_count, 3].
        pattern: Sparsity of its matrix.
        face_slots: Slots of each face's 6 upper blocks, shape [face_count, 6]; see `BlockPattern.of`.
        hinge_slots: The same for the 10 of a hinge, shape [hinge_count, 10].
        hinge_scale: |e|^2 / (A1 + A2) at rest, shape [hinge_count].
    """

    faces: np.ndarray
    pattern: BlockPattern
    rest: RestShape
    hinges: Hinges
    face_slots: np.ndarray
    hinge_slots: np.ndarray
    hinge_scale: np.ndarray

    @classmethod
    def from_garment(cls, garment: Garment) -> Topology:
        """Build the topology of a garment; each panel's grainline turns its warp to the second rest axis, and creases
        are turned at rest."""
        angles = np.array([panel.grainline for panel in garment.pattern.panels])[garment.panel_of_face]
        cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
        u, v = garment.rest[..., 0], garment.rest[..., 1]
        rest = np.stack([cos * u + sin * v, -sin * u + cos * v], axis=-1)
        return cls.from_mesh(garment.faces, rest, len(garment.nodes), crease_angles(garment))

    @classmethod
    def from_mesh(
        cls, faces: np.ndarray, rest: np.ndarray, node_count: int | None = None, rest_angles: np.ndarray | None = None
    ) -> Topology:
        """Build a topology from faces [face_count, 3] and their flat rest triangles [m], shape [face_count, 3, 2].

        Raises:
            TopologyBad: where a face is degenerate or points outside the nodes.
        """
        faces = np.ascontiguousarray(faces, dtype=np.int64)
        count = int(faces.max(initial=-1)) + 1 if node_count is None else int(node_count)
        if faces.ndim != 2 or faces.shape[1:] != (3,) or not len(faces):
            raise TopologyBad("the cloth has no triangles.")
        if faces.min() < 0 or faces.max() >= count:
            raise TopologyBad("a face of the cloth points at a node that does not exist.")
        shape, hinges = RestShape.of(rest, faces, count), Hinges.of(faces, count, rest_angles)
        pattern, slots = BlockPattern.of(count, faces, hinges.nodes)
        return cls(faces, pattern, shape, hinges, slots[0], slots[1], hinges.scale(shape))

    @property
    def node_count(self) -> int:
        """Return the number of nodes in 3D."""
        return self.pattern.node_count

    @property
    def face_elements(self) -> FaceElements:
        """Return the faces as the membrane's kernel takes them."""
        return FaceElements(self.faces, self.rest.gradients, self.rest.areas, self.face_slots)

    @property
    def hinge_elements(self) -> HingeElements:
        """Return the hinges as the bending's kernel takes them."""
        return HingeElements(self.hinges.nodes, self.hinge_scale, self.hinges.angles, self.hinge_slots)

    def reshape(self, rest: np.ndarray) -> Topology:
        """Return the same mesh with other flat rest triangles [m], shape [face_count, 3, 2]; solvers stay valid.

        Raises:
            TopologyBad: where a face has no area.
        """
        shape = RestShape.of(rest, self.faces, self.node_count)
        return replace(self, rest=shape, hinge_scale=self.hinges.scale(shape))

    def couple(self, nodes: np.ndarray) -> Topology:
        """Return the same mesh whose matrix also couples groups of nodes, shape [count, k]; it needs a new solver."""
        pattern, slots = BlockPattern.of(self.node_count, self.faces, self.hinges.nodes, nodes)
        return replace(self, pattern=pattern, face_slots=slots[0], hinge_slots=slots[1])

    def assemble(self, blocks: np.ndarray, fixed: np.ndarray) -> np.ndarray:
        """Return the matrix's data from its blocks [block_count, 3, 3]; fixed nodes get the identity."""
        return self.pattern.assemble(blocks, fixed)
