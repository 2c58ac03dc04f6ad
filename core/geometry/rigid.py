"""The rigid or similarity motion that fits points to their counterparts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class RigidMotion:
    """Describe x -> s R (x - a) + b: `rotation` R, orthogonal, shape [d, d], `scale` s (1 for a rigid motion),
    `source_centre` a [m] and `target_centre` b [m], shape [d] each."""

    rotation: np.ndarray
    scale: float
    source_centre: np.ndarray
    target_centre: np.ndarray

    def apply(self, points: np.ndarray) -> np.ndarray:
        """Move points [m], shape [n, d]."""
        return np.asarray(self.scale * (points - self.source_centre) @ self.rotation.T + self.target_centre)

    @property
    def translation(self) -> np.ndarray:
        """Return t of x -> s R x + t [m], shape [d]."""
        return np.asarray(self.target_centre - self.scale * self.rotation @ self.source_centre)


def plane_rotation(angle: float) -> np.ndarray:
    """Return the matrix of a left turn by an angle [rad], shape [2, 2]."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def fit_rigid(source: np.ndarray, target: np.ndarray, *, scaled: bool = False, mirrored: bool = False) -> RigidMotion:
    """Fit the motion with the least sum of squared distances between moved points and their counterparts.

    Equation: H = sum (y - b)(x - a)^T = U S V^T, R = U diag(1, ..., 1, d) V^T with d such that det R = 1, or -1 where
    mirrored; s = tr(S diag(1, ..., d)) / sum |x - a|^2 where scaled. Source: Umeyama (1991), Least-squares estimation
    of transformation parameters between two point patterns.

    Args:
        source: Points [m], shape [n, d].
        target: The counterpart of each [m], shape [n, d].
        scaled: Fit a scale too (a similarity).
        mirrored: Fit the best reflection; else there is none.
    """
    a, b = source.mean(axis=0), target.mean(axis=0)
    left, values, right = np.linalg.svd((target - b).T @ (source - a))
    last = np.sign(np.linalg.det(left @ right)) * (-1.0 if mirrored else 1.0)
    signs = np.append(np.ones(len(values) - 1), last)
    scale = 1.0
    if scaled:
        spread = float(((source - a) ** 2).sum())
        scale = float(values @ signs) / spread if spread > 0.0 else 1.0
    return RigidMotion((left * signs) @ right, scale, a, b)
