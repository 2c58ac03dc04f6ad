"""Which garments are worn: the likely readings of one scan, and the posterior as each of them reads it."""

from __future__ import annotations

from itertools import product

import numpy as np

from .part import GARMENTS, PARTS, Part
from .separation import Outfit

READINGS: tuple[tuple[Part, ...], ...] = (
    (Part.UPPER, Part.LOWER),
    (Part.ONE_PIECE,),
    (Part.UPPER,),
    (Part.LOWER,),
)
"""What people wear below an outer layer."""

PATCHES = 12.0
"""Independent observations that all points of a scan count as: what the geometry takes for a dress it does so on all of
it at once, so that thousands of points say little more than a dozen would."""

FLOOR = 0.01
"""Least probability of a point under a reading: a bag or a bad spot speaks against each alike."""

COLUMN = {part: k for k, part in enumerate(PARTS)}
"""The column of each part in a posterior."""


def read_as(posterior: np.ndarray, outfit: tuple[Part, ...], above: np.ndarray) -> np.ndarray:
    """Return the posterior where just these garments are worn, shape [n, part_count]; rows sum to 1 or less.

    What looked like a dress is the top above the waist and the skirt below it, and the other way round; other garments
    are not there, and what they had is lost: that is what speaks against the reading.

    Args:
        posterior: Shape [n, part_count].
        outfit: The garments.
        above: Probability that a point lies above the waist line, shape [n].
    """
    upper, lower, whole = (COLUMN[part] for part in (Part.UPPER, Part.LOWER, Part.ONE_PIECE))
    read = posterior.copy()
    if Part.ONE_PIECE in outfit:
        read[:, whole] = posterior[:, [upper, lower, whole]].sum(axis=1)
    else:
        both = posterior[:, upper] + posterior[:, lower]
        share = (posterior[:, upper] + 1e-3 * above) / (both + 1e-3)
        read[:, upper] += posterior[:, whole] * share
        read[:, lower] += posterior[:, whole] * (1.0 - share)
    read[:, [COLUMN[part] for part in GARMENTS if part not in outfit]] = 0.0
    return read


def rank_outfits(
    posterior: np.ndarray, above: np.ndarray, wearing: tuple[Part, ...] | None = None
) -> tuple[Outfit, ...]:
    """Return the readings, the likeliest first.

    score(H) = `PATCHES` mean_i log sum_k p(k | i), k over what H has, where only what H itself names counts: a point
    that looks like a dress speaks for the dress and not for top and skirt.

    Args:
        posterior: Of the samples, which are even, shape [n, part_count].
        above: Probability that a point lies above the waist line, shape [n].
        wearing: The garments where they are known: then the only reading.
    """
    if wearing is not None:
        return (Outfit(wearing, 0.0),)
    bare = [COLUMN[part] for part in PARTS if part not in GARMENTS]
    found = []
    for inner, outer in product(READINGS, (False, True)):
        outfit = (*inner, Part.OUTER) if outer else inner
        allowed = posterior[:, bare + [COLUMN[part] for part in outfit]].sum(axis=1)
        score = PATCHES * float(np.log(np.maximum(allowed, FLOOR)).mean()) - 0.7 * len(outfit)
        found.append(Outfit(tuple(part for part in GARMENTS if part in outfit), score))
    return tuple(sorted(found, key=lambda outfit: -outfit.score))
