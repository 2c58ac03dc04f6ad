"""Rank the likely outfits of one scan, and compute the posterior under each."""

from __future__ import annotations

from itertools import product

import numpy as np

from ..body.body import JOINTS, Body
from .coat import Coat
from .confidence import apply_temperature
from .limbs import BodyPlace
from .part import GARMENTS, PARTS, Part
from .separation import Outfit

OUTFIT_READINGS: tuple[tuple[tuple[Part, ...], float], ...] = (
    ((Part.UPPER, Part.LOWER), 0.0),
    ((Part.ONE_PIECE,), 0.0),
    ((Part.UPPER,), -3.0),
    ((Part.LOWER,), -3.0),
)
"""Garments below an outer layer, each with its prior log-probability up to a constant: a top or a bottom alone is one
person in twenty. The ratio of two pieces to one is in the posterior already (`rules.two_piece_probability`)."""

WAIST_LINE_HEIGHT = 0.10
"""Height of the waist line, where a dress would be cut in two, over the hip joints on the T-pose [m]."""

INDEPENDENT_OBSERVATION_COUNT = 12.0
"""Number of independent observations that all points of a scan count as: errors are alike over a limb or a side of the
trunk, so that thousands of points have little more information than a dozen."""

OUTER_LAYER_SHARE = 0.7
"""Share of a top's probability for an outer layer where one is worn: it hides the top but for an open front."""

MIN_OUTFIT_PROBABILITY = 1e-3
"""Least probability of one piece, of two, and of a garment on a bare chest: a waist may show a belt, or be hidden."""

WAIST_LINE_PRIOR_WEIGHT = 0.05
"""Probability that the waist line has as a prior where a one-piece garment is split into upper and lower: up to this
sum of both probabilities the line decides, beyond it they do."""

CHEST_GARMENTS = (Part.UPPER, Part.ONE_PIECE, Part.OUTER)
"""Garments on the chest."""

MIN_CHEST_GARMENT_SHARE = 0.02
"""Least share of samples above the waist labelled as one of `CHEST_GARMENTS`; with less the chest counts as bare."""

MIN_POINT_PROBABILITY = 0.01
"""Least probability of a point under a reading: a bag or a bad spot then counts against all readings alike."""

UNKNOWN_COAT = Coat()
"""An outer layer of which nothing is known."""

PART_COLUMN = {part: k for k, part in enumerate(PARTS)}
"""Column of each part in a posterior."""


def condition_on_outfit(
    posterior: np.ndarray, outfit: tuple[Part, ...], above: np.ndarray, outer: np.ndarray | None = None
) -> np.ndarray:
    """Return the posterior if just these garments are worn, shape [n, part_count]; rows sum to 1 or less.

    The probability of one piece is split at the waist into top and bottom, or theirs is added to one piece's. That of
    other garments is dropped, which counts against the reading; if nothing is worn, it is the skin's.

    Args:
        posterior: Shape [n, part_count].
        outfit: The garments.
        above: Probability that a point is above the waist line, shape [n].
        outer: Probability of each point's cloth to be the outer layer's where one is worn, shape [n], or None.
    """
    upper, lower, whole = (PART_COLUMN[part] for part in (Part.UPPER, Part.LOWER, Part.ONE_PIECE))
    if outer is not None and Part.OUTER in outfit:
        posterior = _assign_outer_layer(posterior, outer)
    if not outfit:
        return give_to_skin(posterior, GARMENTS)
    read = posterior.copy()
    if Part.ONE_PIECE in outfit:
        read[:, whole] = posterior[:, [upper, lower, whole]].sum(axis=1)
    else:
        both = posterior[:, upper] + posterior[:, lower]
        share = (posterior[:, upper] + WAIST_LINE_PRIOR_WEIGHT * above) / (both + WAIST_LINE_PRIOR_WEIGHT)
        read[:, upper] += posterior[:, whole] * share
        read[:, lower] += posterior[:, whole] * (1.0 - share)
    read[:, [PART_COLUMN[part] for part in GARMENTS if part not in outfit]] = 0.0
    return read


def give_to_skin(posterior: np.ndarray, bare: tuple[Part, ...]) -> np.ndarray:
    """Return a posterior, shape [n, part_count], in which the probability of some garments is the skin's."""
    columns = [PART_COLUMN[part] for part in bare]
    read = posterior.copy()
    read[:, PART_COLUMN[Part.SKIN]] += posterior[:, columns].sum(axis=1)
    read[:, columns] = 0.0
    return read


def _assign_outer_layer(posterior: np.ndarray, outer: np.ndarray) -> np.ndarray:
    """Return the posterior, shape [n, part_count], with the share `outer` of each garment given to the outer layer."""
    laid, inner = posterior.copy(), [PART_COLUMN[part] for part in GARMENTS if part is not Part.OUTER]
    laid[:, PART_COLUMN[Part.OUTER]] += outer * posterior[:, inner].sum(axis=1)
    laid[:, inner] *= (1.0 - outer)[:, None]
    return laid


def above_waist_probability(place: BodyPlace, body: Body) -> np.ndarray:
    """Return the probability that each point is above the waist line, shape [n]."""
    hips = 0.5 * (body.rest_joints[JOINTS.index("left_hip"), 1] + body.rest_joints[JOINTS.index("right_hip"), 1])
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip((place.rest[:, 1] - hips - WAIST_LINE_HEIGHT) / 0.02, -30.0, 30.0))))


