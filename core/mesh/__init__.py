"""Triangle meshes and curves: what every room asks of them, without knowledge of cloth or bodies."""

from __future__ import annotations

from .connectivity import HalfEdges, adjacency_matrix, find_components
from .geometry import (
    area_vectors,
    bending_matrix,
    corner_angles,
    cotangent_laplacian,
    deformation_gradients,
    edge_curvature,
    face_areas,
    face_normals,
    gradient_operator,
    lump,
    mean_curvature,
    polar_rotations,
    principal_stretches,
    right_stretch,
    shape_gradients,
    signed_areas,
    unit,
    vertex_areas,
    vertex_normals,
)

__all__ = [
    "HalfEdges",
    "adjacency_matrix",
    "area_vectors",
    "bending_matrix",
    "corner_angles",
    "cotangent_laplacian",
    "deformation_gradients",
    "edge_curvature",
    "face_areas",
    "face_normals",
    "find_components",
    "gradient_operator",
    "lump",
    "mean_curvature",
    "polar_rotations",
    "principal_stretches",
    "right_stretch",
    "shape_gradients",
    "signed_areas",
    "unit",
    "vertex_areas",
    "vertex_normals",
]
