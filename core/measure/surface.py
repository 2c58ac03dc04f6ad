"""Ask a triangle mesh about its surface: normals, samples, closest points, depth inside a body."""

from __future__ import annotations

import igl
import numpy as np

from ..body import Solid, face_normals


def sample_surface(
    vertices: np.ndarray, faces: np.ndarray, count: int, generator: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Draw points uniformly by area.

    Args:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: Vertex indices, shape [face_count, 3].
        count: Number of points.
        generator: The source of chance; the same state gives the same points.

    Returns:
        The points [m], shape [count, 3], and the face of each, shape [count].
    """
    _, areas = face_normals(vertices, faces)
    cumulative = np.cumsum(areas)
    # One random number per equal slice of the area: as uniform as independent draws, with less scatter.
    slices = (np.arange(count) + generator.random(count)) / count * cumulative[-1]
    face = np.minimum(np.searchsorted(cumulative, slices, side="right"), len(faces) - 1)
    root = np.sqrt(generator.random(count))[:, None]
    along = generator.random(count)[:, None]
    a, b, c = (vertices[faces[face, k]] for k in range(3))
    return (1.0 - root) * a + root * (1.0 - along) * b + root * along * c, face


def closest_points(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Find the exact distance [m] of each point to a surface, shape [point_count], and the closest face of each."""
    squared, face, _ = igl.point_mesh_squared_distance(
        np.ascontiguousarray(points, dtype=np.float64),
        np.ascontiguousarray(vertices, dtype=np.float64),
        np.ascontiguousarray(faces, dtype=np.int64),
    )
    return np.sqrt(np.maximum(squared, 0.0)), face


def project_points(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Move each point to the closest point of a surface [m], shape [point_count, 3]."""
    _, _, closest = igl.point_mesh_squared_distance(
        np.ascontiguousarray(points, dtype=np.float64),
        np.ascontiguousarray(vertices, dtype=np.float64),
        np.ascontiguousarray(faces, dtype=np.int64),
    )
    return np.asarray(closest)


def penetration_depth(
    vertices: np.ndarray, faces: np.ndarray, body_vertices: np.ndarray, body_faces: np.ndarray
) -> float:
    """Measure how deep a garment's vertices and face centres lie inside a body's exact mesh, at most [m].

    Inside is what the body's `Solid` contains: that stands small holes and parts that overlap.

    Args:
        vertices: Garment positions [m], shape [vertex_count, 3].
        faces: Garment faces, shape [face_count, 3].
        body_vertices: Body positions [m], shape [body_vertex_count, 3].
        body_faces: Outward body faces, shape [body_face_count, 3].

    Returns:
        The greatest depth [m]; 0 where nothing is inside.
    """
    points = np.ascontiguousarray(np.concatenate([vertices, vertices[faces].mean(axis=1)]), dtype=np.float64)
    solid = Solid(body_vertices, body_faces)
    inside = solid.contains(points)
    if not inside.any():
        return 0.0
    return float(np.sqrt(igl.point_mesh_squared_distance(points[inside], solid.vertices, solid.faces)[0].max()))


def face_angles(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Give the three inner angles of each face [rad], shape [face_count, 3]."""
    corners = vertices[faces]
    angles = np.zeros((len(faces), 3))
    for k in range(3):
        u = corners[:, (k + 1) % 3] - corners[:, k]
        v = corners[:, (k + 2) % 3] - corners[:, k]
        angles[:, k] = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
    return angles


def stretches(nodes: np.ndarray, faces: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Give the singular values of each face's map from its flat rest triangle, larger first, shape [face_count, 2].

    Equation: F = Ds Dm^-1, with Ds = [x1 - x0, x2 - x0] in space and Dm the same in the pattern (thesis 2.7.3).

    Args:
        nodes: Positions in space [m], shape [node_count, 3].
        faces: Node indices, shape [face_count, 3].
        rest: Flat rest triangles [m], shape [face_count, 3, 2].
    """
    corners = nodes[faces]
    spatial = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    flat = np.stack([rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]], axis=2)
    gradient = spatial @ np.linalg.inv(flat)
    # Singular values from the 2 x 2 Cauchy-Green tensor: exact, and much quicker than an SVD of each face.
    cauchy = np.swapaxes(gradient, 1, 2) @ gradient
    half_trace = 0.5 * (cauchy[:, 0, 0] + cauchy[:, 1, 1])
    radius = np.hypot(0.5 * (cauchy[:, 0, 0] - cauchy[:, 1, 1]), cauchy[:, 0, 1])
    larger = np.sqrt(half_trace + radius)
    determinant = np.linalg.norm(np.cross(gradient[:, :, 0], gradient[:, :, 1]), axis=1)
    smaller = np.divide(determinant, larger, out=np.zeros_like(larger), where=larger > 0.0)
    return np.stack([larger, smaller], axis=1)
