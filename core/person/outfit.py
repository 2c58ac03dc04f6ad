"""Which garments are worn: the likely readings of one scan, and the posterior as each of them reads it."""

from __future__ import annotations

from itertools import product

import numpy as np

from ..body import JOINTS, Body
from .limbs import BodyPlace
from .part import GARMENTS, PARTS, Part
from .separation import Outfit

READINGS: tuple[tuple[tuple[Part, ...], float], ...] = (
    ((Part.UPPER, Part.LOWER), 0.0),
    ((Part.ONE_PIECE,), -1.0),
    ((Part.UPPER,), -3.0),
    ((Part.LOWER,), -3.0),
)
"""What people wear below an outer layer, each with its log-probability before anything is seen, up to a constant:
a third as many dresses as tops with something below; a top or a bottom alone is one person in twenty."""

OUTER = -3.0
"""Log-odds of an outer layer before anything is seen: people are scanned indoors."""

WAIST = 0.10
"""Height of the waist line over the hip joints on the T-pose [m]: where a dress would be cut in two."""

PATCHES = 12.0
"""Independent observations that all points of a scan count as: what the geometry takes for a dress it does so on all of
it at once, so that thousands of points say little more than a dozen would."""

FAINT = 0.05
"""Probability of upper and lower together up to which the waist line decides where a dress is cut, and not they."""

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
        share = (posterior[:, upper] + FAINT * above) / (both + FAINT)
        read[:, upper] += posterior[:, whole] * share
        read[:, lower] += posterior[:, whole] * (1.0 - share)
    read[:, [COLUMN[part] for part in GARMENTS if part not in outfit]] = 0.0
    return read


def above_waist(place: BodyPlace, body: Body) -> np.ndarray:
    """Return the probability that each point lies above the waist line, shape [n]."""
    hips = 0.5 * (body.rest_joints[JOINTS.index("left_hip"), 1] + body.rest_joints[JOINTS.index("right_hip"), 1])
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip((place.rest[:, 1] - hips - WAIST) / 0.02, -30.0, 30.0))))


def rank_outfits(
    posterior: np.ndarray,
    above: np.ndarray,
    wearing: tuple[Part, ...] | None = None,
    marked: tuple[Part, ...] = (),
) -> tuple[Outfit, ...]:
    """Return the readings, the likeliest first.

    score(H) = log p(H) + `PATCHES` mean_i log sum_k p(k | i), k over what H names itself: a point that looks like a
    dress speaks for the dress and not for top and skirt.

    Args:
        posterior: Of the samples, which are even, shape [n, part_count].
        above: Probability that a point lies above the waist line, shape [n].
        wearing: The garments where they are known: then the only reading.
        marked: Garments that every reading must have.
    """
    if wearing is not None:
        return (Outfit(wearing, 0.0),)
    bare = [COLUMN[part] for part in PARTS if part not in GARMENTS]
    found = []
    for (inner, prior), outer in product(READINGS, (False, True)):
        outfit = tuple(part for part in GARMENTS if part in inner or (outer and part is Part.OUTER))
        allowed = posterior[:, bare + [COLUMN[part] for part in outfit]].sum(axis=1)
        score = prior + OUTER * outer + PATCHES * float(np.log(np.maximum(allowed, FLOOR)).mean())
        found.append(Outfit(outfit, score))
    fitting = [outfit for outfit in found if set(marked) <= set(outfit.parts)]
    return tuple(sorted(fitting or [Outfit(marked, 0.0)], key=lambda outfit: -outfit.score))
