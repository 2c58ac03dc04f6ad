"""Transfer skinning weights to a person's mesh from the model that was fitted to it."""

from __future__ import annotations

import numpy as np

from ..geometry.connectivity import HalfEdges, adjacency_matrix
from ..geometry.geometry import vertex_normals
from ..geometry.linear import factor_symmetric
from ..geometry.surface import TriangleSurface

SAME_PART_COSINE = 0.5
"""Cosine between the normals of a vertex and of the model's nearest skin above which both are of one part. Between
thighs that touch, the nearest skin is often the other thigh's (a fit is within 3 mm), with opposite normal; with its
weights the vertex would follow the wrong leg."""


def transfer_weights(
    vertices: np.ndarray, faces: np.ndarray, model: np.ndarray, model_faces: np.ndarray, weights: np.ndarray
) -> np.ndarray:
    """Compute the skinning weights of a mesh from those of a model close to it, shape [vertex_count, joints].

    Each vertex takes the weights of the model's nearest point where both face the same way; others are interpolated.

    Args:
        vertices: The mesh in the model's pose [m], shape [vertex_count, 3].
        faces: Outward, shape [face_count, 3].
        model: Vertices of the model [m], shape [model_count, 3].
        model_faces: Outward, shape [model_face_count, 3].
        weights: Of the model, rows sum to 1, shape [model_count, joints].
    """
    found = TriangleSurface(model, model_faces).closest(vertices)
    corners = model_faces[found.face]
    taken = np.einsum("nk,nkj->nj", found.barycentric, weights[corners])
    taken /= taken.sum(axis=1, keepdims=True)
    outward = np.einsum("nk,nkd->nd", found.barycentric, vertex_normals(model, model_faces)[corners])
    cosine = (vertex_normals(vertices, faces) * outward).sum(axis=1) / np.linalg.norm(outward, axis=1)
    return _fill(taken, ~(cosine >= SAME_PART_COSINE), faces)


def _fill(values: np.ndarray, unknown: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return values [n, k] with the unknown ones harmonic between the known; parts without any known do not change."""
    from scipy.sparse import diags
    from scipy.sparse.csgraph import connected_components

    beside = adjacency_matrix(HalfEdges.of(faces, len(values)).edges, len(values))
    part = connected_components(beside, directed=False)[1]
    lost = np.bincount(part, weights=~unknown) == 0
    inner = np.flatnonzero(unknown & ~lost[part])
    if not len(inner):
        return values
    rows = (diags(np.asarray(beside.sum(axis=1)).ravel()) - beside).tocsr()[inner]
    known = np.setdiff1d(np.arange(len(values)), inner)
    filled = values.copy()
    filled[inner] = factor_symmetric(rows[:, inner]).solve(-(rows[:, known] @ values[known]))
    found: np.ndarray = filled / filled.sum(axis=1, keepdims=True)
    return found
