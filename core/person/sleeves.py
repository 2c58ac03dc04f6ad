"""How much of the upper arms clothes cover: what is worn over other clothes has sleeves."""

from __future__ import annotations

import numpy as np

from .features import Features
from .limbs import FOLDED

UPPER_ARM = tuple(FOLDED).index("upper_arm")
"""The column of the upper arms in `BodyPlace.parts`."""

LEAST = 50
"""Fewest samples of the upper arms, 25 cm2, that tell."""

COVERED = (0.75, 0.05)
"""Share of the upper arms' samples that are cloth from which on sleeves are worn, and the share about it within which
that is open. Of 38 scans of simulated persons in an outer layer 36 have more than 0.8, the others 0.73."""

OUTER_SLEEVED = 0.9
"""Share of outer layers that have sleeves: waistcoats and gilets have none, though no simulated outer layer is one."""

OTHERS_SLEEVED = 0.4
"""Share of those without an outer layer whose upper arms are covered: of 412 scans of simulated persons 171."""


def measure_sleeves(features: Features, cloth: np.ndarray) -> float | None:
    """Return the share of the upper arms that is cloth, or None where too little of them is seen.

    Args:
        features: Description of the samples.
        cloth: Whether each sample is cloth, shape [n].
    """
    own = features.place.parts[:, UPPER_ARM] > 0.5
    return float(cloth[own].mean()) if own.sum() >= LEAST else None


def sleeve_evidence(covered: float | None) -> float:
    """Compute the log-odds of an outer layer that the covered share c of the upper arms is worth.

    log(w p / q + (1 - w) (1 - p) / (1 - q)), w = 1 / (1 + exp((c0 - c) / d)) the probability of sleeves.

    Args:
        covered: c, or None, which says nothing. c0, d = `COVERED`, p = `OUTER_SLEEVED`, q = `OTHERS_SLEEVED`.
    """
    if covered is None:
        return 0.0
    worn = 1.0 / (1.0 + np.exp((COVERED[0] - covered) / COVERED[1]))
    likely = OUTER_SLEEVED / OTHERS_SLEEVED
    unlikely = (1.0 - OUTER_SLEEVED) / (1.0 - OTHERS_SLEEVED)
    return float(np.log(worn * likely + (1.0 - worn) * unlikely))
