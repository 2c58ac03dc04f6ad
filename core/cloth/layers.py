"""Several garments worn one over the other in one mesh, each with its own fabric."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .fabric import Fabric
from .topology import FaceElements, HingeElements, Topology


@dataclass(frozen=True)
class Layer:
    """Describe which nodes, faces and hinges of a mesh are one garment, and its fabric."""

    fabric: Fabric
    nodes: slice
    faces: slice
    hinges: slice

    @property
    def stiffness(self) -> np.ndarray:
        """Return the membrane's four stiffnesses as its kernels take them [N/m]."""
        return np.array([self.fabric.H00, self.fabric.H01, self.fabric.H11, self.fabric.H22])

    def membrane_of(self, topology: Topology) -> FaceElements:
        """Return the garment's faces among those of the mesh, as the membrane's kernel takes them."""
        return FaceElements(*(part[self.faces] for part in topology.face_elements))

    def bending_of(self, topology: Topology) -> HingeElements:
        """Return the garment's hinges among those of the mesh, as the bending's kernel takes them."""
        return HingeElements(*(part[self.hinges] for part in topology.hinge_elements))


def stack_garments(topologies: Sequence[Topology], fabrics: Sequence[Fabric]) -> tuple[Topology, tuple[Layer, ...]]:
    """Return one mesh of several garments, numbered one after the other, and the `Layer` of each.

    Args:
        topologies: Mesh of each garment.
        fabrics: Fabric of each.
    """
    counts = np.array([[one.node_count, len(one.faces), len(one.hinges.nodes)] for one in topologies])
    ends = np.vstack([np.zeros((1, 3), dtype=np.int64), np.cumsum(counts, axis=0)])
    faces = np.concatenate([one.faces + first for one, (first, _, _) in zip(topologies, ends, strict=False)])
    rest = np.concatenate([one.rest.corners for one in topologies])
    angles = np.concatenate([one.hinges.angles for one in topologies])  # hinges go by the lower number of their nodes
    whole = Topology.from_mesh(faces, rest, int(ends[-1, 0]), angles)
    layers = tuple(
        Layer(fabric, *(slice(int(a), int(b)) for a, b in zip(ends[n], ends[n + 1], strict=True)))
        for n, fabric in enumerate(fabrics)
    )
    return whole, layers
