"""Parameters of a fit: control points of the pattern and parameters of the fabric."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix, hstack

from ..garment.control import ControlMap
from ..garment.curves import edge_length
from ..garment.garment import Garment
from ..garment.pattern import EdgeRef, Pattern
from ..garment.symmetry import Symmetry
from .scene import Scene
from .sensitivity import FABRIC_PARAMETERS, Sensitivity

__all__ = ["Parameters", "list_gathers", "map_rest"]


@dataclass(frozen=True)
class Parameters:
    """Describe how the rest shape and the fabric follow from a vector of parameters; the shape's come first.

        rest(p) = rest + shape p_shape,    value(p) = value exp(p_fabric)

    The fabric's are logarithms: values stay positive, and a step of 0.01 is one per cent of each.

    Attributes:
        shape: Rest corners [m] by shape parameter [m], shape [6 face_count, shape_count].
        fabric: Names out of `FABRIC_PARAMETERS`.
    """

    shape: csr_matrix
    fabric: tuple[str, ...] = ()

    @classmethod
    def of_garment(
        cls,
        garment: Garment,
        control: ControlMap,
        symmetry: Symmetry | None = None,
        fabric: tuple[str, ...] = (),
        gathers: Sequence[Sequence[EdgeRef]] = (),
    ) -> Parameters:
        """Return the parameters of a garment: all control points, or the effective ones of a symmetry, as x0, y0, x1,
        y1, ... [m], then the logarithm of each gather's ratio: the edges that it lengthens, mirror images together
        (`list_gathers`)."""
        points = map_rest(garment) @ control.matrix
        shape = [points if symmetry is None else points @ symmetry.matrix]
        for edges in gathers:
            motion = sum(stretch_edge(garment.pattern, edge) for edge in edges)
            shape.append(csr_matrix((points @ np.ravel(motion))[:, None]))
        return cls(csr_matrix(hstack(shape)), fabric)

    @property
    def count(self) -> int:
        """Return the number of parameters."""
        return int(self.shape.shape[1]) + len(self.fabric)

    def move(self, scene: Scene, step: np.ndarray) -> Scene:
        """Return the scene with its rest shape and fabric moved by a step, shape [count]."""
        step = np.asarray(step, dtype=np.float64)
        topology, first = scene.topology, self.shape.shape[1]
        if first:
            moved = topology.rest.corners + (self.shape @ step[:first]).reshape(topology.rest.corners.shape)
            topology = topology.reshape(moved)
        scaled = {
            n: getattr(scene.fabric, n) * float(np.exp(s)) for n, s in zip(self.fabric, step[first:], strict=True)
        }
        return replace(scene, topology=topology, fabric=replace(scene.fabric, **scaled))

    def rates(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Return the rates of the rest corners, [face_count, 3, 2, count], and of `FABRIC_PARAMETERS`, [6, count]."""
        first = self.shape.shape[1]
        rest = np.zeros((self.shape.shape[0], self.count))
        rest[:, :first] = self.shape.toarray()
        fabric = np.zeros((len(FABRIC_PARAMETERS), self.count))
        for n, name in enumerate(self.fabric):
            fabric[FABRIC_PARAMETERS.index(name), first + n] = getattr(scene.fabric, name)
        return rest.reshape(*scene.topology.rest.corners.shape, self.count), fabric

    def pull(self, scene: Scene, sensitivity: Sensitivity) -> np.ndarray:
        """Compute a number's derivative by the parameters, shape [count]."""
        scales = [getattr(scene.fabric, n) * sensitivity.fabric[FABRIC_PARAMETERS.index(n)] for n in self.fabric]
        return np.concatenate([self.shape.T @ sensitivity.rest.ravel(), scales])


def map_rest(garment: Garment) -> csr_matrix:
    """Return the linear map from uv (x0, y0, x1, ...) to the rest triangles of `Topology.from_garment`. Shape [6
    face_count, 2 uv_count]; each panel's grainline turns its warp to the second rest axis."""
    angles = np.array([panel.grainline for panel in garment.pattern.panels])[garment.panel_of_face]
    turn = np.stack([np.cos(angles), np.sin(angles), -np.sin(angles), np.cos(angles)], axis=1).reshape(-1, 1, 2, 2)
    values = np.broadcast_to(turn, (len(angles), 3, 2, 2))
    rows = np.broadcast_to(np.arange(6 * len(angles)).reshape(-1, 3, 2, 1), values.shape)
    columns = np.broadcast_to(2 * garment.uv_faces[:, :, None, None] + np.arange(2), values.shape)
    size = (6 * len(angles), 2 * len(garment.uv))
    return csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=size)


def list_gathers(pattern: Pattern, symmetry: Symmetry) -> tuple[tuple[EdgeRef, ...], ...]:
    """Return the gathered seams' longer edges, mirror images together: each group has one free ratio. The cloth of the
    longer edge of a gathered seam is gathered; the other edge keeps its length."""
    leader: dict[EdgeRef, EdgeRef] = {}
    for seam in pattern.seams:
        if seam.gathered:
            a, b = (edge_length(pattern.panel(ref.panel), ref.edge) for ref in (seam.a, seam.b))
            edge = seam.a if a >= b else seam.b
            leader[edge] = edge
    for edge in leader:
        for image in _mirror_images(pattern, symmetry, edge):
            if image in leader:
                leader = {other: leader[edge] if first == leader[image] else first for other, first in leader.items()}
    firsts = dict.fromkeys(leader.values())
    return tuple(tuple(edge for edge in leader if leader[edge] == first) for first in firsts)


def _mirror_images(pattern: Pattern, symmetry: Symmetry, edge: EdgeRef) -> list[EdgeRef]:
    """Return the images of an edge under the mirrors that start from its panel."""
    found = []
    for mirror in symmetry.mirrors:
        count = len(mirror.order)
        if pattern.panels[mirror.source].name == edge.panel:
            # A mirror image has the reverse direction: it begins with the image of the edge's end.
            end = (edge.edge + 1) % count
            first = int(np.flatnonzero(mirror.order == end)[0])
            found.append(EdgeRef(pattern.panels[mirror.target].name, first))
    return found


def stretch_edge(pattern: Pattern, edge: EdgeRef) -> np.ndarray:
    """Return the motion of control points that lengthens one edge about its middle, shape [point_count, 2]. It is a
    column of `Parameters.shape`: d length / d step = length, the step being the logarithm of a gathered seam's
    ratio."""
    index = [panel.name for panel in pattern.panels].index(edge.panel)
    first, count = int(pattern.point_starts[index]), len(pattern.panels[index].points)
    start, end = first + edge.edge, first + (edge.edge + 1) % count
    motion = np.zeros_like(pattern.points)
    half = 0.5 * (pattern.points[end] - pattern.points[start])
    motion[start], motion[end] = -half, half
    return motion
