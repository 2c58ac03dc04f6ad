"""Compute the rest metric of the strain term: the stretch of the panels without grading errors."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from ...geometry.connectivity import HalfEdges
from ...geometry.linear import factor_symmetric

MIN_REST_STRETCH, MAX_REST_STRETCH = 0.6, 1.6
"""Bounds on a smoothed stretch [1]: a panel that is off by more was graded wrongly, and must not be copied."""


class RestMetric:
    """Compute the surface's own stretch, smoothed within each panel over a given length.

    The deformation gradient F of a face (flat panel to 3D) has the metric C = F^T F. Let C be smoothed over the panel,
        (I + s^2 D) Cs = C,  D the area-weighted Laplacian of the faces' adjacency within the panel,
    with s the smoothing length. Strain is then measured against the stretch S = Cs^(1/2) instead of the identity, so
    that it resists what varies faster than s (collapsed and sheared triangles) and not a panel that is 20 % too wide.

    Attributes:
        areas: Rest areas [m2], shape [face_count].
        stretch: S of each face, shape [face_count, 2, 2].
        undo: Its inverse, shape [face_count, 2, 2].

    **Deviation** from thesis eq. 4.5, where the rest shape is the flat panel (scale 0 here).
    """

    def __init__(self, faces: np.ndarray, panel_of_face: np.ndarray, areas: np.ndarray, scale: float) -> None:
        self._solve = None
        self.areas = areas
        self.stretch = np.tile(np.eye(2), (len(faces), 1, 1))
        self.undo = self.stretch.copy()
        if scale <= 0:
            return
        pairs = HalfEdges.of(faces).pairs // 3
        pairs = pairs[panel_of_face[pairs[:, 0]] == panel_of_face[pairs[:, 1]]]
        # on an equilateral mesh edge length over centre distance is sqrt(3): the finite-volume weight of a dual edge
        weight = np.full(len(pairs), np.sqrt(3.0))
        first, second = pairs[:, 0], pairs[:, 1]
        link = sp.csr_matrix((weight, (first, second)), shape=(len(faces),) * 2)
        link = link + link.T
        laplacian = sp.diags(np.asarray(link.sum(axis=1)).ravel()) - link
        self._solve = factor_symmetric(sp.diags(areas) + scale**2 * laplacian).solve

    def follow(self, jacobians: np.ndarray) -> None:
        """Set the stretch from the current 3x2 Jacobians, shape [face_count, 3, 2]."""
        if self._solve is None:
            return
        metric = np.einsum("fki,fkj->fij", jacobians, jacobians)
        flat = np.stack([metric[:, 0, 0], metric[:, 0, 1], metric[:, 1, 1]], axis=1)
        smooth = self._solve(self.areas[:, None] * flat)
        metric = np.stack([smooth[:, 0], smooth[:, 1], smooth[:, 1], smooth[:, 2]], axis=1).reshape(-1, 2, 2)
        values, vectors = np.linalg.eigh(metric)
        values = np.clip(np.sqrt(np.maximum(values, 0.0)), MIN_REST_STRETCH, MAX_REST_STRETCH)
        self.stretch = np.einsum("fik,fk,fjk->fij", vectors, values, vectors)
        self.undo = np.einsum("fik,fk,fjk->fij", vectors, 1 / values, vectors)
