"""Thin a dense scan for what need not see every triangle, and keep which vertex became which.

Vertices are gathered to clusters of about one size, each connected along the surface, so that two layers that lie on
one another stay two; a cluster becomes the mean of its vertices, and a triangle whose corners lie in three clusters
becomes theirs. This is what a centroidal Voronoi diagram on a mesh does (S. Valette and J.-M. Chassery, Approximated
Centroidal Voronoi Diagrams for Uniform Polygonal Mesh Coarsening, 2004). **Deviation**: clusters grow by the straight
distance and are split into connected pieces afterwards, which takes seconds for millions of triangles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..mesh import HalfEdges, find_components, lump, unit, vertex_normals
from ..mesh import face_areas as areas_of
from .mend import first_of
from .normals import thin_points
from .raw import RawScan
from .repair import RepairedMesh, mend_surface
from .scan import Scan

FACES = 100_000
"""Triangles that a fit needs: their sides are 7 mm on a whole person, less than a fold of cloth is wide."""
ROUNDS = 3
"""Rounds in which clusters move to their means; from a grid's cells, more change nothing that can be seen."""


@dataclass(frozen=True)
class ThinMesh:
    """Hold a thinned mesh.

    Attributes:
        vertices: Positions [m], shape [n, 3].
        faces: Triangles, shape [f, 3].
        origin: Vertex of the full mesh nearest to each, shape [n].
        place: For each vertex of the full mesh the one here that stands for it, shape [full_count].
    """

    vertices: np.ndarray
    faces: np.ndarray
    origin: np.ndarray
    place: np.ndarray


def thin(raw: RawScan, faces: int = FACES) -> RawScan:
    """Thin a raw scan to about so many triangles, or half as many points of a cloud; a smaller one is returned as is.

    `place` and `origin` of the result still speak of the file's points, so that what is found for the thinned points is
    carried to the file's by `found[place]` where `place` is not -1.
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


def thin_scan(scan: Scan, faces: int = FACES) -> tuple[Scan, ThinMesh]:
    """Thin a checked mesh to about so many triangles; labels and `unseen` are those of the nearest vertex."""
    if len(scan.faces) <= faces:
        own = np.arange(len(scan.vertices))
        return scan, ThinMesh(scan.vertices, scan.faces, own, own)
    small = thin_mesh(scan.vertices, scan.faces, faces)
    thinned = replace(
        scan,
        vertices=small.vertices,
        faces=small.faces,
        colours=None if scan.colours is None else average(scan.colours, small),
        labels=None if scan.labels is None else scan.labels[small.origin],
        unseen=None if scan.unseen is None else scan.unseen[small.origin],
    )
    return thinned, small


def average(values: np.ndarray, small: ThinMesh) -> np.ndarray:
    """Average values of the full mesh, shape [full_count, k], over the vertices that each thinned one stands for."""
    count = np.maximum(np.bincount(small.place, minlength=len(small.vertices)), 1)[:, None]
    sums = [np.bincount(small.place, values[:, k], len(small.vertices)) for k in range(values.shape[1])]
    mean = np.stack(sums, axis=1) / count
    empty = np.bincount(small.place, minlength=len(small.vertices)) == 0
    mean[empty] = values[small.origin[empty]]
    return mean


def thin_mesh(vertices: np.ndarray, faces: np.ndarray, count: int = FACES) -> ThinMesh:
    """Thin a mesh to about `count` triangles, without tearing it or joining layers that only touch.

    A border stays where it is: a cluster on it becomes the mean of its border vertices.
    """
    from scipy.spatial import cKDTree

    area = areas_of(vertices, faces)
    weight = lump(area, faces, len(vertices)) + 1e-18
    wanted = max(count // 2, 4)
    cluster = _cells(vertices, faces, float(np.sqrt(1.5 * area.sum() / wanted)))
    for _ in range(ROUNDS):
        means = _means(vertices, weight, cluster)
        cluster = cKDTree(means).query(vertices)[1]
        cluster = np.unique(cluster, return_inverse=True)[1].reshape(-1)
    half_edges = HalfEdges.of(faces, len(vertices))
    same = cluster[half_edges.tail] == cluster[half_edges.head]
    number, cluster = find_components(len(vertices), half_edges.tail[same], half_edges.head[same])
    border = half_edges.border_vertices
    on_border = np.bincount(cluster, border, number) > 0
    inner = weight * np.where(on_border[cluster], border, True)
    means = _means(vertices, inner, cluster)
    corners = cluster[faces]
    distinct = (corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2]) & (corners[:, 2] != corners[:, 0])
    small = mend_surface(RepairedMesh(means, corners[distinct], np.arange(number)))
    place = first_of(small.origin, number)[cluster]
    tree = cKDTree(small.vertices)
    lost = place < 0
    if lost.any():
        place[lost] = tree.query(vertices[lost])[1]
    origin = cKDTree(vertices).query(small.vertices)[1]
    return ThinMesh(small.vertices, small.faces, origin, place)


def _cells(vertices: np.ndarray, faces: np.ndarray, edge: float) -> np.ndarray:
    """Gather vertices by the cells of a grid: the number of each vertex's cell, without gaps, shape [n]."""
    cell = ((vertices - vertices.min(axis=0)) / edge).astype(np.int64)
    keys = (cell[:, 0] << 40) | (cell[:, 1] << 20) | cell[:, 2]
    return np.unique(keys, return_inverse=True)[1].reshape(-1)


def _means(vertices: np.ndarray, weight: np.ndarray, cluster: np.ndarray) -> np.ndarray:
    total = np.bincount(cluster, weight)
    return np.stack([np.bincount(cluster, weight * vertices[:, k]) for k in range(3)], axis=1) / total[:, None]


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
