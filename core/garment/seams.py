"""Compute lengths of seams, and make their two sides equal by moving control points as little as possible."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from .curves import unit_length
from .memo import memoise
from .pattern import EdgeRef, Pattern
from .symmetry import Symmetry, find_symmetry

MIN_SINGULAR_VALUE_SHARE = 0.05
"""Share of the largest singular value below which others are dropped: those of seams that depend on others (a chain
that closes), or repeat those of the wearer's other side up to a file's rounding, which could be closed only by moving
points 20 times as far as they differ. 40 patterns of four makers have none between 1e-9 and 0.15, with 1 mm of noise up
to 0.02; at 0.001 noise of 0.1 mm moved points by decimetres."""

PATTERN_SYMMETRY_TOLERANCE = 1e-6
"""Largest distance of a point from its image at which a pattern is symmetric [m]."""

Sides = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class SeamSettings:
    """Describe the iteration that makes both sides of seams equal.

    Attributes:
        tolerance: Largest mismatch that ends it [m]; a hundredth of the accuracy that is required (0.1 mm).
        iterations: Largest number of Gauss-Newton steps; it converges in 3 to 5 from mismatches of centimetres.
        trials: Largest number of lengths of a step that are tried, each half of the one before.
    """

    tolerance: float = 1e-6
    iterations: int = 30
    trials: int = 6


def find_sewn_partners(pattern: Pattern) -> dict[EdgeRef, EdgeRef]:
    """Return the edge that each sewn edge is sewn to."""
    return {seam.a: seam.b for seam in pattern.seams} | {seam.b: seam.a for seam in pattern.seams}


def seam_lengths(pattern: Pattern) -> np.ndarray:
    """Return the lengths of both sides of every seam [m], shape [seam_count, 2]."""
    (starts, ends, factors), points = seam_sides(pattern), pattern.points
    return np.asarray(factors * np.linalg.norm(points[ends] - points[starts], axis=-1))


def seam_mismatch(pattern: Pattern) -> float:
    """Return the largest difference [m] between the two sides of an ungathered seam; 0 where there is none."""
    lengths = seam_lengths(pattern)
    apart = (lengths[:, 0] - lengths[:, 1])[~pattern.gathered]
    return float(np.abs(apart).max(initial=0.0))


def equalise_seams(
    pattern: Pattern,
    fixed: Iterable[tuple[str, int]] = (),
    base: Pattern | None = None,
    symmetry: Symmetry | None = None,
    settings: SeamSettings = SeamSettings(),
) -> Pattern:
    """Move control points as little as possible until the sides of every seam match.

    Gauss-Newton with the least-norm step on the constraints, for each seam s with sides a, b and ratio q:

        l_a - q_s l_b = 0,    l = f |c1 - c0|

    f: an edge's length over its chord, constant as handles are relative. q is 1, or for a gathered seam its ratio in
    `base`. A step is halved until it reduces the mismatch, and is the last one where it does not. A pattern with the
    symmetry of `base` keeps it, except for seams that cannot be closed so, as their sides differ by a file's rounding.

    Args:
        pattern: What to change.
        fixed: (panel name, control point) that must not move.
        base: The pattern with the ratios of gathered seams and the symmetry, such as the template; default: pattern.
        symmetry: The symmetry to keep, where it is not that of `base`.
        settings: Steps and their end.

    Returns:
        The changed pattern; `seam_mismatch` gives the rest where fixed points contradict the seams.
    """
    if not pattern.seams:
        return pattern
    base = base or pattern
    symmetry = symmetry or find_symmetry(base)
    sides, ratio = seam_sides(pattern), seam_ratios(base)
    points = _close(pattern.points, _free_coordinates(pattern, symmetry, fixed), sides, ratio, settings)
    if np.abs(_mismatch(points, sides, ratio)[0]).max() > settings.tolerance:
        points = _close(points, _free_coordinates(pattern, None, fixed), sides, ratio, settings)
    return pattern.with_points(points)


def _close(points: np.ndarray, free: np.ndarray, sides: Sides, ratio: np.ndarray, settings: SeamSettings) -> np.ndarray:
    """Return points [m] moved along free coordinates, shape [2 point_count, n], until both sides of seams match."""
    residual, jacobian = _mismatch(points, sides, ratio)
    for _ in range(settings.iterations):
        if np.abs(residual).max() < settings.tolerance:
            break
        step = free @ np.linalg.lstsq(jacobian @ free, -residual, rcond=MIN_SINGULAR_VALUE_SHARE)[0]
        for _ in range(settings.trials):
            moved = points + step.reshape(-1, 2)
            new_residual, new_jacobian = _mismatch(moved, sides, ratio)
            if (new_residual**2).sum() < 0.99 * (residual**2).sum():
                break
            step = step / 2.0
        else:
            break
        points, residual, jacobian = moved, new_residual, new_jacobian
    return points


def seam_constraints(
    pattern: Pattern, points: np.ndarray | None = None, base: Pattern | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the mismatch of every seam [m], shape [seam_count], and its derivative by all coordinates x0, y0, x1, ...
    An edge follows its chord by a similarity, so the mismatch is l_a - q_s l_b = f_a |c_a| - q_s f_b |c_b|, and its
    derivative along a chord is the chord's direction times f.

    Args:
        pattern: Whose seams.
        points: Control points at which both are computed [m], shape [point_count, 2]; None for the pattern's own.
        base: The pattern with the ratios of gathered seams, as in `equalise_seams`; None for the pattern itself.

    Returns:
        Mismatches, and derivatives of shape [seam_count, 2 point_count].
    """
    return _mismatch(pattern.points if points is None else points, seam_sides(pattern), seam_ratios(base or pattern))


