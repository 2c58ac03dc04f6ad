"""Find bare skin and underwear, which lie on the body everywhere, from garments, which stand off it somewhere."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from ..body.person import PersonFit, PointWeights, refit_person
from ..geometry.surface import TriangleSurface
from ..run.hooks import SILENT_HOOKS, Hooks
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


def find_bare_odds(
    fit: PersonFit, points: PersonPoints, column: np.ndarray, hooks: Hooks = SILENT_HOOKS
) -> dict[Part, float]:
    """Return the log-odds of each garment's being the wearer's skin, or underwear that lies on it as skin does.

    The body is fitted once more with every sample taken for skin, so that a body with nothing on meets the scan.

    Args:
        fit: The body.
        points: The samples.
        column: The column in `PARTS` of each sample's label, shape [n].
        hooks: Progress and cancellation.
    """
    bare = refit_person(fit, points.positions, points.normals, PointWeights(np.zeros(len(column))), hooks).body
    height = TriangleSurface(bare.vertices, bare.faces).heights(points.positions)
    found = {}
    for part in GARMENTS:
        own = height[column == PARTS.index(part)]
        if len(own) >= MIN_JUDGED_SAMPLE_COUNT:
            stand_off = max(float(np.quantile(own, STAND_OFF_QUANTILE)), 1e-4)
            found[part] = BARE_LOG_ODDS_SLOPE * float(np.log(BARE_STAND_OFF / stand_off))
    return found


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
