"""How far clothes hang off the waist: what is worn over other clothes is cut to go over them."""

from __future__ import annotations

import numpy as np

from ..body.body import JOINTS, Body
from .features import FEATURE_LENGTH_SCALE, Features
from .limbs import Limb

AROUND_WAIST = (-0.10, 0.25)
"""Heights between pelvis and neck joint, as shares of their distance, within which cloth is measured: the hollow
between hips and ribs, where a close garment lies on the body and one that goes over another does not."""

LEAST = 50
"""Fewest samples of cloth there, 25 cm2, that tell."""

LOOSE = (0.0125, 3.4)
"""Median offset of the cloth there [m] that says nothing of an outer layer, and the power of a multiple of it that its
likelihood ratio is. Fitted on 38 scans of simulated persons in an outer layer, whose median is 20 mm, and on 412
without one (6 mm); of held-out designs alone 12.1 mm and 3.37, of those that networks are trained on 14.0 and 3.47."""

SAYS = (-2.8, 1.2)
"""Log-odds that it says at least and at most: people wear looser shirts and dresses than simulated ones do, and with
the prior of an outer layer nobody is asked what he wears because of looseness alone."""


def measure_looseness(features: Features, cloth: np.ndarray, body: Body) -> float | None:
    """Return the median offset of the cloth around the waist [m], or None where too little of it is seen.

    Args:
        features: Description of the samples.
        cloth: Whether each sample is cloth, shape [n].
        body: The fitted body.
    """
    place = features.place
    pelvis, neck = (float(body.rest_joints[JOINTS.index(name), 1]) for name in ("pelvis", "neck"))
    height = (place.rest[:, 1] - pelvis) / (neck - pelvis)
    own = cloth & (place.limb == Limb.TRUNK) & (height > AROUND_WAIST[0]) & (height < AROUND_WAIST[1])
    return float(np.median(features.column("offset")[own])) * FEATURE_LENGTH_SCALE if own.sum() >= LEAST else None


def loose_evidence(offset: float | None) -> float:
    """Compute the log-odds of an outer layer that the offset x of cloth around the waist is worth: p log(x / x0).

    It is clipped to `SAYS`; x0, p = `LOOSE`. Where too little is seen it is 0.

    Args:
        offset: x [m], or None.
    """
    if offset is None:
        return 0.0
    return float(np.clip(LOOSE[1] * np.log(max(offset, 1e-4) / LOOSE[0]), *SAYS))
