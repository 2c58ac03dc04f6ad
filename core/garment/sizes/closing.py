"""Make the seams of a size equal while its figures stay: the ease of caps is kept in metres, gathers by ratio."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..panel_parts import find_arm_panels
from ..pattern import Pattern, Seam
from ..seams import seam_constraints
from ..symmetry import find_symmetry

CLOSED_SEAM_TOLERANCE = 1e-6
"""Largest mismatch of a seam or a figure that ends the search [m]: a hundredth of what can be sewn."""

MAX_CLOSING_STEP_COUNT = 20
"""Largest number of Gauss-Newton steps; four to six are taken."""

MIN_CLOSING_SHARE = 0.01
"""Share of the largest singular value below which constraints are taken for combinations of others: the cap of a flat
sleeve changes its length by a quarter of the change of its height, so true ones are above 0.05."""

SYMMETRIC_SIZE_TOLERANCE = 1e-6
"""Largest distance of a point from its image at which a size is symmetric [m]."""


def find_eased_seams(pattern: Pattern) -> np.ndarray:
    """Return which seams join a cap and its armhole, shape [seam_count]."""
    arms = find_arm_panels(pattern)
    return np.array([(seam.a.panel in arms) != (seam.b.panel in arms) for seam in pattern.seams], dtype=bool)


def measure_ease(pattern: Pattern) -> np.ndarray:
    """Return how much longer each cap is than its armhole [m], shape [cap_seam_count]."""
    eased = find_eased_seams(pattern)
    arms = find_arm_panels(pattern)
    signs = np.array([1.0 if seam.a.panel in arms else -1.0 for seam in pattern.seams])
    found: np.ndarray = (signs * seam_constraints(_ease(pattern))[0])[eased] if len(eased) else np.zeros(0)
    return found


def close_seams(pattern: Pattern, base: Pattern, rows: np.ndarray) -> Pattern:
    """Move control points as little as possible until seams fit as those of the base, figures kept.

    Gauss-Newton with the least-norm step on l_a - q l_b = e for each seam and on the figures' rows. q is the base's
    ratio of gathered seams, else 1; e its ease where a cap is sewn to an armhole, else 0. A symmetric size of a
    symmetric base stays so.

    Args:
        pattern: The size.
        base: The pattern that it is graded from.
        rows: Derivatives of the figures, shape [figure_count, 2 point_count].
    """
    if not pattern.seams:
        return pattern
    plain, plain_base = _ease(pattern), _ease(base)
    ease = np.where(find_eased_seams(base), seam_constraints(plain_base)[0], 0.0)
    points = pattern.points
    figures = rows @ points.ravel()
    symmetry = find_symmetry(base)
    free = np.eye(2 * len(points))
    if np.abs(symmetry.expand(symmetry.reduce(points)) - points).max() < SYMMETRIC_SIZE_TOLERANCE:
        left, values, _ = np.linalg.svd(symmetry.matrix.toarray(), full_matrices=False)
        free = left[:, values > 1e-9]
    for _ in range(MAX_CLOSING_STEP_COUNT):
        mismatch, slopes = seam_constraints(plain, points, plain_base)
        residual = np.concatenate([mismatch - ease, rows @ points.ravel() - figures])
        if np.abs(residual).max() < CLOSED_SEAM_TOLERANCE:
            break
        step = np.linalg.lstsq(np.concatenate([slopes, rows]) @ free, -residual, rcond=MIN_CLOSING_SHARE)[0]
        points = points + (free @ step).reshape(-1, 2)
    return pattern.with_points(points)


def _ease(pattern: Pattern) -> Pattern:
    """Return a pattern whose caps do not count as gathered."""
    eased = find_eased_seams(pattern)
    seams: tuple[Seam, ...] = tuple(
        replace(seam, gathered=seam.gathered and not cap) for seam, cap in zip(pattern.seams, eased, strict=True)
    )
    return replace(pattern, seams=seams)
