"""Triangle meshes and curves: what every room asks of them, without knowledge of cloth or bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..run.lazy import import_lazily
from .connectivity import HalfEdges, adjacency_matrix, find_components, shortest_paths
from .curves import ClosedCurve, CurvePoints, polyline_length, resample_polyline
from .geometry import (
    angle_defects,
    area_vectors,
    bending_matrix,
    corner_angles,
    cotangent_laplacian,
    deformation_gradients,
    edge_curvature,
    edge_lengths,
    face_areas,
    face_normals,
    gradient_operator,
    lump,
    mean_curvature,
    polar_rotations,
    principal_stretches,
    right_stretch,
    rim_turns,
    shape_gradients,
    signed_areas,
    signed_volume,
    unit,
    vertex_areas,
    vertex_normals,
)
from .rigid import RigidMotion, fit_rigid, plane_rotation
from .rim import Rim
from .surface import ClosestPoints, TriangleSurface, barycentric_coordinates

if TYPE_CHECKING:
    from .collapse import CollapsedMesh, collapse_edges
    from .contour import measure_contour
    from .intersections import face_boxes, intersecting_pairs, self_intersections, undo_crossings
    from .linear import Factor, NotPositiveDefinite, Solver, SuperLU, analyse_pattern, factor_general, factor_symmetric
    from .moving_towards import move_towards
    from .multifrontal import Cholesky
    from .untangling import contract_contours, untangle

_LAZY = {
    "Cholesky": "multifrontal",
    "CollapsedMesh": "collapse",
    "Factor": "linear",
    "NotPositiveDefinite": "linear",
    "Solver": "linear",
    "SuperLU": "linear",
    "analyse_pattern": "linear",
    "collapse_edges": "collapse",
    "contract_contours": "untangling",
    "factor_general": "linear",
    "factor_symmetric": "linear",
    "face_boxes": "intersections",
    "intersecting_pairs": "intersections",
    "measure_contour": "contour",
    "move_towards": "moving_towards",
    "self_intersections": "intersections",
    "undo_crossings": "intersections",
    "untangle": "untangling",
}
# Modules with compiled kernels or sparse libraries: imported on first use, so that the room itself stays light.

__all__ = [
    "Cholesky",
    "ClosedCurve",
    "ClosestPoints",
    "CollapsedMesh",
    "CurvePoints",
    "Factor",
    "HalfEdges",
    "NotPositiveDefinite",
    "RigidMotion",
    "Rim",
    "Solver",
    "SuperLU",
    "TriangleSurface",
    "adjacency_matrix",
    "analyse_pattern",
    "angle_defects",
    "area_vectors",
    "barycentric_coordinates",
    "bending_matrix",
    "collapse_edges",
    "contract_contours",
    "corner_angles",
    "cotangent_laplacian",
    "deformation_gradients",
    "edge_curvature",
    "edge_lengths",
    "face_areas",
    "face_boxes",
    "face_normals",
    "factor_general",
    "factor_symmetric",
    "find_components",
    "fit_rigid",
    "gradient_operator",
    "intersecting_pairs",
    "lump",
    "mean_curvature",
    "measure_contour",
    "move_towards",
    "plane_rotation",
    "polar_rotations",
    "polyline_length",
    "principal_stretches",
    "resample_polyline",
    "right_stretch",
    "rim_turns",
    "self_intersections",
    "shape_gradients",
    "shortest_paths",
    "signed_areas",
    "signed_volume",
    "undo_crossings",
    "unit",
    "untangle",
    "vertex_areas",
    "vertex_normals",
]

__getattr__ = import_lazily(__name__, _LAZY)
