"""Apply the user's locks: panels and single control points that the fit leaves as they were graded."""

from __future__ import annotations

import numpy as np

from ...garment.pattern import Pattern
from ...garment.seams import equalise_seams
from ...garment.symmetry import find_symmetry
from ...geometry.rigid import fit_rigid
from ...run.errors import BadInput
from ..case import Case
from ..state import RecoveryState, made

_MAX_LOCK_ITERATIONS = 40
"""Largest number of alternations between equal seams and locked points; each halves the error, 1 dm to 1e-12 m."""


class LockUnknown(BadInput):
    """A lock names no panel or point of the pattern; `garmentq templates show NAME` lists its panels."""

    code = "fit.lock_unknown"


def locks_of(case: Case, state: RecoveryState) -> tuple[str, ...]:
    """Return the user's locks, and that of the fabric where the cloth was in motion, which gives no evidence of it."""
    locks, drape = case.settings.locks, state.drape
    return locks if drape is None or drape.rotation is None else (*locks, "fabric")


def fit_reference(case: Case, state: RecoveryState) -> Pattern:
    """Return the pattern whose symmetry, proportions and curves a fit keeps: the graded one where curves are free."""
    return made(state.graded).pattern if case.has_free_curves else state.base


def find_locked_coordinates(pattern: Pattern, base: Pattern, locks: tuple[str, ...]) -> np.ndarray:
    """Return which effective coordinates are locked, shape [p]: of locked panels, points and their mirror images.

    Args:
        pattern: The pattern that is fitted.
        base: The template, which gives the symmetry.
        locks: `panel:NAME` and `point:PANEL/INDEX`, the point where edge INDEX begins, from 0; others are ignored.

    Raises:
        LockUnknown: where a lock names no panel, or no control point of its panel.
    """
    locked = np.zeros(len(pattern.points), dtype=bool)
    for word in locks:
        kind, _, name = word.partition(":")
        if kind == "panel":
            locked[_points_of(pattern, name, word)] = True
        elif kind == "point":
            panel, _, index = name.rpartition("/")
            points = _points_of(pattern, panel, word)
            count = points.stop - points.start
            if not index.isdecimal() or int(index) >= count:
                raise LockUnknown(
                    f"the lock '{word}' names no control point: '{panel}' has those from 0 to {count - 1}."
                )
            locked[points.start + int(index)] = True
    rows = find_symmetry(base).matrix.toarray()[np.repeat(locked, 2)]
    return np.asarray((rows != 0.0).any(axis=0))


def _points_of(pattern: Pattern, name: str, word: str) -> slice:
    """Return the slice of a panel's control points in `Pattern.points`."""
    names = [panel.name for panel in pattern.panels]
    if name not in names:
        raise LockUnknown(f"the lock '{word}' names no panel of the pattern; it has {', '.join(names)}.")
    index = names.index(name)
    return slice(int(pattern.point_starts[index]), int(pattern.point_starts[index + 1]))


def restore_locked(pattern: Pattern, start: Pattern, base: Pattern, locked: np.ndarray) -> Pattern:
    """Return the pattern with locked effective coordinates as in `start`, its other seams made equal to them.

    A panel with some locked points is first moved rigidly onto them: its flat place has no meaning.
    """
    symmetry = find_symmetry(base)
    fixed = symmetry.reduce(start.points).ravel()[locked]
    pattern = _align_to_locked(pattern, start, base, locked)
    for _ in range(_MAX_LOCK_ITERATIONS):
        effective = symmetry.reduce(pattern.points).ravel()
        error = float(np.abs(effective[locked] - fixed).max())
        effective[locked] = fixed
        with_locks = base.with_points(symmetry.expand(effective))
        if error < 1e-9:
            return with_locks
        pattern = equalise_seams(with_locks, base=base, symmetry=symmetry)
    return with_locks


def find_locked_points(base: Pattern, locked: np.ndarray) -> np.ndarray:
    """Return which control points locked effective coordinates leave no freedom, bool, shape [point_count]."""
    follows = abs(find_symmetry(base).matrix) @ (~locked).astype(float)
    found: np.ndarray = (follows.reshape(-1, 2) == 0.0).all(axis=1)
    return found


def _align_to_locked(pattern: Pattern, start: Pattern, base: Pattern, locked: np.ndarray) -> Pattern:
    """Move each panel rigidly so that its locked points are nearest to those of `start`, by least squares."""
    is_locked = find_locked_points(base, locked)
    points, goal = pattern.points.copy(), start.points
    for first, end in zip(pattern.point_starts[:-1], pattern.point_starts[1:], strict=True):
        panel_points = np.arange(first, end)[is_locked[first:end]]
        if not 0 < len(panel_points) < end - first:
            continue
        points[first:end] = fit_rigid(points[panel_points], goal[panel_points]).apply(points[first:end])
    return pattern.with_points(points)
