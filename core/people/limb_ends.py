"""Place the ends of sleeves and legs along their limbs, and find the category that they would make elsewhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtr

from ..body.body import Body
from ..scan.contours.category import LIMB_LIMITS
from ..scan.contours.contours import ARM_BONES, LEG_BONES, limb_place
from ..scan.contours.encirclement import find_crossings
from ..scan.contours.target import Contour
from .openings import INTERVAL_DEVIATIONS
from .separation import CategoryAlternative, FoundContour, LimbEnd

LIMB_BONES = {"cuff": ARM_BONES, "leg": LEG_BONES}
"""Bones of the limb that an opening lies on, by the first word of its name."""

LIMB_JOINTS = {"cuff": ("shoulder", "elbow", "wrist"), "leg": ("hip", "knee", "ankle")}
"""Joints between which an opening is placed, by the first word of its name."""

MIN_DEVIATION = 1e-6
"""Least standard deviation that divides [bones]: far below what any scan shows."""


def place_limb_ends(
    openings: Sequence[FoundContour], contours: Sequence[Contour], vertices: np.ndarray, body: Body
) -> tuple[FoundContour, ...]:
    """Return the openings, those around a limb with their place on it.

    Args:
        openings: What was found of each contour.
        contours: The same contours.
        vertices: Positions that the contours index [m], shape [vertex_count, 3].
        body: The wearer.
    """
    placed = []
    for opening, contour in zip(openings, contours, strict=True):
        kind, _, side = contour.name.partition(".")
        place = np.nan
        if kind in LIMB_BONES:
            place = limb_place(find_crossings(vertices[contour.vertices], body), side, LIMB_BONES[kind])
        if np.isfinite(place):
            opening = replace(opening, limb_end=_place_end(place, opening.interval, (kind, side), body))
        placed.append(opening)
    return tuple(placed)


def _place_end(place: float, interval: float | None, limb: tuple[str, str], body: Body) -> LimbEnd:
    """Return an end at a place in bones: 0 at the shoulder or hip joint, 1 at the next joint, 2 at wrist or ankle."""
    kind, side = limb
    joints = np.stack([body.joint(f"{side}_{name}") for name in LIMB_JOINTS[kind]])
    lengths = np.linalg.norm(np.diff(joints, axis=0), axis=1)
    bone = lengths[0] if place < 1.0 else lengths[1]
    share = np.interp(place, [0.0, 1.0, 2.0], [0.0, lengths[0] / lengths.sum(), 1.0])
    if interval is None:
        return LimbEnd(place, float(share), None, None)
    deviation = interval / INTERVAL_DEVIATIONS
    return LimbEnd(place, float(share), deviation / float(bone), deviation / float(lengths.sum()))


def find_alternative(category: str, openings: Sequence[FoundContour]) -> CategoryAlternative | None:
    """Return the category that a garment has if its sleeves or legs end beyond the nearest limit, and how likely it is.

    The mean of both ends is normally distributed, with the mean of their standard deviations, as what misplaces one
    often misplaces the other. None for a category that no limit of `LIMB_LIMITS` bounds, or without a seen end.

    Args:
        category: The garment's.
        openings: Its openings, placed.
    """
    for limit in LIMB_LIMITS:
        if category not in (limit.above, limit.below):
            continue
        ends = [one.limb_end for one in openings if one.name.startswith(f"{limit.kind}.") and one.limb_end is not None]
        seen = [end for end in ends if end.bone_deviation is not None]
        if not seen:
            return None
        place = float(np.mean([end.bone_place for end in ends]))
        deviation = float(np.mean([end.bone_deviation for end in seen if end.bone_deviation is not None]))
        beyond = float(ndtr((place - limit.place) / max(deviation, MIN_DEVIATION)))
        other, probability = (limit.below, beyond) if category == limit.above else (limit.above, 1.0 - beyond)
        return CategoryAlternative(other, probability)
    return None


def third_probabilities(end: LimbEnd) -> tuple[float, float, float]:
    """Return how likely an end lies in the upper, middle and lower third of the limb; all is one where it is inferred.

    Args:
        end: The end.
    """
    deviation = max(end.share_deviation or 0.0, MIN_DEVIATION)
    below = ndtr((np.array([1 / 3, 2 / 3]) - end.limb_share) / deviation)
    return float(below[0]), float(below[1] - below[0]), float(1.0 - below[1])
