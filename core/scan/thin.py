"""Thin a dense scan for steps that do not need every triangle, and map its vertices to the result."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..geometry.geometry import unit, vertex_normals
from ..geometry.point_normals import thin_points
from .raw import RawScan
from .scan import Scan

THINNED_PERSON_FACE_COUNT = 100_000
"""Number of triangles of a whole person that a fit needs: their sides are 7 mm, less than the width of a fold."""

THINNED_GARMENT_FACE_COUNT = 50_000
"""Number of triangles of one garment that a recovery needs: their sides are 5 to 9 mm, about half the detail mesh's. On
two garments of 0.5 million faces 60 000 made no distance more than 0.05 mm smaller, but one of a detail mesh's by 0.3
mm; simulation meshes and re-drapes were nearer by 0.05 to 0.6 mm with 50 000."""

MAX_UNTHINNED_FACE_RATIO = 8 / 5
"""Number of faces over the wanted one up to which a garment's mesh is not thinned: on a scan with 2 mm of noise a
pattern's outline was nearer by 0.4 mm with all of 77 000 triangles than with 60 000."""


@dataclass(frozen=True)
class ThinMesh:
    """Describe a thinned mesh.

    Attributes:
        vertices: Positions [m], shape [n, 3].
        faces: Triangles, shape [f, 3].
        origin: Vertex of the full mesh that each vertex is, ascending, shape [n].
        place: Index here of the vertex that represents each vertex of the full mesh, shape [full_count].
    """

    vertices: np.ndarray
    faces: np.ndarray
    origin: np.ndarray
    place: np.ndarray


def thin_raw_scan(raw: RawScan, faces: int = THINNED_PERSON_FACE_COUNT) -> RawScan:
    """Thin a raw scan to about so many triangles, or half as many points of a cloud; a smaller one is returned as is.

    `place` and `origin` of the result still refer to the file's points: `found[place]`, where `place` is not -1,
    carries values at the thinned points to those of the file.
    """
    if raw.is_cloud:
        return _thin_cloud(raw, faces // 2)
    if len(raw.faces) <= faces:
        return raw
    small = thin_mesh(raw.points, raw.faces, faces)
    place = np.where(raw.place >= 0, small.place[raw.place], -1)
    return replace(
        raw,
        points=small.vertices,
        faces=small.faces,
        normals=vertex_normals(small.vertices, small.faces),
        colours=None if raw.colours is None else average(raw.colours, small),
        labels=None if raw.labels is None else raw.labels[small.origin],
        origin=raw.origin[small.origin],
        place=place,
    )


def thin_scan(scan: Scan, faces: int = THINNED_GARMENT_FACE_COUNT) -> tuple[Scan, ThinMesh]:
    """Thin a garment's checked mesh to about so many triangles; labels, `unseen` and `hidden` are those of `origin`."""
    if len(scan.faces) <= MAX_UNTHINNED_FACE_RATIO * faces:
        rows = np.arange(len(scan.vertices))
        return scan, ThinMesh(scan.vertices, scan.faces, rows, rows)
    small = thin_mesh(scan.vertices, scan.faces, faces)
    thinned = replace(
        scan,
        vertices=small.vertices,
        faces=small.faces,
        colours=None if scan.colours is None else average(scan.colours, small),
        labels=None if scan.labels is None else scan.labels[small.origin],
        unseen=None if scan.unseen is None else scan.unseen[small.origin],
        hidden=None if scan.hidden is None else scan.hidden[small.origin],
    )
    return thinned, small


def average(values: np.ndarray, small: ThinMesh) -> np.ndarray:
    """Average values of the full mesh, shape [full_count, k], over the vertices that each thinned one represents."""
    count = np.maximum(np.bincount(small.place, minlength=len(small.vertices)), 1)[:, None]
    sums = [np.bincount(small.place, values[:, k], len(small.vertices)) for k in range(values.shape[1])]
    mean = np.stack(sums, axis=1) / count
    empty = np.bincount(small.place, minlength=len(small.vertices)) == 0
    mean[empty] = values[small.origin[empty]]
    return mean


def thin_mesh(vertices: np.ndarray, faces: np.ndarray, count: int = THINNED_PERSON_FACE_COUNT) -> ThinMesh:
    """Thin a mesh to `count` triangles, without tearing it or joining layers that only touch; borders stay as they are.

    A vertex in no face is represented by the nearest one.
    """
    from scipy.spatial import cKDTree

    from ..geometry.collapse import collapse_edges

    small = collapse_edges(vertices, faces, count)
    place, lost = small.place, small.place < 0
    if lost.any():
        place = place.copy()
        place[lost] = cKDTree(small.vertices).query(vertices[lost])[1]
    return ThinMesh(small.vertices, small.faces, small.origin, place)


def _thin_cloud(raw: RawScan, count: int) -> RawScan:
    from scipy.spatial import cKDTree

    rows = thin_points(raw.points, count)
    if len(rows) == len(raw.points):
        return raw
    nearest = cKDTree(raw.points[rows]).query(raw.points)[1]
    normals = raw.normals
    if normals is not None:
        normals = normals[rows]
        if raw.is_oriented:
            sums = [np.bincount(nearest, raw.normals[:, k], len(rows)) for k in range(3)]  # type: ignore[index]
            normals = unit(np.stack(sums, axis=1) + 1e-9 * normals)
    return replace(
        raw,
        points=raw.points[rows],
        normals=normals,
        colours=None if raw.colours is None else raw.colours[rows],
        labels=None if raw.labels is None else raw.labels[rows],
        origin=raw.origin[rows],
        place=np.where(raw.place >= 0, nearest[raw.place], -1),
    )
