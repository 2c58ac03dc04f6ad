"""Predict the parts of a person without learning: rings on unrolled limbs, anatomy, offsets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..body.body import Body
from .bare_chest import bare_chest_probability
from .cloths import overlap_of_cloths
from .evidence import PersonRings, Waist, find_rings, spread_over
from .features import Features
from .limbs import FOLDED_BODY_PARTS, Limb
from .part import PARTS, Part
from .points import FittedPerson, PersonPoints
from .prior import hair_probability, long_hair, shoe_probability, stray_probability

FLOOR = 0.005
"""Probability that every part keeps everywhere: rules do not know bags and coats."""
TUBE = (0.2, 0.8)
"""Share of the height below the crotch in which cloth spans from leg to leg: up to the first of trousers, from the
second on of skirts. Baggy trousers have up to 1, a dress that hangs between the legs 0.5 (simulated persons)."""
TWO_WITH_LEGS, TWO_WITH_SKIRT = 1.0, 0.0
"""Log-odds of two pieces against one before the waist is looked at. One in four that has legs is one piece: fewer of
those who pass by, but people are scanned for what they wear. Of skirts half are a dress's."""
SHOWN = {True: (15.0, 7.0), False: (4.0, 2.0)}
"""Score of a waist's ring that says nothing, and by how much more it is e times as likely of two pieces: found with
colours, and by shape alone. Fitted on 49 scans of simulated persons (`training/waists.py`), by shape on 234."""
ALIKE = 0.1
"""Share of outfits in two pieces that are of one cloth above and below: colours do not show their waist."""
OVERLAP = (0.45, 0.08)
"""Overlap of the colours of chest and legs that says nothing, and by how much less it is e times as likely of two
cloths. Of simulated persons one piece has 0.58 to 0.97, two pieces of two cloths 0.01 to 0.16."""
HIDDEN = 0.03
"""Share of waists between two pieces that shape does not show on a scan without noise: a flat hem."""
DROWNED = 0.8
"""Noise of ridges around the trunk at which the shape of all but 1 / e of the other waists is lost in it: of 56 scans
of simulated persons in two pieces, none of those below 0.2 had a score below -2, and 5 of 14 of those above."""
BELTED = 0.03
"""Share of one-piece garments whose shape shows a ring between upper and lower all the same: a belt, a fold. Of 82
scans of simulated persons, who wear no belt that stands out, three had a score above 7."""
BLOCKED = 0.07
"""Share of one-piece garments that look like two cloths, above and below the waist: 5 in 100 of the simulated ones are,
and as many have a belt in another colour."""
BETWEEN = (-8.0, 2.0)
"""Score by shape, where two cloths meet, that says nothing, and by how much more it is e times as likely of two pieces:
of scans of simulated persons whose chest and legs differ, in two pieces none had less than -12.7, of six in one piece
none more than -13.2."""
SMOOTH = 0.1
"""Least that a missing step counts there: top and skirt are then about as likely as a dress of two colours."""


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
    return tell_by_rules(points, features, fit, tone).posterior


class RulesTold(NamedTuple):
    """What the rules say of samples.

    Attributes:
        posterior: As `predict_by_rules`, shape [n, 8].
        share: Which garment each sample is if it is one: upper, lower or one piece by the waist. 0 for what is no
            garment and for outer layers, rows sum to 1, shape [n, 8].
    """

    posterior: np.ndarray
    share: np.ndarray


def tell_by_rules(
    points: PersonPoints, features: Features, fit: FittedPerson, tone: np.ndarray | None = None
) -> RulesTold:
    """Compute the posterior as `predict_by_rules`, and which garment each sample is if it is one."""
    rings = find_rings(points, features, fit, tone=tone)
    cloth = find_cloth(rings, features, tone)
    share = _share_garments(cloth, two_piece_probability(rings, _overlap(points, features, fit.body, cloth, tone)))
    return RulesTold(_combine(points, features, fit.body, rings, cloth.probability[:, None] * share, tone), share)


