"""Connectivity of a triangle mesh: half-edges, edges, twins, borders, hinges and connected pieces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


@dataclass(frozen=True, eq=False)
class HalfEdges:
    """Number the directed edges of all faces: half-edge 3 f + k runs from corner k to corner (k + 1) % 3 of face f.

    Half-edge h is opposite the corner at which half-edge `3 f + (k + 2) % 3` starts. Arrays are computed on first use.

    Attributes:
        faces: Vertex indices, shape [face_count, 3].
        vertex_count: Vertices of the mesh; some may be in no face.
    """

    faces: np.ndarray
    vertex_count: int

    @classmethod
    def of(cls, faces: np.ndarray, vertex_count: int | None = None) -> HalfEdges:
        """Number the half-edges of faces [face_count, 3]; the default count ends with the last vertex used."""
        faces = np.asarray(faces, dtype=np.int64).reshape(-1, 3)
        return cls(faces, int(faces.max(initial=-1)) + 1 if vertex_count is None else int(vertex_count))

    @cached_property
    def tail(self) -> np.ndarray:
        """Return the vertex at which each half-edge starts, shape [3 face_count]."""
        return self.faces.ravel()

    @cached_property
    def head(self) -> np.ndarray:
        """Return the vertex at which each half-edge ends, shape [3 face_count]."""
        return np.roll(self.faces, -1, axis=1).ravel()

    @cached_property
    def opposite(self) -> np.ndarray:
        """Return the vertex of the face that each half-edge does not touch, shape [3 face_count]."""
        return np.roll(self.faces, -2, axis=1).ravel()

    @cached_property
    def following(self) -> np.ndarray:
        """Return the next half-edge around the face, shape [3 face_count]."""
        return np.arange(self.faces.size).reshape(-1, 3)[:, [1, 2, 0]].ravel()

    @cached_property
    def edge(self) -> np.ndarray:
        """Return the undirected edge of each half-edge, shape [3 face_count]."""
        return self._edges[1]

    @cached_property
    def edges(self) -> np.ndarray:
        """Return the ends of each edge, lower vertex first, in lexicographic order, shape [edge_count, 2]."""
        return self._edges[0]

    @cached_property
    def face_counts(self) -> np.ndarray:
        """Return the number of faces at each edge, shape [edge_count]: 1 on a border, more than 2 where sheets meet."""
        return np.bincount(self.edge, minlength=len(self.edges))

    @cached_property
    def border(self) -> np.ndarray:
        """Return the half-edges of edges that only one face has, ascending, shape [border_count]."""
        return np.flatnonzero(self.face_counts[self.edge] == 1)

    @cached_property
    def border_vertices(self) -> np.ndarray:
        """Mark the vertices at the ends of border edges, shape [vertex_count]."""
        found = np.zeros(self.vertex_count, dtype=bool)
        found[self.tail[self.border]] = found[self.head[self.border]] = True
        return found

    @cached_property
    def pairs(self) -> np.ndarray:
        """Return the half-edges of each edge of exactly two faces, the lower first, by edge, shape [pair_count, 2]."""
        starts = np.cumsum(self.face_counts) - self.face_counts
        first = starts[self.face_counts == 2]
        return np.stack([self._by_edge[first], self._by_edge[first + 1]], axis=1)

    @cached_property
    def opposed(self) -> np.ndarray:
        """Mark the `pairs` with opposite directions, those of faces of consistent orientation, shape [pair_count]."""
        found: np.ndarray = self.tail[self.pairs[:, 0]] == self.head[self.pairs[:, 1]]
        return found

    @cached_property
    def twin(self) -> np.ndarray:
        """Return the half-edge of the face across, shape [3 face_count]; -1 on a border, at an edge of three or more
        faces, and where two faces disagree on the edge's direction."""
        twin = np.full(self.faces.size, -1)
        first, second = self.pairs[self.opposed].T
        twin[first], twin[second] = second, first
        return twin

    @cached_property
    def hinges(self) -> np.ndarray:
        """Return the pairs of half-edges about which two faces bend, by edge, shape [hinge_count, 2]. An edge of n
        faces has n - 1 hinges, between consecutive faces, so that a seam of three sheets bends. Two faces over the same
        three vertices have no angle, and no hinge."""
        same = self.edge[self._by_edge][1:] == self.edge[self._by_edge][:-1]
        found = np.stack([self._by_edge[:-1][same], self._by_edge[1:][same]], axis=1)
        turning: np.ndarray = found[self.opposite[found[:, 0]] != self.opposite[found[:, 1]]]
        return turning

    @cached_property
    def hinge_vertices(self) -> np.ndarray:
        """Return start and end of each hinge in its first face, and the opposite corners, shape [hinge_count, 4]."""
        first, second = self.hinges.T
        ends = (self.tail[first], self.head[first], self.opposite[first], self.opposite[second])
        return np.ascontiguousarray(np.stack(ends, axis=1))

    @cached_property
    def face_pieces(self) -> tuple[int, np.ndarray]:
        """Return the number of sheets, joined across `pairs`, and the sheet of each face, shape [face_count]."""
        return find_components(len(self.faces), self.pairs[:, 0] // 3, self.pairs[:, 1] // 3)

    @cached_property
    def vertex_pieces(self) -> tuple[int, np.ndarray]:
        """Return the number of connected sets of vertices, and the set of each, shape [vertex_count]."""
        return find_components(self.vertex_count, self.tail, self.head)

    @cached_property
    def adjacency(self) -> csr_matrix:
        """Return the symmetric matrix with 1 for each edge, shape [vertex_count, vertex_count]."""
        return adjacency_matrix(self.edges, self.vertex_count)

    @cached_property
    def _edges(self) -> tuple[np.ndarray, np.ndarray]:
        base, order = max(self.vertex_count, 1), self._by_edge
        keys = self._keys[order]
        first = np.r_[True, keys[1:] != keys[:-1]][: len(keys)]
        edge = np.zeros(len(keys), dtype=np.int64)
        edge[order] = np.cumsum(first) - 1
        keys = keys[first]
        return np.stack([keys // base, keys % base], axis=1), edge

    @cached_property
    def _by_edge(self) -> np.ndarray:
        """Return the half-edges ordered by edge, then by their own number."""
        return np.argsort(self._keys, kind="stable")

    @cached_property
    def _keys(self) -> np.ndarray:
        """Return a key of each half-edge that orders undirected edges by their ends, shape [3 face_count]."""
        found: np.ndarray = np.minimum(self.tail, self.head) * max(self.vertex_count, 1) + np.maximum(
            self.tail, self.head
        )
        return found


def find_components(count: int, first: np.ndarray, second: np.ndarray) -> tuple[int, np.ndarray]:
    """Label nodes by their connected component.

    Args:
        count: Number of nodes.
        first, second: The ends of each link, shape [link_count].

    Returns:
        Number of components, and the component of each node, numbered by their first nodes, shape [count].
    """
    from .disjoint_sets import label_components  # imported here, for few of those who import this need compiled code

    labels = np.zeros(count, dtype=np.int32)
    number = label_components(np.ascontiguousarray(first, np.int64), np.ascontiguousarray(second, np.int64), labels)
    return int(number), labels


def shortest_paths(
    edges: HalfEdges, lengths: np.ndarray, start: np.ndarray, limit: float = np.inf
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Compute the shortest path along edges to each vertex from the nearest of some (Dijkstra).

    Args:
        edges: The mesh.
        lengths: Of its undirected edges [m], positive, shape [edge_count].
        start: Indices of the vertices at which paths begin, at least one.
        limit: Longest path [m].

    Returns:
        The path's length [m], infinite beyond the limit; the vertex before the last; and the one at which it begins,
        both negative where there is none; shape [vertex_count] each.
    """
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import dijkstra

    count = edges.vertex_count
    graph = csr_matrix((lengths, tuple(edges.edges.T)), shape=(count, count))
    found = dijkstra(graph, directed=False, indices=start, min_only=True, limit=limit, return_predecessors=True)
    return found[0], found[1], found[2]


def adjacency_matrix(edges: np.ndarray, count: int) -> csr_matrix:
    """Return the symmetric matrix with 1 for each undirected edge [edge_count, 2], shape [count, count]."""
    from scipy.sparse import csr_matrix

    both = np.concatenate([edges, edges[:, ::-1]])
    return csr_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(count, count))