def seam_ratios(pattern: Pattern) -> np.ndarray:
    """Return the planned ratio of the lengths of both sides of each seam, 1 unless gathered, shape [seam_count]."""
    lengths = seam_lengths(pattern)
    return np.where(pattern.gathered, lengths[:, 0] / lengths[:, 1], 1.0)


def _mismatch(points: np.ndarray, sides: Sides, ratio: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mismatch of every seam [m], shape [n], and its derivative by all coordinates, shape [n, 2 points]."""
    starts, ends, factors = sides
    chord = points[ends] - points[starts]
    length = np.linalg.norm(chord, axis=-1)
    residual = factors[:, 0] * length[:, 0] - ratio * factors[:, 1] * length[:, 1]
    slope = (factors * np.stack([np.ones_like(ratio), -ratio], axis=1) / length)[..., None] * chord
    jacobian = np.zeros((len(ratio), len(points), 2))
    row = np.arange(len(ratio))
    for side in range(2):
        np.add.at(jacobian, (row, ends[:, side]), slope[:, side])
        np.add.at(jacobian, (row, starts[:, side]), -slope[:, side])
    return residual, jacobian.reshape(len(ratio), -1)


def _free_coordinates(pattern: Pattern, symmetry: Symmetry | None, fixed: Iterable[tuple[str, int]]) -> np.ndarray:
    """Return an orthonormal basis of the allowed motions, so that the least norm is that of all points' motion."""
    points = pattern.points
    allowed = np.eye(2 * len(points))
    if (
        symmetry is not None
        and np.abs(symmetry.expand(symmetry.reduce(points)) - points).max() < PATTERN_SYMMETRY_TOLERANCE
    ):
        allowed = symmetry.matrix.toarray()
    fixed_coordinates = [2 * (pattern.first_points[name] + index) + axis for name, index in fixed for axis in (0, 1)]
    if fixed_coordinates:
        _, values, right = np.linalg.svd(allowed[fixed_coordinates])
        rank = int((values > 1e-9).sum())
        allowed = allowed @ right[rank:].T
    left, values, _ = np.linalg.svd(allowed, full_matrices=False)
    return left[:, values > 1e-9]


@memoise
def seam_sides(pattern: Pattern) -> Sides:
    """Return first and last control point and length over chord of both sides of each seam, shape [seam_count, 2]."""
    sides = [
        [(*pattern.ends_of(ref), unit_length(pattern.panel(ref.panel).edges[ref.edge])) for ref in (seam.a, seam.b)]
        for seam in pattern.seams
    ]
    found = np.array(sides, float).reshape(-1, 2, 3)
    return found[..., 0].astype(np.int64), found[..., 1].astype(np.int64), found[..., 2]
