"""Find bare skin and underwear, which lie on the body everywhere, from garments, which stand off it somewhere."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from ..body.person import PersonFit, PointWeights, refit_person
from ..geometry.surface import TriangleSurface
from ..run.hooks import SILENT_HOOKS, Hooks
from .garments import MIN_GARMENT_AREA
from .limbs import FOLDED_BODY_PARTS, BodyPlace, Limb
from .part import GARMENTS, PARTS, Part
from .points import PersonPoints
from .separation import Outfit

STAND_OFF_QUANTILE = 0.9
"""Quantile of the heights over the body that tells garments from skin: a garment hangs from where it is tight."""

BARE_STAND_OFF = 7e-3
"""Height over a body fitted as if bare [m] that nine tenths of skin stay below, and of garments do not: 2.1 to 5.4 mm
of 16 bare parts of simulated persons, from 8.5 mm of 33 garments of others, from 11 mm in five raw packs."""

BARE_LOG_ODDS_SLOPE = 8.0
"""Change of the log-odds of skin with the logarithm of the height [1]: at the highest of the bare parts 20 to 1."""

MIN_JUDGED_SAMPLE_COUNT = 50
"""Number of samples below which a part is not judged: a hand's breadth of cloth."""


def measure_bare_heights(fit: PersonFit, points: PersonPoints, hooks: Hooks = SILENT_HOOKS) -> np.ndarray:
    """Compute the height of each sample over a body that is fitted as if all samples were skin [m], shape [n].

    Args:
        fit: The body below the clothes, where that fit begins.
        points: The samples.
        hooks: Progress and cancellation.
    """
    bare = refit_person(
        fit, points.positions, points.normals, PointWeights(np.zeros(len(points.positions))), hooks
    ).body
    return TriangleSurface(bare.vertices, bare.faces).heights(points.positions)


def find_bare_odds(height: np.ndarray, column: np.ndarray) -> dict[Part, float]:
    """Return the log-odds of each garment's being the wearer's skin, or underwear that lies on it as skin does.

    Args:
        height: Of each sample over a body fitted as if bare [m], shape [n].
        column: The column in `PARTS` of each sample's label, shape [n].
    """
    own = {part: height[column == PARTS.index(part)] for part in GARMENTS}
    return {part: _bare_odds(heights) for part, heights in own.items() if len(heights) >= MIN_JUDGED_SAMPLE_COUNT}


def find_loose_skin(height: np.ndarray, posterior: np.ndarray, place: BodyPlace, spacing: float) -> np.ndarray:
    """Find what was taken for skin but hangs off the body: cloth in the skin's colour, bool, shape [n].

    Both legs and both arms are judged as a whole, without feet and hands, whose fit is worse, where their skin is as
    large as a garment. It is cloth if the log-odds by its height over the body and those by the mean of its posterior,
    shape and colour, add up to less than 0.

    Args:
        height: Of each sample over a body fitted as if bare [m], shape [n].
        posterior: Of the parts, shape [n, part_count].
        place: Where on the body the samples lie.
        spacing: Distance of the samples [m].
    """
    ends = place.parts[:, [list(FOLDED_BODY_PARTS).index(name) for name in ("hand", "foot")]].sum(axis=1)
    chance = posterior[:, PARTS.index(Part.SKIN)]
    skin = (posterior.argmax(axis=1) == PARTS.index(Part.SKIN)) & (ends < 0.5)
    loose = np.zeros(len(height), bool)
    for limbs in ((Limb.LEFT_LEG, Limb.RIGHT_LEG), (Limb.LEFT_ARM, Limb.RIGHT_ARM)):
        own = skin & np.isin(place.limb, limbs)
        if own.sum() * spacing**2 < MIN_GARMENT_AREA:
            continue
        mean = float(np.clip(chance[own].mean(), 1e-6, 1.0 - 1e-6))
        if np.log(mean / (1.0 - mean)) + _bare_odds(height[own]) < 0.0:
            loose |= own
    return loose


def _bare_odds(height: np.ndarray) -> float:
    """Return the log-odds of skin of samples at heights over a body fitted as if bare [m], shape [k]."""
    stand_off = max(float(np.quantile(height, STAND_OFF_QUANTILE)), 1e-4)
    return BARE_LOG_ODDS_SLOPE * float(np.log(BARE_STAND_OFF / stand_off))


def add_bare_readings(outfits: tuple[Outfit, ...], odds: Mapping[Part, float]) -> tuple[Outfit, ...]:
    """Return the readings with those in which garments of the best one are bare skin, the likeliest first.

    Each of these garments that is skin changes the score by its log-odds.
    """
    best, found = outfits[0], dict[tuple[Part, ...], float]()
    judged = [part for part in best.parts if part in odds]
    for count in range(1, len(judged) + 1):
        for bare in combinations(judged, count):
            left = tuple(part for part in best.parts if part not in bare)
            found[left] = best.score + sum(odds[part] for part in bare)
    for outfit in outfits[1:]:
        found[outfit.parts] = max(outfit.score, found.get(outfit.parts, -np.inf))
    changed = [best, *(Outfit(parts, score) for parts, score in found.items())]
    return tuple(sorted(changed, key=lambda outfit: -outfit.score))
