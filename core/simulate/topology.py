"""What never changes while a mesh deforms: rest shape, hinges, and where each element's numbers go."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from ..errors import BadInput
from ..mesh import HalfEdges, lump, shape_gradients, signed_areas
from ..pattern import Garment


class TopologyBad(BadInput):
    """The cloth mesh cannot be simulated; repair its faces and try again."""

    code = "simulate.topology_bad"


@dataclass(frozen=True)
class Topology:
    """Hold a cloth mesh's rest shape and its static assembly map (thesis 3.2.4.3); built once per mesh.

    **Deviation**: the thesis multiplies a sparse mapping matrix with the stack of element Jacobians. On one CPU core it
    is quicker to let each element add its 3x3 blocks straight to their fixed slots, in a fixed order.

    Attributes:
        node_count: Nodes in 3D.
        faces: Node indices, shape [face_count, 3].
        rest: Flat rest triangles, weft along the first axis, warp along the second [m], shape [face_count, 3, 2].
        shape_gradients: Gradients of the three linear shape functions at rest [1/m], shape [face_count, 3, 2].
        areas: Rest areas [m2], shape [face_count].
        node_areas: A third of the area of the faces around each node [m2], shape [node_count].
        hinges: Nodes (start, end, opposite in the first face, opposite in the second), shape [hinge_count, 4].
        hinge_faces: The two faces of each hinge, shape [hinge_count, 2].
        hinge_scale: |e|^2 / (A1 + A2) at rest (eq. 3.4), |e|^2 the mean of both sides', shape [hinge_count].
        hinge_rest: Rest angle between the two normals [rad], shape [hinge_count].
        face_slots: Block that each of a face's 6 upper blocks adds to; ~slot where it adds transposed, [face_count, 6].
        hinge_slots: The same for the 10 upper blocks of a hinge, shape [hinge_count, 10].
        diagonal: Slot of each node's diagonal block, shape [node_count].
        block_rows, block_columns: Node pair (row <= column) of each block, shape [block_count].
        block_places: Where the block and its transpose start in the matrix's data, shape [block_count, 2].
        row_stride: Entries in each scalar row of a node, shape [node_count].
        indptr, indices: Pattern of the symmetric scalar matrix of 3 node_count rows (its CSC is its CSR).
    """

    node_count: int
    faces: np.ndarray
    rest: np.ndarray
    shape_gradients: np.ndarray
    areas: np.ndarray
    node_areas: np.ndarray
    hinges: np.ndarray
    hinge_faces: np.ndarray
    hinge_scale: np.ndarray
    hinge_rest: np.ndarray
    face_slots: np.ndarray
    hinge_slots: np.ndarray
    diagonal: np.ndarray
    block_rows: np.ndarray
    block_columns: np.ndarray
    block_places: np.ndarray
    row_stride: np.ndarray
    indptr: np.ndarray
    indices: np.ndarray

    @classmethod
    def from_garment(cls, garment: Garment) -> Topology:
        """Build the topology of a garment; each panel's grainline turns its warp to the second rest axis."""
        angles = np.array([panel.grainline for panel in garment.pattern.panels])[garment.panel_of_face]
        cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
        u, v = garment.rest[..., 0], garment.rest[..., 1]
        rest = np.stack([cos * u + sin * v, -sin * u + cos * v], axis=-1)
        return cls.from_mesh(garment.faces, rest, len(garment.nodes))

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
        shape_gradients, areas = _rest_shape(rest)
        node_areas = lump(areas, faces, count)
        edges = HalfEdges.of(faces, count)
        hinges, hinge_faces = edges.hinge_vertices, edges.hinges // 3
        edge = _hinge_edges(rest, hinge_faces, edges.hinges % 3)
        scale = (edge**2).sum(-1).mean(0) / areas[hinge_faces].sum(1)
        angles = np.zeros(len(hinges)) if rest_angles is None else np.asarray(rest_angles, dtype=np.float64)
        return cls(
            count, faces, np.ascontiguousarray(rest, dtype=np.float64), shape_gradients, areas, node_areas, hinges,
            hinge_faces, scale, angles, *_map_blocks(count, faces, hinges),
        )  # fmt: skip

    @property
    def hinge_corners(self) -> np.ndarray:
        """Give the corner at which each hinge's edge starts in each of its two faces, shape [hinge_count, 2]."""
        opposite = self.faces[self.hinge_faces] == self.hinges[:, 2:, None]
        return (opposite.argmax(2) + 1) % 3

    @property
    def hinge_edges(self) -> np.ndarray:
        """Give each hinge's edge in the flat triangles of both its faces [m], shape [2, hinge_count, 2]."""
        return _hinge_edges(self.rest, self.hinge_faces, self.hinge_corners)

    def reshape(self, rest: np.ndarray) -> Topology:
        """Give the same mesh with other flat rest triangles [m], shape [face_count, 3, 2]; solvers stay valid.

        Raises:
            TopologyBad: where a face has no area.
        """
        rest = np.ascontiguousarray(rest, dtype=np.float64)
        shape_gradients, areas = _rest_shape(rest)
        node_areas = lump(areas, self.faces, self.node_count)
        edge = _hinge_edges(rest, self.hinge_faces, self.hinge_corners)
        scale = (edge**2).sum(-1).mean(0) / areas[self.hinge_faces].sum(1)
        return replace(
            self, rest=rest, shape_gradients=shape_gradients, areas=areas, node_areas=node_areas, hinge_scale=scale
        )

    def assemble(self, blocks: np.ndarray, fixed: np.ndarray) -> np.ndarray:
        """Spread blocks [block_count, 3, 3] to the matrix's data; fixed nodes get the identity."""
        data = np.zeros(len(self.indices))
        _spread(blocks, self.block_rows, self.block_columns, self.block_places, self.row_stride, fixed, data)
        return data


