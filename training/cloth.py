"""What is done to draped cloth before it is scanned: refined, cut to length, wrinkled, hemmed, put under a layer."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from scipy.spatial import cKDTree

from ..core.body.signed_distance import SignedDistance
from ..core.geometry.connectivity import HalfEdges
from ..core.geometry.geometry import vertex_normals

Mesh = tuple[np.ndarray, np.ndarray]
"""Vertices [m], shape [n, 3], and faces, shape [m, 3]."""

COVER = 0.06
"""Distance [m] of two layers up to which the outer covers the inner: a loose top over a waistband hangs 4 cm off."""

COVERED_SKIN = 0.008
"""Height of skin over cloth [m] up to which it is below it: a drape's errors on a person in a pose."""

BELOW = 0.0025
"""Distance [m] at which a covered layer is put below the one that covers it: two thicknesses of cloth."""

WAVES = 24
"""Plane waves in a wrinkled field: enough that no direction is seen."""


def refine(nodes: np.ndarray, faces: np.ndarray) -> Mesh:
    """Split every triangle in four, smoothly (Loop 1987)."""
    vertices, finer = igl.loop(np.asarray(nodes, np.float64), np.asarray(faces, np.int64), 1)
    return np.asarray(vertices), np.asarray(finer)


def clip(mesh: Mesh, keep: np.ndarray) -> Mesh:
    """Cut a mesh along the zero level of a field given at its vertices, shape [n]; what is positive stays."""
    vertices, faces = mesh
    inside = keep > 0
    count = inside[faces].sum(axis=1)
    whole = faces[count == 3]
    parts, fresh = [whole], []
    total = len(vertices)
    for wanted in (1, 2):
        cut = faces[count == wanted]
        if not len(cut):
            continue
        odd = np.argmax(inside[cut] == (wanted == 1), axis=1)
        a, b, c = (cut[np.arange(len(cut)), (odd + k) % 3] for k in range(3))
        ends = []
        for other in (b, c):
            share = (keep[a] / (keep[a] - keep[other]))[:, None]
            fresh.append(vertices[a] + share * (vertices[other] - vertices[a]))
            ends.append(total + np.arange(len(a)))
            total += len(a)
        ab, ac = ends
        if wanted == 1:
            parts.append(np.stack([a, ab, ac], axis=1))
        else:
            parts += [np.stack([ab, b, c], axis=1), np.stack([ab, c, ac], axis=1)]
    return compact(np.concatenate([vertices, *fresh]), np.concatenate(parts))


def compact(vertices: np.ndarray, faces: np.ndarray) -> Mesh:
    """Drop vertices that no face uses, and merge those at the same place."""
    if not len(faces):
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    used, index = np.unique(faces, return_inverse=True)
    kept, merged = np.unique(np.round(vertices[used], 7), axis=0, return_inverse=True)
    faces = merged.reshape(-1)[index].reshape(-1, 3)
    proper = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return kept, faces[proper]


def border_vertices(mesh: Mesh) -> np.ndarray:
    """Return the indices of the vertices on a mesh's border."""
    edges = HalfEdges.of(mesh[1])
    single = np.bincount(edges.edge, minlength=len(edges.edges)) == 1
    return np.unique(edges.edges[single])


def wave_field(points: np.ndarray, lengths: tuple[float, float], rng: np.random.Generator) -> np.ndarray:
    """Return a random field of unit RMS with wave lengths [m] in a range at points [m], shape [n]."""
    turn = rng.normal(size=(WAVES, 3))
    length = np.exp(rng.uniform(np.log(lengths[0]), np.log(lengths[1]), WAVES))
    wave = 2 * np.pi * turn / np.linalg.norm(turn, axis=1, keepdims=True) / length[:, None]
    return np.sin(points @ wave.T + rng.uniform(0, 2 * np.pi, WAVES)).sum(axis=1) * np.sqrt(2 / WAVES)


