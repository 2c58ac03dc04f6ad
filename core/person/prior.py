"""What anatomy says of a place on the body before anything else is looked at."""

from __future__ import annotations

import numpy as np

from ..body import JOINTS, Body
from .features import LENGTH, Features
from .limbs import FOLDED, BodyPlace

PART_NAMES = tuple(FOLDED)


def scalp(place: BodyPlace, body: Body) -> np.ndarray:
    """Compute how much each place belongs to where hair grows, 0 to 1, shape [n].

    Above the hairline, a fifth of the way from crown to neck joint; behind the ears, in the head's rear half, down to
    the nape. Borders are 1 cm soft.
    """
    neck, head = (body.rest_joints[JOINTS.index(name)] for name in ("neck", "head"))
    size = float(body.rest_vertices[:, 1].max() - neck[1])
    up = (place.rest[:, 1] - neck[1]) / size
    forward = (place.rest[:, 2] - head[2]) / size
    above = _soft((up - 0.80) / 0.04)
    behind = _soft((0.10 - forward) / 0.04) * _soft((up - 0.30) / 0.04)
    return np.asarray(np.maximum(above, behind) * _head(place))


def _head(place: BodyPlace) -> np.ndarray:
    return np.asarray(place.parts[:, PART_NAMES.index("head")] + place.parts[:, PART_NAMES.index("neck")])


HAIR_OFFSET = 0.012
"""Offset [m] beyond which what is on the head is hair: the fit is off by less on faces."""
HAIR_ON_SCALP = 0.92
"""Share of people with hair where hair grows."""


def hair_probability(features: Features, body: Body) -> np.ndarray:
    """Compute the probability that what is on head and neck is hair and not skin, shape [n]; 0 elsewhere."""
    place = features.place
    grows = scalp(place, body)
    thick = _soft((features.column("offset_mean_20") * LENGTH - HAIR_OFFSET) / 0.003)
    head = np.clip(2.0 * _head(place), 0.0, 1.0)
    return np.asarray(head * (grows * HAIR_ON_SCALP + (1 - grows) * 0.9 * thick))


SOLE = 0.008
"""Height [m] of the feet's cover, below and around, beyond which they are shod: bare feet are fitted within it."""


def shoe_probability(features: Features) -> float:
    """Compute the probability that the person wears shoes, from the feet's usual offset and roughness."""
    foot = features.place.parts[:, PART_NAMES.index("foot")] > 0.7
    if foot.sum() < 50:
        return 0.5
    size = float(np.quantile(np.abs(features.column("offset")[foot]) * LENGTH, 0.7))
    return float(np.clip(_soft((size - SOLE) / 0.0015), 0.05, 0.95))


def _soft(x: np.ndarray | float) -> np.ndarray:
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(x, -30.0, 30.0))))