def _combine(
    points: PersonPoints,
    features: Features,
    body: Body,
    rings: PersonRings,
    garments: np.ndarray,
    tone: np.ndarray | None,
) -> np.ndarray:
    """Compute the posterior from the rings and that of the garments, shape [n, 8]."""
    count = len(features.values)
    hair = hair_probability(features, body, tone)
    shod = shoe_probability(features)
    shoe = shod * np.maximum(
        *(spread_over(rings, limb, ring, count) for limb, ring in zip(_LEGS, rings.ankles, strict=True))
    )
    out = garments.copy()
    column = {part: i for i, part in enumerate(PARTS)}
    cloth = garments.sum(axis=1)
    bare = 1.0 - cloth
    out[:, column[Part.SKIN]] = bare * (1 - shoe) * (1 - hair)
    out[:, column[Part.HAIR]] = bare * (1 - shoe) * hair
    out[:, column[Part.SHOES]] = bare * shoe
    lock = long_hair(points, features, body, hair * bare * (1 - shoe))
    out *= (1 - lock)[:, None]
    out[:, column[Part.HAIR]] += lock
    stray = stray_probability(points, features) * (1 - cloth)
    out *= (1 - stray)[:, None]
    out[:, column[Part.OTHER]] += stray
    out += FLOOR
    return np.asarray(out / out.sum(axis=1, keepdims=True))


_ARMS = (Limb.LEFT_ARM, Limb.RIGHT_ARM)
_LEGS = (Limb.LEFT_LEG, Limb.RIGHT_LEG)


class Cloth(NamedTuple):
    """What of the samples is cloth.

    Attributes:
        probability: Of each sample to be cloth, shape [n].
        below: Of each to lie below the waist, shape [n].
    """

    probability: np.ndarray
    below: np.ndarray


def find_cloth(rings: PersonRings, features: Features, tone: np.ndarray | None = None) -> Cloth:
    """Find what is cloth: below the neckline, before the ends of sleeves and legs; a bare chest is none.

    Args:
        rings: Where garments end (`find_rings`).
        features: Description of the samples.
        tone: Evidence for skin by its colour (`skin_evidence`), shape [n], or None.
    """
    count = len(features.values)
    below = _below_waist(rings, count)
    cloth = 1.0 - np.clip(2.0 * features.place.parts[:, list(FOLDED_BODY_PARTS).index("head")] - 0.5, 0.0, 1.0)
    for limb, ring in zip(_ARMS + _LEGS, rings.sleeves + rings.hems, strict=True):
        cloth *= 1.0 - spread_over(rings, limb, ring, count)
    grid = rings.grids[Limb.NECK]
    cloth *= grid.at_samples(rings.neckline.probability_beyond(len(grid.counts)), count, 1.0)
    bare = bare_chest_probability(features, tone, (cloth > 0.5) & (below < 0.5))
    return Cloth(np.asarray(cloth * (1.0 - bare * (1.0 - below))), below)


def _overlap(
    points: PersonPoints, features: Features, body: Body, cloth: Cloth, tone: np.ndarray | None
) -> float | None:
    """Return the overlap of the colours of chest and legs where cloth is, or None without colours."""
    if points.lab is None:
        return None
    worn = cloth.probability > 0.5
    if tone is not None:
        worn &= tone <= 0.0  # a leg's ring may lie too low
    return overlap_of_cloths(points.lab, features.place, body, worn)


def _share_garments(cloth: Cloth, two: float) -> np.ndarray:
    """Return which garment each sample is if it is one, by the probability of two pieces, shape [n, 8]."""
    share = np.zeros((len(cloth.below), len(PARTS)))
    share[:, PARTS.index(Part.UPPER)] = two * (1 - cloth.below)
    share[:, PARTS.index(Part.LOWER)] = two * cloth.below
    share[:, PARTS.index(Part.ONE_PIECE)] = 1 - two
    return share


def _below_waist(rings: PersonRings, count: int) -> np.ndarray:
    """Compute the probability that each sample lies below the best ring between upper and lower, shape [count]."""
    best = best_waist(rings)
    return np.asarray(
        np.max(
            [spread_over(rings, limb, ring, count) for limb, ring in zip(best.limbs, best.rings, strict=True)], axis=0
        )
    )


def best_waist(rings: PersonRings) -> Waist:
    """Return the best ring between upper and lower: by shape where colours show none and shape does."""
    alike = rings.waists[0].score < SHOWN[True][0] and rings.waists_by_shape[0].score > SHOWN[False][0]
    return (rings.waists_by_shape if alike else rings.waists)[0]


