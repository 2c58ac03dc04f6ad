"""Whether the chest is bare: what would be a top has the skin's own colour and lies on the body."""

from __future__ import annotations

import numpy as np

from .colour import LEAST
from .features import FEATURE_LENGTH_SCALE, Features

LIKE_SKIN = (0.6, 0.9)
"""Share of a top's samples that have the skin's colour, up to which it is cloth and from which on it may be skin. Of
217 scans of simulated persons in tops none has more than 0.45; one with a bare chest has 0.95 and 1.00."""

ON_BODY = (0.008, 0.012)
"""Height over the fitted body that four fifths of it stay below [m], up to which it may be skin and from which on it is
cloth: 6 mm of bare chests, 5 to 8 of the tightest tenth of the tops. A top in the skin's colour is about as frequent as
none, so that only a tight one passes for skin."""

MOST = 0.98
"""Largest probability: a tight top can have the skin's colour."""


def bare_chest_probability(features: Features, tone: np.ndarray | None, worn: np.ndarray) -> float:
    """Return the probability that what would be a top is the wearer's skin, 0 where colours do not show the skin.

    Args:
        features: The samples' description.
        tone: Evidence for skin by its colour (`skin_evidence`), shape [n], or None.
        worn: Which samples would be a top's, bool, shape [n].
    """
    if tone is None or worn.sum() < LEAST:
        return 0.0
    like = (float((tone[worn] > 0.0).mean()) - LIKE_SKIN[0]) / (LIKE_SKIN[1] - LIKE_SKIN[0])
    height = float(np.quantile(features.column("offset")[worn] * FEATURE_LENGTH_SCALE, 0.8))
    near = (ON_BODY[1] - height) / (ON_BODY[1] - ON_BODY[0])
    return MOST * float(np.clip(like, 0.0, 1.0) * np.clip(near, 0.0, 1.0))
