"""Lengths, areas, normals, derivatives and curvatures of triangle meshes, each defined once.

Faces are oriented: seen from outside, their corners run counter-clockwise. A flat rest triangle has the corners p_0,
p_1, p_2 in the plane, with an origin of its own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .connectivity import HalfEdges

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

MIN_TRIANGLE_AREA_RATIO = 1e-6
"""Smallest ratio of a triangle's double area to the sum of its two squared sides; shape gradients of flatter triangles
are those at this ratio, so that they are finite."""


def area_vectors(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Compute each face's area times its unit normal [m2], (x_1 - x_0) x (x_2 - x_0) / 2, shape [face_count, 3]."""
    origin = vertices[faces[:, 0]]
    return 0.5 * _cross(vertices[faces[:, 1]] - origin, vertices[faces[:, 2]] - origin)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Compute a x b of rows, shape [n, 3], bit for bit as `np.cross`, for millions in a fifth of the time."""
    found = np.zeros_like(a)
    for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        found[:, k] = a[:, i] * b[:, j] - a[:, j] * b[:, i]
    return found


def face_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Compute the area of each face [m2], shape [face_count]."""
    return np.asarray(np.linalg.norm(area_vectors(vertices, faces), axis=1))


def face_normals(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Compute unit face normals, 0 for a face without area, shape [face_count, 3], and areas [m2]."""
    vectors = area_vectors(vertices, faces)
    areas = np.linalg.norm(vectors, axis=1)
    normals = np.divide(vectors, areas[:, None], out=np.zeros_like(vectors), where=areas[:, None] > 0.0)
    return normals, areas


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Compute unit vertex normals, the sum of `area_vectors` around each, or 0; shape [vertex_count, 3]."""
    vectors, corners = area_vectors(vertices, faces), faces.T.ravel()
    total = [np.bincount(corners, np.tile(column, 3), len(vertices)) for column in vectors.T]
    return unit(np.stack(total, axis=1))


def unit(vectors: np.ndarray) -> np.ndarray:
    """Scale vectors [..., d] to length 1; a zero vector stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


def edge_lengths(vertices: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the lengths of edges [m], shape [edge_count], from their ends, shape [edge_count, 2]."""
    return np.asarray(np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1))


def lump(areas: np.ndarray, faces: np.ndarray, count: int) -> np.ndarray:
    """Distribute a value of each face, such as its area, to its three corners; return the sums, shape [count]."""
    return np.bincount(faces.ravel(), np.repeat(areas / 3, 3), minlength=count)


def vertex_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Compute the area of each vertex [m2]: a third of that of the faces around it, shape [vertex_count]."""
    return lump(face_areas(vertices, faces), faces, len(vertices))


def signed_areas(flat: np.ndarray) -> np.ndarray:
    """Compute the areas of triangles in the plane, (p_1 - p_0) x (p_2 - p_0) / 2, shape [face_count].

    Args:
        flat: Corners [m], shape [face_count, 3, 2]; counter-clockwise ones have a positive area.
    """
    p, q = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    return np.asarray(0.5 * (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]))


def signed_volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Compute the volume that a closed surface encloses, sum_f x_0 . A_f / 3 [m3], A_f of `area_vectors`; positive
    where outward. Positions are relative to the mean corner, so that the result for an open surface does not depend on
    the origin."""
    middle = np.bincount(faces.ravel(), minlength=len(vertices)) @ vertices / max(faces.size, 1)
    return float(np.einsum("ij,ij->", area_vectors(vertices, faces), vertices[faces[:, 0]] - middle)) / 3.0