def two_piece_probability(rings: PersonRings, overlap: float | None = None) -> float:
    """Compute the probability that there are an upper and a lower garment and not one piece.

    log p / (1 - p) = prior + what the waist shows (`waist_evidence`). The prior goes from that of trousers to that of
    skirts with the share of the height in which cloth spans from leg to leg.

    Args:
        rings: The person's rings.
        overlap: Of the colours of chest and legs (`overlap_of_cloths`), or None.
    """
    best = rings.waists[0]
    coloured, between = (best.score, best.by_shape) if rings.is_coloured else (None, None)
    shown = WaistShown(rings.waists_by_shape[0].score, coloured, overlap, rings.roughness, between)
    return float(1.0 / (1.0 + np.exp(-two_piece_prior(rings.tube) - waist_evidence(shown))))


def two_piece_prior(tube: float) -> float:
    """Compute the log-odds of two pieces against one by the share of height in which cloth spans from leg to leg."""
    spans = np.clip((tube - TUBE[0]) / (TUBE[1] - TUBE[0]), 0.0, 1.0)
    return float(TWO_WITH_LEGS + spans * (TWO_WITH_SKIRT - TWO_WITH_LEGS))


@dataclass(frozen=True)
class WaistShown:
    """What a scan shows of a waist between two pieces.

    Attributes:
        shape: Score of the best ring by shape.
        coloured: Score of the best ring with colours, or None where there are none.
        overlap: Of the colours of chest and legs, or None.
        roughness: Noise of ridges around the trunk (`PersonRings.roughness`).
        between: Score by shape of the best ring with colours; None: that of the best one by shape.
    """

    shape: float
    coloured: float | None = None
    overlap: float | None = None
    roughness: float = 0.0
    between: float | None = None


@dataclass(frozen=True)
class WaistModel:
    """How waists look.

    Attributes:
        by_shape: Score of a ring found by shape that says nothing, and by how much more it is e times as likely of two
            pieces.
        with_colours: The same with colours.
        hidden: Share of waists between two pieces that the shape of a scan without noise does not show.
    """

    by_shape: tuple[float, float] = SHOWN[False]
    with_colours: tuple[float, float] = SHOWN[True]
    hidden: float = HIDDEN


def waist_evidence(shown: WaistShown, model: WaistModel = WaistModel()) -> float:
    """Compute the log-odds of two pieces against one that a waist is worth: log R_s + log R_c.

    By shape R_s = (h + (1 - h) L) / (1 - b + b L), L = exp((s - c) / d): a waist is hidden by h, and one piece shows a
    ring by b = `BELTED`. Noise r hides more: 1 - h = (1 - `HIDDEN`) exp(-(r / `DROWNED`)^2).

    By the cloths above and below, where there are colours, R_c = (a + (1 - a) M) / (1 - k + k M): two pieces are of one
    cloth by a = `ALIKE`, one piece looks like two by k = `BLOCKED`. M is how much likelier two cloths are by the score
    of the ring with colours, as L is by shape, times exp((o - overlap) / e) by the overlap of the colours of chest and
    legs (`OVERLAP`). Where M > 1 and chest and legs differ, the waist is where the two meet: R_s is of the score there,
    with c and d of `BETWEEN`, and at least `SMOOTH`.

    Args:
        shown: What the scan shows.
        model: The constants.
    """
    hidden = 1.0 - (1.0 - model.hidden) * float(np.exp(-((shown.roughness / DROWNED) ** 2)))
    ratio = _ratio((shown.shape - model.by_shape[0]) / model.by_shape[1], hidden, BELTED)
    if shown.coloured is None:
        return float(np.log(ratio))
    units = (shown.coloured - model.with_colours[0]) / model.with_colours[1]
    if shown.overlap is not None:
        units += (OVERLAP[0] - shown.overlap) / OVERLAP[1]
    if units > 0.0 and (shown.overlap is None or shown.overlap < OVERLAP[0]):
        step = shown.shape if shown.between is None else shown.between
        ratio = max(_ratio((step - BETWEEN[0]) / BETWEEN[1], hidden, BELTED), SMOOTH)
    return float(np.log(ratio) + np.log(_ratio(units, ALIKE, BLOCKED)))


def _ratio(units: float, missed: float, false: float) -> float:
    """Return how much likelier a cue is of two pieces, which lack it by `missed` and one piece shows by `false`."""
    likely = float(np.exp(np.clip(units, -30.0, 30.0)))
    return (missed + (1.0 - missed) * likely) / (1.0 - false + false * likely)
