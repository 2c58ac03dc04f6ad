"""What the user locks: panels that the fit leaves as they were graded."""

from __future__ import annotations

import numpy as np

from ..errors import BadInput
from ..pattern import Pattern, equalise_seams, find_symmetry

_ROUNDS = 40
"""Most turns between equal seams and held panels; each halves what is left, so 40 take a decimetre below 1e-12 m."""


class LockUnknown(BadInput):
    """A lock names no panel of the pattern; `garmentq templates show NAME` lists its panels."""

    code = "fit.lock_unknown"


def find_held(pattern: Pattern, like: Pattern, locks: tuple[str, ...]) -> np.ndarray:
    """Tell which effective coordinates locks hold, shape [p]: those of locked panels and of their mirror images.

    Raises:
        LockUnknown: where a lock names no panel.
    """
    names = [panel.name for panel in pattern.panels]
    wanted = [word.removeprefix("panel:") for word in locks if word.startswith("panel:")]
    for name in wanted:
        if name not in names:
            raise LockUnknown(f"the lock 'panel:{name}' names no panel of the pattern; it has {', '.join(names)}.")
    locked = np.zeros(len(pattern.points), dtype=bool)
    for name in wanted:
        index = names.index(name)
        first = int(pattern.point_starts[index])
        locked[first : first + len(pattern.panels[index].points)] = True
    rows = find_symmetry(like).matrix.toarray()[np.repeat(locked, 2)]
    return np.asarray((rows != 0.0).any(axis=0))


def keep_held(pattern: Pattern, start: Pattern, like: Pattern, held: np.ndarray) -> Pattern:
    """Give the pattern with held effective coordinates as in `start`, its other seams made equal to them."""
    symmetry = find_symmetry(like)
    fixed = symmetry.reduce(start.points).ravel()[held]
    for _ in range(_ROUNDS):
        effective = symmetry.reduce(pattern.points).ravel()
        away = float(np.abs(effective[held] - fixed).max())
        effective[held] = fixed
        held_pattern = like.with_points(symmetry.expand(effective))
        if away < 1e-9:
            return held_pattern
        pattern = equalise_seams(held_pattern, like=like, symmetry=symmetry)
    return held_pattern