def corner_angles(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Compute the three inner angles of each face [rad], shape [face_count, 3]."""
    corners = vertices[faces]
    angles = np.zeros((len(faces), 3))
    for k in range(3):
        u = corners[:, (k + 1) % 3] - corners[:, k]
        v = corners[:, (k + 2) % 3] - corners[:, k]
        angles[:, k] = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
    return angles


def angle_defects(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Compute the Gaussian curvature at each vertex [rad], shape [vertex_count]; 0 on open contours and off all faces.
    K_v = 2 pi less the sum of the inner angles around v: 0 at every vertex of a developable surface."""
    angles = np.bincount(faces.ravel(), weights=corner_angles(vertices, faces).ravel(), minlength=len(vertices))
    edges = HalfEdges.of(faces, len(vertices))
    defects = np.where(angles > 0.0, 2.0 * np.pi - angles, 0.0)
    defects[edges.edges[edges.face_counts == 1].ravel()] = 0.0
    return np.asarray(defects)


def rim_turns(corners: np.ndarray, faces: np.ndarray, rim: np.ndarray) -> np.ndarray:
    """Compute the turning angle of a rim in its surface at each vertex [rad]: pi less the faces' angles there. It is
    that of the outline of the surface laid flat, whatever its folds in space.

    Args:
        corners: Positions of the faces' corners [m], in space or in the flat cloth, shape [face_count, 3, 3].
        faces: Shape [face_count, 3].
        rim: Vertices along it, shape [n].

    Returns:
        Positive where the rim is convex, shape [n].
    """
    touched = np.isin(faces, rim).any(axis=1)
    points = corners[touched].reshape(-1, 3)
    angles = corner_angles(points, np.arange(len(points)).reshape(-1, 3))
    sums = np.bincount(faces[touched].ravel(), angles.ravel(), minlength=int(rim.max()) + 1)
    return np.asarray(np.pi - sums[rim])


def shape_gradients(rest: np.ndarray) -> np.ndarray:
    """Compute the gradients of the three linear shape functions of flat triangles [1/m], shape [face_count, 3, 2].

    g_k is the gradient of the function that is 1 at corner k and 0 at both others; g_0 + g_1 + g_2 = 0, and g_1, g_2
    are the rows of D_m^-1, D_m = [p_1 - p_0, p_2 - p_0]. Triangles are clamped to `MIN_TRIANGLE_AREA_RATIO`.

    Args:
        rest: Corners [m], shape [face_count, 3, 2].
    """
    p, q = rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]
    twice = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    least = MIN_TRIANGLE_AREA_RATIO * np.maximum((p**2).sum(1) + (q**2).sum(1), 1e-12)
    safe = np.where(np.abs(twice) > least, twice, np.where(twice < 0, -least, least))
    one = np.stack([q[:, 1], -q[:, 0]], axis=1) / safe[:, None]
    two = np.stack([-p[:, 1], p[:, 0]], axis=1) / safe[:, None]
    return np.ascontiguousarray(np.stack([-one - two, one, two], axis=1))


def gradient_operator(rest: np.ndarray, faces: np.ndarray, count: int) -> tuple[csr_matrix, np.ndarray]:
    """Build the operator G from values at the vertices to their gradients on the flat rest triangles.

    Row 2 f + k of `G @ x` is the derivative of x along axis k of face f's rest triangle, so that the 3x2 deformation
    gradient of f is `(G @ x)[2 f : 2 f + 2].T`. Exact for fields that are linear over the plane.

    Args:
        rest: Flat rest triangles [m], shape [face_count, 3, 2].
        faces: Vertex indices, shape [face_count, 3].
        count: Vertices.

    Returns:
        The operator [1/m], shape [2 face_count, count], and the rest areas [m2], shape [face_count].
    """
    from scipy.sparse import csr_matrix

    values = np.swapaxes(shape_gradients(rest), 1, 2)
    rows = np.repeat(np.arange(2 * len(faces)), 3)
    columns = np.repeat(faces, 2, axis=0).reshape(-1)
    operator = csr_matrix((values.reshape(-1), (rows, columns)), shape=(2 * len(faces), count))
    return operator, np.abs(signed_areas(rest))


