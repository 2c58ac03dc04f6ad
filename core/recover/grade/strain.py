"""Estimate the strain of the cloth on a target at the resolution of a coarse mesh."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ...garment.garment import Garment
from ...geometry.geometry import signed_areas
from ...geometry.intersections import self_intersections
from .flattening import garment_stretch, narrow_panels

MIN_COARSE_LENGTH_RATIO = 0.8
"""Smallest ratio of a coarse edge's length to that of the folds under it; tighter folds are errors of registration."""


def clamp_stretch(coarse: Garment, drape: Garment, limit: float) -> np.ndarray:
    """Return a drape's right stretch around each face of a coarse mesh, clipped, shape [face_count, 2, 2].

    Narrow panels keep it unclipped, as in grading: a band is cut shorter than what it holds.

    Args:
        coarse: A mesh of the drape's pattern; its nodes are not used.
        drape: The drape.
        limit: Largest strain assumed for woven cloth.
    """
    values, axes = np.linalg.eigh(_mean_square(coarse, drape, garment_stretch(drape, drape.nodes)))
    values = np.sqrt(values)
    narrow = narrow_panels(coarse.pattern)[coarse.panel_of_face]
    return _compose_symmetric(np.where(narrow[:, None], values, np.clip(values, 1.0 - limit, 1.0 + limit)), axes)


def subgrid_stretch(coarse: Garment, fine: Garment, registered: np.ndarray) -> np.ndarray:
    """Return the shortening of registered cloth's folds by the coarse mesh as a stretch, shape [face_count, 2, 2].

    With C and D the squared stretches of the fine mesh, averaged, and of the coarse one, it is the symmetric H for
    which H C H = D; clipped to `MIN_COARSE_LENGTH_RATIO` and to no lengthening. Around cloth that crosses itself it is
    1: crossings are crumples of the registration, or another layer, and no folds of the scan.
    """
    square = _mean_square(coarse, fine, garment_stretch(fine, registered))
    found = _mean_square(coarse, coarse, garment_stretch(coarse, coarse.nodes))
    root = _power(square, 0.5)
    back = np.linalg.inv(root)
    hidden = back @ _power(root @ found @ root, 0.5) @ back
    values, axes = np.linalg.eigh(hidden)
    folds = _compose_symmetric(np.clip(values, MIN_COARSE_LENGTH_RATIO, 1.0), axes)
    folds[_find_crossed(coarse, fine, registered)] = np.eye(2)
    return folds


def _find_crossed(coarse: Garment, fine: Garment, registered: np.ndarray) -> np.ndarray:
    """Find the coarse faces around which faces of the registered fine mesh cross, bool, shape [face_count]."""
    middles, crossed = coarse.rest.mean(axis=1), np.zeros(len(coarse.uv), dtype=bool)
    for face in self_intersections(registered, fine.faces):
        there = np.flatnonzero(coarse.panel_of_face == fine.panel_of_face[face])
        distance = np.linalg.norm(middles[there] - fine.rest[face].mean(axis=0), axis=1)
        crossed[coarse.uv_faces[there[int(np.argmin(distance))]]] = True
    return np.asarray(crossed[coarse.uv_faces].any(axis=1))


def _mean_square(coarse: Garment, fine: Garment, stretch: np.ndarray) -> np.ndarray:
    """Average the squares of a fine mesh's stretches around each face of a coarse one, shape [face_count, 2, 2].

    Both are meshes of one pattern. A fine face counts for the coarse face with the nearest middle, and this for its
    three corners: 3 cm around, which smooths crumples of the registration.
    """
    square, middles = stretch @ stretch, coarse.rest.mean(axis=1)
    total = np.zeros((len(coarse.uv), 2, 2))
    weight = np.zeros(len(coarse.uv))
    area = np.abs(signed_areas(fine.rest))
    for panel in range(len(coarse.pattern.panels)):
        rows, other = np.flatnonzero(fine.panel_of_face == panel), np.flatnonzero(coarse.panel_of_face == panel)
        nearest = other[cKDTree(middles[other]).query(fine.rest[rows].mean(axis=1))[1]]
        for corner in coarse.uv_faces[nearest].T:
            np.add.at(total, corner, area[rows, None, None] * square[rows])
            np.add.at(weight, corner, area[rows])
    empty = weight == 0.0
    total[empty], weight[empty] = np.eye(2), 1.0
    return np.asarray((total / weight[:, None, None])[coarse.uv_faces].mean(axis=1))


def _power(square: np.ndarray, power: float) -> np.ndarray:
    """Raise symmetric positive matrices to a power, shape [n, 2, 2]."""
    values, axes = np.linalg.eigh(square)
    return _compose_symmetric(values**power, axes)


def _compose_symmetric(values: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return the symmetric matrices with these eigenvalues and eigenvectors, shape [n, 2, 2]."""
    return np.asarray((axes * values[:, None, :]) @ np.swapaxes(axes, 1, 2))
