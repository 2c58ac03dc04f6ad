"""Compute how far flat panels are from isometric to the cloth on a scan, and the strain that a dart would take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...garment.garment import Garment
from ...geometry.geometry import deformation_gradients, gradient_operator, shape_gradients, signed_areas
from ...geometry.linear import Factor, factor_symmetric

PANEL_REGULARISATION_SHARE = 1e-9
"""Share of the matrix' mean diagonal added to its diagonal, against a panel's rigid motions, which have no load."""


@dataclass(frozen=True)
class Wedge:
    """Describe a possible dart of a panel.

    Attributes:
        mouth: Middle of its mouth, on the panel's outline [m], shape [2].
        apex: Its end within the panel [m], shape [2].
    """

    mouth: np.ndarray
    apex: np.ndarray

    @property
    def length(self) -> float:
        """Return the distance of the apex from the mouth [m]."""
        return float(np.linalg.norm(self.apex - self.mouth))


def wanted_strain(garment: Garment, strain: np.ndarray) -> np.ndarray:
    """Return the strain of each flat face relative to the one that its cloth in space needs, shape [face_count, 2, 2].

    With F the map from the flat face to space, U the estimated strain of the cloth and R the isometry nearest to F U,
    the cloth needs J = U^-1 R^T F; the symmetric part of J - I is returned.

    Args:
        garment: The flat panels and their nodes on the target.
        strain: U, shape [face_count, 2, 2].
    """
    slope = deformation_gradients(garment.nodes, garment.faces, garment.rest)
    left, _, right = np.linalg.svd(slope @ strain, full_matrices=False)
    target = np.linalg.solve(strain, np.swapaxes(left @ right, 1, 2) @ slope)
    return np.asarray(0.5 * (target + np.swapaxes(target, 1, 2)) - np.eye(2))


@dataclass(frozen=True)
class FlatPanel:
    """Describe the strain of one panel that no flat shape of it takes.

    To first order a panel whose vertices move by u misses the wanted strain e by sum_f A_f |e_f - sym(grad u)_f|^2. Its
    least over u is the remaining strain; a dart is a jump of u.

    Attributes:
        uv: Flat vertices [m], shape [vertex_count, 2].
        faces: Indices into `uv`, shape [face_count, 3].
        operator: From u (x0, y0, ...) to strains (xx, yy, sqrt(2) xy) times root area, [3 face_count, 2 vertex_count].
        factor: Of operator^T operator.
        left: The remaining strain, in the operator's units, shape [3 face_count].
        motion: The u of the least strain [m], shape [vertex_count, 2].
    """

    uv: np.ndarray
    faces: np.ndarray
    operator: sp.csr_matrix
    factor: Factor
    left: np.ndarray
    motion: np.ndarray

    @classmethod
    def of(cls, uv: np.ndarray, faces: np.ndarray, strain: np.ndarray) -> FlatPanel:
        """Relax a panel.

        Args:
            uv: Flat vertices [m], shape [vertex_count, 2].
            faces: Indices into `uv`, shape [face_count, 3].
            strain: Wanted strain of each face, symmetric, shape [face_count, 2, 2].
        """
        gradient, area = gradient_operator(uv[faces], faces, len(uv))
        across, up = gradient[0::2].tocoo(), gradient[1::2].tocoo()
        half = np.sqrt(0.5)
        rows, columns, values = [], [], []
        for row, axis, part, share in (
            (0, 0, across, 1.0),
            (1, 1, up, 1.0),
            (2, 0, up, half),
            (2, 1, across, half),
        ):
            rows.append(3 * part.row + row)
            columns.append(2 * part.col + axis)
            values.append(share * part.data * np.sqrt(area[part.row]))
        shape = (3 * len(faces), 2 * len(uv))
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        operator = sp.csr_matrix(entries, shape=shape)
        matrix = sp.csc_matrix(operator.T @ operator)
        factor = factor_symmetric(
            matrix + PANEL_REGULARISATION_SHARE * matrix.diagonal().mean() * sp.identity(shape[1], format="csc")
        )
        target = _to_mandel(strain, area)
        motion = factor.solve(operator.T @ target)
        return cls(uv, faces, operator, factor, target - operator @ motion, motion.reshape(-1, 2))

    def jump(self, wedge: Wedge) -> tuple[np.ndarray, np.ndarray]:
        """Return the effect on faces of a wedge of one radian, opened to the left of its axis seen from the mouth.

        Returns:
            The faces that the axis cuts, shape [n]; motions of their corners left of it before the apex [m], [n, 3, 2].
        """
        axis = (wedge.apex - wedge.mouth) / wedge.length
        offset = self.uv - wedge.apex
        along, side = (offset @ axis)[self.faces], (axis[0] * offset[:, 1] - axis[1] * offset[:, 0])[self.faces]
        is_left = side > 0.0
        cut = is_left.any(axis=1) & ~is_left.all(axis=1) & (along.min(axis=1) < 0.0)
        faces = np.flatnonzero(cut)
        moves = is_left[faces] & (along[faces] < 0.0)
        # Below the apex the left side turns clockwise about it, away from the axis.
        turned = np.stack([offset[:, 1], -offset[:, 0]], axis=1)[self.faces[faces]]
        return faces, np.where(moves[..., None], turned, 0.0)

    def loads(self, wedges: Sequence[Wedge]) -> np.ndarray:
        """Return the strain of the faces by each of some wedges of one radian, shape [3 face_count, count]."""
        gradients, area = shape_gradients(self.uv[self.faces]), np.abs(signed_areas(self.uv[self.faces]))
        found = np.zeros((3 * len(self.faces), len(wedges)))
        for k, wedge in enumerate(wedges):
            faces, jump = self.jump(wedge)
            slope = np.einsum("fci,fcj->fij", jump, gradients[faces])
            strain = 0.5 * (slope + np.swapaxes(slope, 1, 2))
            rows = (3 * faces[:, None] + np.arange(3)).reshape(-1)
            found[rows, k] = _to_mandel(strain, area[faces])
        return found

    def respond(self, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return wedges' effect on the remaining strain: its square falls by 2 a p - a^2 s at an angle a [rad].

        Args:
            loads: Of the wedges, shape [3 face_count, count].

        Returns:
            Pull p and stiffness s of each [m2], shape [count] each.
        """
        right = self.operator.T @ loads
        stiffness = (loads**2).sum(axis=0) - (right * self.factor.solve(right)).sum(axis=0)
        # Vertices on both sides of an open dart are further apart without strain: its load is no strain of theirs.
        return -loads.T @ self.left, stiffness


def _to_mandel(strain: np.ndarray, area: np.ndarray) -> np.ndarray:
    """Return symmetric strains as (xx, yy, sqrt(2) xy) times the root of the area, shape [3 face_count]."""
    found = np.stack([strain[:, 0, 0], strain[:, 1, 1], np.sqrt(2.0) * strain[:, 0, 1]], axis=1)
    mandel: np.ndarray = (np.sqrt(area)[:, None] * found).ravel()
    return mandel
