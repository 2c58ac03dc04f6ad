"""Whether what is worn on the chest and what is worn on the legs are of one cloth, by all colours that each shows."""

from __future__ import annotations

import numpy as np

from ..body.body import JOINTS, Body
from .colour import LEAST, histogram
from .limbs import BodyPlace, Limb


def overlap_of_cloths(lab: np.ndarray, place: BodyPlace, body: Body, cloth: np.ndarray) -> float | None:
    """Compute the overlap of the colours of chest and legs, 0 to 1; None where one of the two shows too little cloth.

    The chest is what lies above the middle between hip joints and neck, the legs the lower half of what hangs below
    the hip joints: long tops, high waists and belts lie between.

    Args:
        lab: Colours of the samples in L*a*b*, shape [n, 3].
        place: Where on the body they lie.
        body: The fitted body.
        cloth: Whether each sample is cloth that counts, bool, shape [n].
    """
    hips, neck = (body.rest_joints[JOINTS.index(name), 1] for name in ("left_hip", "neck"))
    height = place.rest[:, 1]
    own = cloth & ~np.isin(place.limb, (Limb.LEFT_ARM, Limb.RIGHT_ARM))
    chest, below = own & (height > 0.5 * (hips + neck)), own & (height < hips)
    if min(chest.sum(), below.sum()) < 2 * LEAST:
        return None
    legs = below & (height < np.median(height[below]))
    first, second = (histogram(lab, mine.astype(float)) for mine in (chest, legs))
    return float(np.minimum(first, second).sum())