def deformation_gradients(nodes: np.ndarray, faces: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Compute F = sum_k x_k g_k^T of each face, shape [face_count, 3, 2]: the map from its flat triangle to space.

    Args:
        nodes: Positions [m], shape [node_count, 3].
        faces: Node indices, shape [face_count, 3].
        rest: Flat rest triangles [m], shape [face_count, 3, 2].
    """
    gradients, placed = shape_gradients(rest), nodes[faces]
    spans = np.stack([placed[:, 1] - placed[:, 0], placed[:, 2] - placed[:, 0]], axis=2)
    return np.asarray(spans @ gradients[:, 1:])


def principal_stretches(gradients: np.ndarray) -> np.ndarray:
    """Compute the singular values of 3x2 deformation gradients, larger first, shape [face_count, 2]. They follow
    exactly from C = F^T F, much faster than by a decomposition of each face."""
    cauchy = np.swapaxes(gradients, 1, 2) @ gradients
    half_trace = 0.5 * (cauchy[:, 0, 0] + cauchy[:, 1, 1])
    radius = np.hypot(0.5 * (cauchy[:, 0, 0] - cauchy[:, 1, 1]), cauchy[:, 0, 1])
    larger = np.sqrt(half_trace + radius)
    determinant = np.linalg.norm(np.cross(gradients[:, :, 0], gradients[:, :, 1]), axis=1)
    smaller = np.divide(determinant, larger, out=np.zeros_like(larger), where=larger > 0.0)
    return np.stack([larger, smaller], axis=1)


def right_stretch(gradients: np.ndarray, least: float = 0.0) -> np.ndarray:
    """Compute U = sqrt(F^T F) of 3x2 deformation gradients F = R U, shape [face_count, 2, 2].

    sqrt(C) = (C + s I) / sqrt(tr C + 2 s) with s = sqrt(det C), for 2x2 matrices.

    Args:
        gradients: F, shape [face_count, 3, 2].
        least: Stretch that is added in square, so that a collapsed face's U can be inverted.
    """
    square = np.swapaxes(gradients, 1, 2) @ gradients + least**2 * np.eye(2)
    root = np.sqrt(np.linalg.det(square))
    trace = square[:, 0, 0] + square[:, 1, 1]
    return np.asarray((square + root[:, None, None] * np.eye(2)) / np.sqrt(trace + 2 * root)[:, None, None])


def polar_rotations(gradients: np.ndarray) -> np.ndarray:
    """Compute R = F (F^T F)^(-1/2): the 3x2 orthonormal frames nearest to deformation gradients, [face_count, 3, 2]."""
    product = np.einsum("fki,fkj->fij", gradients, gradients)
    a, b, d = product[:, 0, 0], product[:, 0, 1], product[:, 1, 1]
    root = np.sqrt(np.maximum(a * d - b * b, 1e-12))
    scale = np.sqrt(np.maximum(a + d + 2 * root, 1e-12))
    # sqrt(C) = (C + sqrt(det C) I) / trace, and its determinant is sqrt(det C)
    inverse = np.stack([d + root, -b, -b, a + root], axis=1).reshape(-1, 2, 2) / (scale * root)[:, None, None]
    return np.asarray(gradients @ inverse)


def cotangent_laplacian(corners: np.ndarray, faces: np.ndarray, count: int) -> csr_matrix:
    """Build the cotangent Laplacian L, positive semidefinite, shape [count, count].

    L_ij = -(cot a_ij + cot b_ij) / 2 with the angles opposite edge ij, L_ii = -sum_j L_ij: x^T L x = int |grad x|^2 dA,
    and -L x / vertex area is the Laplace-Beltrami operator. It is G^T A G of `gradient_operator`. Linear fields over
    the plane are in its kernel except for border rows.

    Args:
        corners: The faces' corners in the plane or in space [m], shape [face_count, 3, 2 or 3].
        faces: Vertex indices, shape [face_count, 3].
        count: Vertices.
    """
    from scipy.sparse import csr_matrix

    rows, columns, values = [], [], []
    for k in range(3):
        i, j = faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        if corners.shape[2] == 2:
            twice = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        else:
            twice = np.linalg.norm(np.cross(a, b), axis=1)
        half_cotangent = 0.5 * (a * b).sum(1) / np.maximum(twice, 1e-12)
        rows += [i, j, i, j]
        columns += [j, i, i, j]
        values += [-half_cotangent, -half_cotangent, half_cotangent, half_cotangent]
    triplets = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return csr_matrix(triplets, shape=(count, count))


def bending_matrix(laplacian: csr_matrix, weights: np.ndarray) -> csr_matrix:
    """Build L^T diag(weights) L of a Laplacian; with 1 / vertex area as weights, x^T B x = int |lap x|^2 dA [1/m2]."""
    from scipy.sparse import csr_matrix, diags

    return csr_matrix(laplacian.T @ diags(weights) @ laplacian)


def mean_curvature(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Compute the mean curvature H at each vertex [1/m], shape [vertex_count]: 1 / r on a sphere, 1 / (2 r) on a tube.
    2 H n = L x / A, with the cotangent Laplacian L and `vertex_areas` A (Meyer et al. 2003); positive where the surface
    bends away from its normal, as outside a ball; 0 on open borders, where H is undefined."""
    from .connectivity import HalfEdges

    pull = cotangent_laplacian(vertices[faces], faces, len(vertices)) @ vertices
    size = 0.5 * np.linalg.norm(pull, axis=1) / np.maximum(vertex_areas(vertices, faces), 1e-12)
    inwards = (pull * vertex_normals(vertices, faces)).sum(1) < 0.0
    return np.where(HalfEdges.of(faces, len(vertices)).border_vertices, 0.0, np.where(inwards, -size, size))


def edge_curvature(vertices: np.ndarray, normals: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Estimate the mean curvature H at each vertex [1/m] from unit vertex normals, shape [vertex_count]. The mean over
    the half-edges e that leave it of the normal curvature along them, -2 n . e / |e|^2; the sign as in
    `mean_curvature`. Less accurate, but robust on uneven triangles, and defined on borders."""
    start, end = faces.reshape(-1), faces[:, [1, 2, 0]].reshape(-1)
    edge = vertices[end] - vertices[start]
    bend = -2.0 * np.einsum("ed,ed->e", edge, normals[start]) / np.maximum((edge**2).sum(1), 1e-12)
    count = len(vertices)
    total, degree = np.bincount(start, bend, count), np.bincount(start, minlength=count)
    return np.asarray(total / np.maximum(degree, 1))
