"""Reconstruct the surface of an oriented point cloud where there are points, and nowhere else.

Screened Poisson reconstruction (M. Kazhdan and H. Hoppe, 2013; open3d's) gives a closed surface; the parts that span
gaps between the points, or the step at a hem, are removed by distance and by direction.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..geometry.connectivity import HalfEdges, find_components
from ..geometry.geometry import face_areas, face_normals, unit
from ..run.errors import GarmentqError
from ..run.sandbox import Bounds, call_limited, is_memory_short
from .mend import mend_mesh
from .open3d_library import load_open3d

MAX_POISSON_DISTANCE_RATIO = 2.5
"""Largest distance from the nearest point [median spacings]: up to 0.7 in a full grid, rarely 2 in random points."""
MIN_POISSON_NORMAL_COSINE = 0.3
"""Least cosine between the normals of a face and of the points nearest to it: noise tilts a normal by up to half a
right angle, a face that spans the step at a hem is perpendicular to the points."""
MIN_POISSON_PIECE_SHARE = 0.01
"""Share of the largest piece's area below which a piece is dropped as a bubble closed by Poisson reconstruction."""
OCTREE_DEPTH_RANGE = (6, 9)
"""Least and largest number of levels of the octree: at 9 a cell of a person's box is 3.7 mm, and its surface as near to
the true cloth (1.1 mm) as that of 8; at 10 it has millions of triangles of noise."""
BOUNDS = Bounds(memory_bytes=6 * 1024**3, cpu_seconds=300, wall_seconds=600.0)
"""Limits of a reconstruction: a million points take some 60 s and 2 GB."""


class SurfaceFailed(GarmentqError):
    """No surface could be made of the points; give the scan as a mesh, or check `garmentq doctor`."""

    code = "scan.no_surface"


class SurfaceLibraryMissing(GarmentqError):
    """The library open3d cannot be loaded, which makes surfaces of clouds; `garmentq doctor` says what it lacks."""

    code = "scan.no_open3d"


@dataclass(frozen=True)
class ReconstructedSurface:
    """Describe the surface of a cloud.

    Attributes:
        vertices: Positions [m], shape [n, 3].
        faces: Outward triangles, shape [f, 3].
        colours: RGB in 0..1 of the nearest points, shape [n, 3], or None.
        labels: Labels of the nearest points, shape [n], or None.
        nearest: Index of the nearest point of the cloud, shape [n].
        distance: Distance to it [m], shape [n].
        unseen: True at vertices on a rim, beyond which the scanner saw nothing, shape [n].
    """

    vertices: np.ndarray
    faces: np.ndarray
    colours: np.ndarray | None
    labels: np.ndarray | None
    nearest: np.ndarray
    distance: np.ndarray
    unseen: np.ndarray


