"""Sparse operators of a triangle mesh: gradients on the rest triangles, incidence, hinges, normals, borders."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp


def gradient_operator(rest: np.ndarray, faces: np.ndarray, node_count: int) -> tuple[sp.csr_matrix, np.ndarray]:
    """Build the operator from positions to 3x2 Jacobians in each face's rest frame.

    Row 2 f + k of `G @ x` is the derivative of x along axis k of face f's flat rest triangle, so that the 3x2
    deformation gradient of f is `(G @ x)[2 f : 2 f + 2].T`.

    Args:
        rest: Flat rest triangles [m], shape [face_count, 3, 2].
        faces: Node indices, shape [face_count, 3].
        node_count: Number of nodes.

    Returns:
        The operator, shape [2 face_count, node_count], and the rest areas [m2], shape [face_count].
    """
    edges = np.stack([rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]], axis=2)
    determinant = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    longest = np.maximum((edges**2).sum((1, 2)), 1e-12)
    # a degenerate rest triangle gets the inverse of a tiny one, not infinity; its area makes its weight vanish
    floor = 1e-6 * longest
    safe = np.where(np.abs(determinant) > floor, determinant, np.where(determinant < 0, -floor, floor))
    inverse = (
        np.stack([edges[:, 1, 1], -edges[:, 0, 1], -edges[:, 1, 0], edges[:, 0, 0]], axis=1).reshape(-1, 2, 2)
        / safe[:, None, None]
    )
    second, third = inverse[:, 0], inverse[:, 1]
    values = np.stack([-second - third, second, third], axis=2)
    rows = np.repeat(np.arange(2 * len(faces)), 3)
    columns = np.repeat(faces, 2, axis=0).reshape(-1)
    operator = sp.csr_matrix((values.reshape(-1), (rows, columns)), shape=(2 * len(faces), node_count))
    return operator, np.abs(determinant) / 2


def incidence(faces: np.ndarray, node_count: int) -> sp.csr_matrix:
    """Build the 0/1 matrix that sums face values at nodes, shape [node_count, face_count]."""
    columns = np.repeat(np.arange(len(faces)), 3)
    return sp.csr_matrix((np.ones(faces.size), (faces.reshape(-1), columns)), shape=(node_count, len(faces)))


def face_vectors(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Give each face's normal times twice its area [m2], shape [face_count, 3]."""
    corner = nodes[faces]
    return np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])


def unit(vectors: np.ndarray) -> np.ndarray:
    """Scale vectors to length 1; a zero vector stays zero."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)


def vertex_normals(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Give unit vertex normals weighted by area, shape [node_count, 3]."""
    return unit(incidence(faces, len(nodes)) @ face_vectors(nodes, faces))


def vertex_areas(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Give each vertex a third of its faces' area [m2], shape [node_count]."""
    return incidence(faces, len(nodes)) @ (np.linalg.norm(face_vectors(nodes, faces), axis=1) / 6)


def half_edges(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give all directed edges [3 face_count, 2] and the face of each; edge 3 f + k lies opposite corner k of face f."""
    directed = np.stack([faces[:, [1, 2]], faces[:, [2, 0]], faces[:, [0, 1]]], axis=1).reshape(-1, 2)
    return directed, np.repeat(np.arange(len(faces)), 3)


def twins(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pair the half-edges of edges with exactly two faces and list those of edges with one.

    Returns:
        Half-edge pairs, shape [inner_count, 2], and border half-edges, shape [border_count].
    """
    directed, _ = half_edges(faces)
    low, high = directed.min(axis=1), directed.max(axis=1)
    order = np.lexsort((high, low))
    key = np.stack([low[order], high[order]], axis=1)
    start = np.flatnonzero(np.r_[True, np.any(key[1:] != key[:-1], axis=1)])
    count = np.diff(np.r_[start, len(order)])
    inner = start[count == 2]
    return np.stack([order[inner], order[inner + 1]], axis=1), order[start[count == 1]]


def hinges(faces: np.ndarray) -> np.ndarray:
    """List inner edges as (node, node, face, face), directed as in the first face, shape [hinge_count, 4]."""
    directed, owner = half_edges(faces)
    pairs, _ = twins(faces)
    return np.concatenate([directed[pairs[:, 0]], owner[pairs]], axis=1)


def border_edges(faces: np.ndarray) -> np.ndarray:
    """List edges with one face, directed as in that face, shape [border_count, 2]."""
    directed, _ = half_edges(faces)
    return directed[twins(faces)[1]]
