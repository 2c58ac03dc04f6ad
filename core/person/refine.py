"""Draw the ends of garments by rings through a posterior that was predicted sample by sample."""

from __future__ import annotations

import numpy as np

from .evidence import PersonRings, find_rings
from .features import Features
from .part import GARMENTS, PARTS, Part
from .points import FittedPerson, PersonPoints
from .rules import below_waist, cloth_probability

TRUST = 0.5
"""Share of the log-odds that the rings have beside the posterior they were drawn through."""
LIMIT = 0.005
"""Probabilities nearer to 0 or 1 than this count as this far: neither rings nor posterior overrule all."""

_COLUMN = {part: k for k, part in enumerate(PARTS)}
_GARMENTS = [_COLUMN[part] for part in GARMENTS]


def refine_by_rings(
    posterior: np.ndarray, points: PersonPoints, features: Features, fit: FittedPerson, rings: PersonRings | None = None
) -> tuple[np.ndarray, PersonRings]:
    """Sharpen a posterior at the ends of garments.

    Rings are drawn with the posterior as what is known of each side, in place of the offset, and the edges they cross.
    Then log-odds of clothes against the rest, and of below the waist's ring against above it, are the mean of both.

    Args:
        posterior: Probabilities in the order of `PARTS`, rows sum to 1, shape [n, 8].
        points: The samples.
        features: Their description.
        fit: The body fitted to them.
        rings: The rings where they are known already.

    Returns:
        The posterior, and the rings drawn through it.
    """
    cloth = posterior[:, _GARMENTS].sum(axis=1)
    upper, lower = (posterior[:, _COLUMN[part]] for part in (Part.UPPER, Part.LOWER))
    both = upper + lower
    below = np.where(both > LIMIT, lower / np.maximum(both, LIMIT), 0.5)
    rings = rings or find_rings(points, features, fit, log_odds(cloth))
    fresh = _mean(cloth, cloth_probability(rings, features))
    out = posterior.copy()
    out[:, _GARMENTS] *= (fresh / np.maximum(cloth, 1e-9))[:, None]
    rest = [k for k in range(len(PARTS)) if k not in _GARMENTS]
    out[:, rest] *= ((1 - fresh) / np.maximum(1 - cloth, 1e-9))[:, None]
    if rings.waists[0].score > 0:
        below = _mean(below, below_waist(rings, len(below)))
    pair = out[:, [_COLUMN[Part.UPPER], _COLUMN[Part.LOWER]]].sum(axis=1)
    out[:, _COLUMN[Part.UPPER]], out[:, _COLUMN[Part.LOWER]] = pair * (1 - below), pair * below
    return out / out.sum(axis=1, keepdims=True), rings


def log_odds(chance: np.ndarray) -> np.ndarray:
    """Return log p / (1 - p), p clipped by `LIMIT`, shape as given."""
    chance = np.clip(chance, LIMIT, 1 - LIMIT)
    return np.asarray(np.log(chance / (1 - chance)))


def _mean(ours: np.ndarray, rings: np.ndarray) -> np.ndarray:
    odds = (1 - TRUST) * log_odds(ours) + TRUST * log_odds(rings)
    return np.asarray(1.0 / (1.0 + np.exp(-odds)))
