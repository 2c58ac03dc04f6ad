"""Bring a draped template coarsely onto the target: contour to contour, surface to surface, smooth in between."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from ..hooks import SILENT, Hooks
from ..pattern import Garment
from ..segment import Target


@dataclass(frozen=True)
class RegistrationSettings:
    """Set the coarse registration.

    Attributes:
        steps: Solves; each takes one closest-point query.
        reach_first, reach_last: Length [m] below which displacements are smoothed, at the first and the last step: from
            half a torso, so that garments slide over each other as a whole, to a wide fold.
        contour_reach: The same for matched contours: 5 mm, they fit almost exactly.
        facing: A closest point counts where both normals agree to this cosine; 0.3 (72 degrees) keeps folds and drops
            the other leg.
    """

    steps: int = 40
    reach_first: float = 0.30
    reach_last: float = 0.04
    contour_reach: float = 0.005
    facing: float = 0.3


def register_coarsely(
    garment: Garment,
    target: Target,
    settings: RegistrationSettings | None = None,
    hooks: Hooks = SILENT,
) -> np.ndarray:
    """Move the nodes of a draped template onto the target [m], shape [node_count, 3].

    Each step minimises over the displacement d

        int |lap d|^2 dA + int |d - q|^2 / r^4 dA + int_contours |d - q_c|^2 / r_c^3 ds

    Notation: r `reach`, r_c `contour_reach`; q leads each node to the plane of its closest point on the target, q_c
    each contour node to the point at the same share of the target contour's length. Integrals run over the flat rest
    shape, so that the result does not depend on the mesh.
    """
    settings = settings or RegistrationSettings()
    start = garment.nodes
    stiffness, mass = bending_operators(garment)
    pulls, pulled = np.zeros(len(start)), np.zeros((len(start), 3))
    for contour in garment.contours:
        other = target.contour(contour.name)
        if other is not None and contour.trusted and other.trusted:
            goal, share = match_loop(start[contour.vertices], target.vertices[other.vertices])
            np.add.at(pulls, contour.vertices, share / settings.contour_reach**3)
            pulled[contour.vertices] = goal - start[contour.vertices]
    inside = pulls == 0
    tree = igl.AABB()
    surface, triangles = np.ascontiguousarray(target.vertices), np.ascontiguousarray(target.faces, dtype=np.int64)
    tree.init(surface, triangles)
    # Closest points there mean that the surface ends, not that it is near.
    rim = np.isin(triangles, open_edges(triangles)).sum(axis=1) > 1
    moved = start.copy()
    for step, reach in enumerate(np.geomspace(settings.reach_first, settings.reach_last, settings.steps)):
        hooks.progress("grade", 0.8 * step / settings.steps, "registering")
        _, face, foot = tree.squared_distance(surface, triangles, moved)
        face, foot = np.asarray(face).reshape(-1), np.asarray(foot)
        normal = _face_normals(surface, triangles[face])
        agrees = (node_normals(moved, garment.faces) * normal).sum(1) > settings.facing
        weight = np.where(inside & agrees & ~rim[face], mass / reach**4, 0.0)
        lead = moved - start + normal * (normal * (foot - moved)).sum(1)[:, None]
        # A hundredth of the first pull to stay in place: the system keeps full rank where nothing is matched at all.
        rest = 0.01 * mass / settings.reach_first**4
        system = sp.csc_matrix(stiffness + sp.diags(weight + pulls + rest))
        right = weight[:, None] * lead + pulls[:, None] * pulled
        moved = start + splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(right)
    return moved


def match_loop(source: np.ndarray, target: np.ndarray, samples: int = 128) -> tuple[np.ndarray, np.ndarray]:
    """Match two closed curves by their share of length from the best common start.

    Both run with the garment on the left, so only the start is free; it is the one of `samples` that leaves the least
    squared distance between the centred curves.

    Returns:
        Points on the target [m], shape [source_count, 3], and the length [m] that each source point stands for.
    """
    share, lengths = _shares(source)
    grid = np.arange(samples) / samples
    a, b = _at(source, grid), _at(target, grid)
    a, b = a - a.mean(0), b - b.mean(0)
    costs = [((a - np.roll(b, -shift, axis=0)) ** 2).sum() for shift in range(samples)]
    start = int(np.argmin(costs)) / samples
    return _at(target, share + start), (lengths + np.roll(lengths, 1)) / 2


def bending_operators(garment: Garment) -> tuple[sp.csr_matrix, np.ndarray]:
    """Give the matrix of int |lap d|^2 dA over the flat rest shape, [node_count, node_count], and node areas [m2].

    L^T M^-1 L with the cotangent Laplacian L and the lumped areas M. Rows of nodes on open contours are left out, so
    that a displacement that grows linearly towards a contour costs nothing.
    """
    corners, faces, count = garment.rest, garment.faces, len(garment.nodes)
    rows, columns, values = [], [], []
    for k in range(3):
        i, j = faces[:, (k + 1) % 3], faces[:, (k + 2) % 3]
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        half_cotangent = 0.5 * (a * b).sum(1) / np.maximum(area, 1e-12)
        rows += [i, j, i, j]
        columns += [j, i, i, j]
        values += [-half_cotangent, -half_cotangent, half_cotangent, half_cotangent]
    shape = (count, count)
    stiffness = sp.csr_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape)
    mass = np.bincount(faces.ravel(), np.repeat(area / 6, 3), minlength=count)
    weight = 1.0 / mass
    weight[np.unique(open_edges(faces))] = 0.0
    return sp.csr_matrix(stiffness.T @ sp.diags(weight) @ stiffness), mass


def node_normals(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Give unit node normals weighted by area, shape [node_count, 3]."""
    a, b, c = (nodes[faces[:, k]] for k in range(3))
    normal = np.zeros_like(nodes)
    np.add.at(normal, faces.ravel(), np.repeat(np.cross(b - a, c - a), 3, axis=0))
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)


def _face_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)


def open_edges(faces: np.ndarray) -> np.ndarray:
    """Give the edges with one face only, shape [edge_count, 2]."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, counts = np.unique(edges, axis=0, return_counts=True)
    return np.asarray(edges[counts == 1])


def _shares(loop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Give each point's share 0..1 of a closed curve's length, and the length of the piece after it [m]."""
    lengths = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
    return np.concatenate([[0.0], np.cumsum(lengths)[:-1]]) / lengths.sum(), lengths


def _at(loop: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Give points [m] at shares of a closed curve's length, any real share."""
    known, _ = _shares(loop)
    closed = np.concatenate([loop, loop[:1]])
    known = np.concatenate([known, [1.0]])
    return np.stack([np.interp(share % 1.0, known, closed[:, k]) for k in range(3)], axis=1)