def even_out(values: np.ndarray, faces: np.ndarray, rounds: int, chosen: np.ndarray | None = None) -> np.ndarray:
    """Return values at a mesh's vertices, shape [n] or [n, k], each moved half way to its neighbours' mean, repeatedly.

    Args:
        values: One row for each vertex.
        faces: The mesh's, shape [m, 3].
        rounds: How often.
        chosen: Which vertices, bool, broadcast to the values; None: all.
    """
    edges = HalfEdges.of(faces, len(values)).adjacency
    degree = np.maximum(np.asarray(edges.sum(axis=1)).ravel(), 1.0).reshape(-1, *(1,) * (values.ndim - 1))
    for _ in range(rounds):
        evened = 0.5 * values + 0.5 * (edges @ values) / degree
        values = evened if chosen is None else np.where(chosen, evened, values)
    return values


def thicken(mesh: Mesh, height: np.ndarray) -> Mesh:
    """Move vertices out along their normals by heights [m], shape [n]."""
    return mesh[0] + height[:, None] * vertex_normals(*mesh), mesh[1]


def hem_height(mesh: Mesh, width: float, height: float) -> np.ndarray:
    """Return the height [m] that a turned-up hem of a width [m] adds at each vertex, shape [n]."""
    border = border_vertices(mesh)
    if not len(border):
        return np.zeros(len(mesh[0]))
    distance, _ = cKDTree(mesh[0][border]).query(mesh[0])
    return height * np.clip((width - distance) / 0.004, 0.0, 1.0)


def clear(mesh: Mesh, grid: SignedDistance, clearance: float) -> Mesh:
    """Push vertices that are nearer than a clearance [m] to a body out of it."""
    vertices, faces = mesh
    vertices = vertices.copy()
    for _ in range(3):
        distance, gradient = (values[: len(vertices)] for values in grid.measure(vertices))
        low = distance < clearance
        if not low.any():
            break
        size = np.maximum(np.linalg.norm(gradient[low], axis=1, keepdims=True), 0.3)
        vertices[low] += (clearance - distance[low])[:, None] * gradient[low] / size
    return vertices, faces


def hide_skin(skin: Mesh, cloth: Mesh) -> Mesh:
    """Put skin that pokes out of cloth below it; what faces the cloth from outside, a hand at a hip, stays."""
    if not len(cloth[1]):
        return skin
    over = _OverLayer.of(skin[0], cloth)
    alike = np.einsum("na,na->n", over.normals, vertex_normals(*skin)) > 0.5
    return over.put_below(skin, alike & (over.above < COVERED_SKIN))


def tuck_under(inner: Mesh, outer: Mesh) -> Mesh:
    """Put what an outer layer covers of an inner one below it, so that no layer shows through the other."""
    if not len(outer[1]):
        return inner
    over = _OverLayer.of(inner[0], outer)
    return over.put_below(inner, np.sqrt(over.square) < COVER)


@dataclass(frozen=True)
class _OverLayer:
    """Describe where vertices are over a layer.

    Attributes:
        nearest: The layer's nearest points [m], shape [n, 3].
        normals: Its unit normals there, shape [n, 3].
        square: Squared distances [m2], shape [n].
        above: Heights along the normals [m], shape [n].
    """

    nearest: np.ndarray
    normals: np.ndarray
    square: np.ndarray
    above: np.ndarray

    @classmethod
    def of(cls, vertices: np.ndarray, layer: Mesh) -> _OverLayer:
        """Measure vertices [m], shape [n, 3], over a layer."""
        square, face, nearest = igl.point_mesh_squared_distance(vertices, *layer)
        normals = vertex_normals(*layer)[layer[1][face]].mean(axis=1)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
        return cls(nearest, normals, square, np.einsum("na,na->n", vertices - nearest, normals))

    def put_below(self, mesh: Mesh, chosen: np.ndarray) -> Mesh:
        """Return the mesh with those chosen vertices, bool of shape [n], below the layer that are upright over it."""
        aside = np.sqrt(np.maximum(self.square - self.above**2, 0.0))
        covered = chosen & (self.above > -BELOW) & (aside < 0.5 * np.abs(self.above) + 1e-3)
        vertices = mesh[0].copy()
        vertices[covered] = self.nearest[covered] - BELOW * self.normals[covered]
        return vertices, mesh[1]