def reconstruct(
    points: np.ndarray,
    normals: np.ndarray,
    colours: np.ndarray | None = None,
    labels: np.ndarray | None = None,
    is_confined: bool = False,
) -> ReconstructedSurface:
    """Reconstruct the surface of a cloud.

    Args:
        points: Positions [m], shape [n, 3].
        normals: Outward unit normals, shape [n, 3].
        colours: RGB in 0..1, shape [n, 3], or None.
        labels: Label of each point, numbers or texts, shape [n], or None.
        is_confined: Whether this is a limited process: the surface is then computed in it instead of in another one.

    Raises:
        SurfaceFailed: where no surface is left.
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    spacing = measure_spacing(points)
    vertices, faces = _solve(points, normals, find_depth(points, spacing), is_confined)
    if not len(faces):
        raise SurfaceFailed()
    vertices, faces = trim(vertices, faces, points, normals, spacing)
    if not len(faces):
        raise SurfaceFailed()
    distance, nearest = tree.query(vertices)
    return ReconstructedSurface(
        vertices,
        faces,
        None if colours is None else colours[nearest],
        None if labels is None else labels[nearest],
        nearest,
        distance,
        HalfEdges.of(faces, len(vertices)).border_vertices,
    )


def measure_spacing(points: np.ndarray) -> float:
    """Measure the side of the square that each point has for itself on the surface [m], a median.

    n points in a disc of radius r have pi r^2 / n each. The nearest point alone is at half of that side, and nearer
    where a scanner's frames overlap.
    """
    from scipy.spatial import cKDTree

    count = min(9, len(points))
    sample = points[np.linspace(0, len(points) - 1, min(len(points), 5000)).astype(np.int64)]
    radius = cKDTree(points).query(sample, count)[0][:, -1]
    return float(np.median(radius) * np.sqrt(np.pi / (count - 1)))


def find_depth(points: np.ndarray, spacing: float) -> int:
    """Find the octree's depth at which a cell is as wide as the spacing; its box is 1.1 times the points'."""
    side = 1.1 * float(np.ptp(points, axis=0).max())
    return int(np.clip(np.round(np.log2(side / spacing)), *OCTREE_DEPTH_RANGE))


def _solve(points: np.ndarray, normals: np.ndarray, depth: int, is_confined: bool) -> tuple[np.ndarray, np.ndarray]:
    with tempfile.TemporaryDirectory(prefix="garmentq-surface-") as folder:
        source, target = Path(folder) / "points.npz", Path(folder) / "surface.npz"
        np.savez(source, points=points, normals=normals)
        names = {"source": str(source), "target": str(target), "depth": depth}
        if is_confined:
            solve_poisson(**names)  # type: ignore[arg-type]
        else:
            call_limited(f"{__name__}:solve_poisson", names, BOUNDS)
        with np.load(target, allow_pickle=False) as arrays:
            return arrays["vertices"], arrays["faces"]


def solve_poisson(source: str, target: str, depth: int) -> dict[str, float]:
    """Compute the closed surface of the points in a file, and write it to another; runs in a limited process."""
    try:
        open3d = load_open3d()
    except ImportError as error:
        if is_memory_short(error):
            raise MemoryError from error
        raise SurfaceLibraryMissing() from error
    with np.load(source, allow_pickle=False) as arrays:
        points, normals = arrays["points"], arrays["normals"]
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud.normals = open3d.utility.Vector3dVector(normals)
    mesh, _ = open3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=depth, n_threads=1)
    np.savez(target, vertices=np.asarray(mesh.vertices), faces=np.asarray(mesh.triangles, dtype=np.int64))
    return {}


def trim(
    vertices: np.ndarray, faces: np.ndarray, points: np.ndarray, normals: np.ndarray, spacing: float
) -> tuple[np.ndarray, np.ndarray]:
    """Remove faces that are far from the points or perpendicular to them, and small pieces; repair the rest."""
    from scipy.spatial import cKDTree

    distance, neighbours = cKDTree(points).query(vertices, min(4, len(points)))
    is_far = distance[:, 0] > MAX_POISSON_DISTANCE_RATIO * spacing
    around = unit(normals[neighbours].sum(axis=1) + 1e-12)
    direction = face_normals(vertices, faces)[0]
    agree = np.einsum("fi,fi->f", direction, unit(around[faces].sum(axis=1) + 1e-12)) > MIN_POISSON_NORMAL_COSINE
    kept = faces[agree & ~is_far[faces].any(axis=1)]
    if not len(kept):
        return vertices, kept
    number, piece = find_components(len(vertices), np.r_[kept[:, 0], kept[:, 1]], np.r_[kept[:, 1], kept[:, 2]])
    size = np.bincount(piece[kept[:, 0]], face_areas(vertices, kept), number)
    kept = kept[(size >= MIN_POISSON_PIECE_SHARE * size.max())[piece[kept[:, 0]]]]
    mesh = mend_mesh(vertices, kept)
    return mesh.points, mesh.faces