def rank_outfits(
    posterior: np.ndarray,
    above: np.ndarray,
    wearing: tuple[Part, ...] | None = None,
    marked: tuple[Part, ...] = (),
    coat: Coat = UNKNOWN_COAT,
) -> tuple[Outfit, ...]:
    """Return the readings, the likeliest first.

    score(H) = log p(H) + log p(outer layer or none) + log p(one piece or several) + `INDEPENDENT_OBSERVATION_COUNT`
    mean_i log sum_k p(k | i, H), with p(k | i, H) as `condition_on_outfit`. An outer layer, and one piece or several
    (the mean over all garments), are facts of the person and count once. The difference of two scores is the log-odds
    of the readings. Garments of a bare chest have `MIN_OUTFIT_PROBABILITY`.

    Args:
        posterior: Of the samples, which are even, shape [n, part_count].
        above: Probability that a point is above the waist line, shape [n].
        wearing: The garments where they are known: then the only reading.
        marked: Garments that every reading must have.
        coat: What is known of an outer layer.
    """
    if wearing is not None:
        return (Outfit(wearing, 0.0),)
    several, is_bare = several_pieces_probability(posterior), _is_chest_bare(posterior, above)
    found = []
    for (inner, prior), outer in product(OUTFIT_READINGS, (False, True)):
        outfit = tuple(part for part in GARMENTS if part in inner or (outer and part is Part.OUTER))
        allowed = condition_on_outfit(posterior, outfit, above, coat.over).sum(axis=1)
        two = several if not outer or coat.several is None else coat.several
        worn = 1.0 - two if Part.ONE_PIECE in outfit else two
        layered = -np.logaddexp(0.0, -coat.odds if outer else coat.odds)
        score = (
            prior
            + layered
            + np.log(worn)
            + INDEPENDENT_OBSERVATION_COUNT * np.log(np.maximum(allowed, MIN_POINT_PROBABILITY)).mean()
        )
        if is_bare and set(outfit) & set(CHEST_GARMENTS):
            score += np.log(MIN_OUTFIT_PROBABILITY)
        found.append(Outfit(outfit, float(score)))
    fitting = [outfit for outfit in found if set(marked) <= set(outfit.parts)]
    return tuple(sorted(fitting or [Outfit(marked, 0.0)], key=lambda outfit: -outfit.score))


def _is_chest_bare(posterior: np.ndarray, above: np.ndarray) -> bool:
    """Check whether no garment of the chest shows above the waist."""
    worn = np.isin(posterior.argmax(axis=1), [PART_COLUMN[part] for part in CHEST_GARMENTS])
    return bool((worn & (above > 0.5)).mean() < MIN_CHEST_GARMENT_SHARE)


def several_pieces_probability(posterior: np.ndarray) -> float:
    """Return the probability that several garments, and not one piece, are worn below an outer layer.

    Args:
        posterior: Of the samples, shape [n, part_count].
    """
    upper, lower, whole = posterior[:, [PART_COLUMN[part] for part in (Part.UPPER, Part.LOWER, Part.ONE_PIECE)]].sum(
        axis=0
    )
    share = (upper + lower) / max(upper + lower + whole, 1e-9)
    return float(np.clip(share, MIN_OUTFIT_PROBABILITY, 1.0 - MIN_OUTFIT_PROBABILITY))


def outfit_probabilities(outfits: tuple[Outfit, ...]) -> np.ndarray:
    """Return the probability of each reading: exp(score), normalised to a sum of 1, shape [outfit_count]."""
    scores = np.array([outfit.score for outfit in outfits])
    likely = np.exp(scores - scores.max(initial=-np.inf))
    return np.asarray(likely / likely.sum())


def marginalise_outfits(
    posterior: np.ndarray, outfits: tuple[Outfit, ...], above: np.ndarray, p_outer: np.ndarray | None = None
) -> np.ndarray:
    """Return the posterior over all readings, sum_H p(H) p(k | i, H), rows sum to 1, shape [n, part_count].

    The temperature is applied to each reading and not to the sum: smoothing blurs the parts, but not the outfit. A
    label that only the best reading gives is no likelier than that reading. Where nothing separates a worn outer layer
    from a top, it gets `OUTER_LAYER_SHARE` of the top's probability, and of one piece's above the waist.
    """
    upper, whole, outer = (PART_COLUMN[part] for part in (Part.UPPER, Part.ONE_PIECE, Part.OUTER))
    total = np.zeros_like(posterior)
    for outfit, likely in zip(outfits, outfit_probabilities(outfits), strict=True):
        read = condition_on_outfit(posterior, outfit.parts, above, p_outer)
        if p_outer is None and Part.OUTER in outfit.parts and len(outfits) > 1:
            hidden = OUTER_LAYER_SHARE * np.stack([read[:, upper], read[:, whole] * above], axis=1)
            read[:, [upper, whole]] -= hidden
            read[:, outer] += hidden.sum(axis=1)
        total += likely * apply_temperature(read / read.sum(axis=1, keepdims=True))
    return total