def _rest_shape(rest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Compute shape gradients and areas of flat triangles; refuse those that have none."""
    areas = np.abs(signed_areas(rest))
    longest = ((rest[:, 1:] - rest[:, :1]) ** 2).sum(2).max(1)
    # 1e-4: a height under 1e-4 of the longest edge; its stiffness would drown the rest of the matrix in round-off
    if not np.isfinite(areas).all() or (2.0 * areas <= 1e-4 * longest).any():
        raise TopologyBad("a face of the flat pattern has no area; mesh the panel again.")
    return shape_gradients(rest), areas


def _hinge_edges(rest: np.ndarray, hinge_faces: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """Give the flat edge of each hinge on both sides, shape [2, hinge_count, 2]."""
    return np.stack(
        [rest[hinge_faces[:, s], (corner[:, s] + 1) % 3] - rest[hinge_faces[:, s], corner[:, s]] for s in (0, 1)]
    )


def _map_blocks(count: int, faces: np.ndarray, hinges: np.ndarray) -> tuple[np.ndarray, ...]:
    """Number the distinct node pairs and place their 3x3 blocks in one symmetric matrix."""
    of_face = [(a, b) for a in range(3) for b in range(a, 3)]
    of_hinge = [(a, b) for a in range(4) for b in range(a, 4)]
    rows = np.concatenate([faces[:, [a for a, _ in of_face]].ravel(), hinges[:, [a for a, _ in of_hinge]].ravel()])
    columns = np.concatenate([faces[:, [b for _, b in of_face]].ravel(), hinges[:, [b for _, b in of_hinge]].ravel()])
    rows, columns = np.concatenate([rows, np.arange(count)]), np.concatenate([columns, np.arange(count)])
    turned = rows > columns
    low, high = np.where(turned, columns, rows), np.where(turned, rows, columns)
    keys, slots = np.unique(low * count + high, return_inverse=True)
    slots = np.where(turned, ~slots, slots)
    face_slots = slots[: 6 * len(faces)].reshape(-1, 6)
    hinge_slots = slots[6 * len(faces) : 6 * len(faces) + 10 * len(hinges)].reshape(-1, 10)
    block_rows, block_columns = keys // count, keys % count
    upper = block_rows < block_columns
    # every block of the full matrix, in row order: the upper ones, and the transposes of those off the diagonal
    full_rows = np.concatenate([block_rows, block_columns[upper]])
    full_columns = np.concatenate([block_columns, block_rows[upper]])
    order = np.lexsort((full_columns, full_rows))
    degree = np.bincount(full_rows, minlength=count)
    first = np.concatenate([[0], np.cumsum(degree)])
    place = np.zeros(len(order), dtype=np.int64)
    position = np.arange(len(order)) - first[full_rows[order]]
    place[order] = 9 * first[full_rows[order]] + 3 * position
    places = np.stack([place[: len(keys)], place[: len(keys)]], axis=1)
    places[upper, 1] = place[len(keys) :]
    stride = 3 * degree
    indptr = np.concatenate([[0], np.cumsum(np.repeat(stride, 3))])
    row_of_entry = np.repeat(np.arange(3 * count), np.repeat(stride, 3))
    offset = np.arange(indptr[-1]) - indptr[row_of_entry]
    indices = 3 * full_columns[order][first[row_of_entry // 3] + offset // 3] + offset % 3
    diagonal = np.flatnonzero(~upper)
    return (face_slots, hinge_slots, diagonal, block_rows, block_columns, places, stride,
            indptr.astype(np.int32), indices.astype(np.int32))  # fmt: skip


@njit(cache=True)
def _spread(blocks, rows, columns, places, stride, fixed, data):  # type: ignore[no-untyped-def]
    """Copy each block and its transpose to their places in the scalar matrix."""
    for b in range(len(rows)):
        i, j = rows[b], columns[b]
        here, there = places[b, 0], places[b, 1]
        if fixed[i] or fixed[j]:
            if i == j:
                for d in range(3):
                    data[here + d * stride[i] + d] = 1.0
            continue
        for d in range(3):
            for e in range(3):
                value = blocks[b, d, e]
                data[here + d * stride[i] + e] = value
                if i != j:
                    data[there + e * stride[j] + d] = value


@njit(cache=True, inline="always")
def add_block(blocks, slot, block):  # type: ignore[no-untyped-def]
    """Add a 3x3 block to its slot, transposed where the slot says so."""
    if slot >= 0:
        for d in range(3):
            for e in range(3):
                blocks[slot, d, e] += block[d, e]
    else:
        for d in range(3):
            for e in range(3):
                blocks[~slot, e, d] += block[d, e]
