"""Predict the parts of a person without learning: rings on unrolled limbs, anatomy, offsets."""

from __future__ import annotations

import numpy as np

from .evidence import PersonRings, find_rings, spread_over
from .features import Features
from .limbs import FOLDED, Limb
from .part import PARTS, Part
from .points import FittedPerson, PersonPoints
from .prior import hair_probability, long_hair, shoe_probability

FLOOR = 0.005
"""Probability that every part keeps everywhere: rules do not know bags and coats."""
TUBE_SHARE = 0.6
"""Share of a skirt's height that spans from leg to leg, at least; trousers span near the crotch alone."""


def predict_by_rules(
    points: PersonPoints, features: Features, fit: FittedPerson, tone: np.ndarray | None = None
) -> np.ndarray:
    """Compute the posterior of the parts at each sample by rules.

    Args:
        points: The samples.
        features: Their description.
        fit: The body fitted to them.
        tone: Evidence for skin by its colour (`skin_evidence`), shape [n], or None.

    Returns:
        Probabilities in the order of `PARTS`, rows sum to 1, shape [n, 8].
    """
    return combine(points, features, fit, find_rings(points, features, fit, tone=tone), tone)


def combine(
    points: PersonPoints, features: Features, fit: FittedPerson, rings: PersonRings, tone: np.ndarray | None = None
) -> np.ndarray:
    """Compute the posterior from the rings, as `predict_by_rules`."""
    count = len(features.values)
    cloth = cloth_probability(rings, features)
    hair = hair_probability(features, fit.body, tone)
    shod = shoe_probability(features)
    shoe = shod * np.maximum(
        *(spread_over(rings, limb, ring, count) for limb, ring in zip(_LEGS, rings.ankles, strict=True))
    )
    below, two = below_waist(rings, count), two_piece_probability(rings)
    out = np.zeros((count, len(PARTS)))
    column = {part: i for i, part in enumerate(PARTS)}
    bare = 1.0 - cloth
    out[:, column[Part.SKIN]] = bare * (1 - shoe) * (1 - hair)
    out[:, column[Part.HAIR]] = bare * (1 - shoe) * hair
    out[:, column[Part.SHOES]] = bare * shoe
    out[:, column[Part.UPPER]] = cloth * two * (1 - below)
    out[:, column[Part.LOWER]] = cloth * two * below
    out[:, column[Part.ONE_PIECE]] = cloth * (1 - two)
    lock = long_hair(points, features, fit.body, hair * bare * (1 - shoe))
    out *= (1 - lock)[:, None]
    out[:, column[Part.HAIR]] += lock
    out += FLOOR
    return np.asarray(out / out.sum(axis=1, keepdims=True))


_ARMS = (Limb.LEFT_ARM, Limb.RIGHT_ARM)
_LEGS = (Limb.LEFT_LEG, Limb.RIGHT_LEG)


def cloth_probability(rings: PersonRings, features: Features) -> np.ndarray:
    """Compute the probability that each sample is cloth: below the neckline, before the ends of sleeves and legs."""
    count = len(features.values)
    cloth = 1.0 - np.clip(2.0 * features.place.parts[:, list(FOLDED).index("head")] - 0.5, 0.0, 1.0)
    for limb, ring in zip(_ARMS + _LEGS, rings.sleeves + rings.hems, strict=True):
        cloth *= 1.0 - spread_over(rings, limb, ring, count)
    grid = rings.grids[Limb.NECK]
    cloth *= grid.at_samples(rings.neckline.beyond(len(grid.seen)), count, 1.0)
    return cloth


def below_waist(rings: PersonRings, count: int) -> np.ndarray:
    """Compute the probability that each sample lies below the best ring between upper and lower, shape [count]."""
    best = rings.waists[0]
    return np.asarray(
        np.max(
            [spread_over(rings, limb, ring, count) for limb, ring in zip(best.limbs, best.rings, strict=True)], axis=0
        )
    )


def two_piece_probability(rings: PersonRings) -> float:
    """Compute the probability that there are an upper and a lower garment and not one piece.

    Trousers are nearly always worn with a top; a skirt is a dress's unless a ring says where it begins.
    """
    score = rings.waists[0].score
    if rings.tube < TUBE_SHARE:
        return 0.95 if score > 0 else 0.85
    return float(1.0 / (1.0 + np.exp(-np.clip(score / 3.0, -30, 30))))
