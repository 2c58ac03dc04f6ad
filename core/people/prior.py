"""What anatomy says of a place on the body before anything else is looked at."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import JOINTS, Body
from ..geometry.connectivity import find_components
from .features import FEATURE_LENGTH_SCALE, Features
from .limbs import FOLDED_BODY_PARTS, BodyPlace
from .points import PersonPoints

PART_NAMES = tuple(FOLDED_BODY_PARTS)


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
HAIR_ODDS = 2.4
"""Log-odds of hair where hair grows before anything is seen: eleven of twelve people have some there."""
SCALP_PATCHES = 3.0
"""Independent observations that the colour of a whole scalp counts as: it is one thing, lit from above."""
CROPPED = (0.006, 0.003)
"""Offset [m] of a scalp from which on it is covered whatever its colour, and how sharply: the fit's error and half."""


def scalp_hair_probability(features: Features, grows: np.ndarray, tone: np.ndarray | None) -> float:
    """Compute the probability that hair grows where it can: a scalp that is thin and has the skin's colour is bald.

    Args:
        features: The samples' description.
        grows: How much each place belongs to the scalp, shape [n].
        tone: Evidence for skin by its colour, shape [n], or None: then nothing tells a cropped head from a bald one.
    """
    own = grows > 0.5
    if tone is None or not own.any():
        return float(_soft(HAIR_ODDS))
    thick = float(np.median(features.column("offset_mean_20")[own])) * FEATURE_LENGTH_SCALE
    colour = SCALP_PATCHES * float(np.median(tone[own]))
    return float(_soft(HAIR_ODDS - colour + np.clip((thick - CROPPED[0]) / CROPPED[1], 0.0, 4.0)))


def hair_probability(features: Features, body: Body, tone: np.ndarray | None = None) -> np.ndarray:
    """Compute the probability that what is on head and neck is hair and not skin, shape [n]; 0 elsewhere.

    Args:
        features: The samples' description.
        body: The fitted body.
        tone: Evidence for skin by its colour, shape [n], or None.
    """
    place = features.place
    grows = scalp(place, body)
    thick = _soft((features.column("offset_mean_20") * FEATURE_LENGTH_SCALE - HAIR_OFFSET) / 0.003)
    head = np.clip(2.0 * _head(place), 0.0, 1.0)
    return np.asarray(head * (grows * scalp_hair_probability(features, grows, tone) + (1 - grows) * 0.9 * thick))


LOCK = 0.018
"""Offset over a slice's lowest fifth [m] from which what hangs from the head on neck, back or chest is long hair."""
LOCK_JOIN = 0.016
"""Distance of two samples [m] up to which hair hangs together: two spacings and a bit."""
LOCK_SURE = 0.85
"""Probability of what is found so: a hood or a scarf looks alike."""


def long_hair(points: PersonPoints, features: Features, body: Body, hair: np.ndarray) -> np.ndarray:
    """Compute the probability that each sample is hair that hangs down from the head, shape [n].

    What stands off neck, shoulders, chest and back by `LOCK` and hangs together with hair on the head.

    Args:
        points: The samples.
        features: Their description.
        body: The fitted body.
        hair: Probability of hair on the head, shape [n].
    """
    place = features.place
    waist = body.rest_joints[JOINTS.index("spine2"), 1]
    offset, lowest = (features.column(name) * FEATURE_LENGTH_SCALE for name in ("offset_mean_20", "slice_20"))
    stands = (offset > np.maximum(lowest, 0.0) + LOCK) & (place.rest[:, 1] > waist)
    stands &= place.parts[:, [PART_NAMES.index(name) for name in ("forearm", "hand")]].sum(axis=1) < 0.1
    own = np.flatnonzero(stands | (hair > 0.5))
    pairs = cKDTree(points.positions[own]).query_pairs(LOCK_JOIN, output_type="ndarray")
    alike = np.einsum("na,na->n", points.normals[own[pairs[:, 0]]], points.normals[own[pairs[:, 1]]]) > 0.3
    count, piece = find_components(len(own), pairs[alike, 0], pairs[alike, 1])
    roots = np.bincount(piece, hair[own] > 0.5, count) > 50
    out = np.zeros(len(hair))
    out[own[roots[piece] & ~(hair[own] > 0.5)]] = LOCK_SURE
    return out


HAIR_WEB = 0.02
"""Distance from hair that stands off [m] within which a scan's surface is neither skin nor cloth: reconstructed
surfaces span gaps of 13 to 20 mm, and below the ends of hair they fall off more steeply than at any hem."""


def below_hair(points: PersonPoints, features: Features, body: Body, tone: np.ndarray | None = None) -> np.ndarray:
    """Find the samples of hair that stands off the body, and those that it covers or joins to it, bool, shape [n].

    Args:
        points: The samples.
        features: Their description.
        body: The fitted body.
        tone: Evidence for skin by its colour, shape [n], or None.
    """
    hair = hair_probability(features, body, tone)
    stands = (hair > 0.5) | (long_hair(points, features, body, hair) > 0.5)
    stands &= features.column("offset_mean_20") * FEATURE_LENGTH_SCALE > HAIR_OFFSET
    if not stands.any():
        return stands
    away = cKDTree(points.positions[stands]).query(points.positions, distance_upper_bound=HAIR_WEB)[0]
    found: np.ndarray = np.isfinite(away)
    return found


SOLE = 0.0065
"""Height [m] of the feet's cover, below and around, beyond which they are shod: seven tenths of the samples of bare
feet are fitted within 2 to 8 mm, of shod ones within 9 to 20 (simulated persons)."""
TOES = (0.11, 0.02)
"""Spread of normals within 2 cm in the foremost quarter of the feet from which toes are seen, and how sharply: bare
0.13, shod 0.08 (the same)."""
SHOD = 0.7
"""Log-odds of shoes before anything is seen: two of three persons that are scanned wear some."""


AFAR = (0.10, 0.01)
"""Distance [m] from the bare foot or shank from which on nothing is a shoe, and its softness: of 188,000 simulated
samples of shoes one in a hundred lies beyond 0.07, remains of a floor have a median of 0.15."""
GROUND = 0.012
"""Height [m] above a scan's lowest samples up to which what faces up may be its floor: bumps and noise, no instep."""
LEVEL = 0.9
"""Least vertical component of a floor's normals. A sole faces down, and a shoe's welt is narrower than a sample."""
CLEAR = 0.015
"""Distance [m] from the body beyond which low and level samples are floor: the top of bare toes is nearer."""
FLOORED = 0.98
"""Probability that what is low, level and clear of the body is floor: a thing may lie there, and is no shoe either."""
REMAINS = 0.05
"""Least share of floor in the samples about feet and shanks of a scan that has any left: of 97 simulated scans
six have 0.31 and more, all others at most 0.006."""


def stray_probability(points: PersonPoints, features: Features) -> np.ndarray:
    """Compute the probability that samples about the feet are neither shoe nor skin, shape [n].

    That is what is left of a floor, level and lowest, and where there is one, what a surface closes it with or else
    lies far from the legs. Without a floor what is far from them is a skirt.
    """
    parts = features.place.parts
    low = parts[:, PART_NAMES.index("foot")] + parts[:, PART_NAMES.index("shank")] > 0.5
    distance = features.column("distance") * FEATURE_LENGTH_SCALE
    height = points.positions[:, 1] - np.quantile(points.positions[:, 1], 0.002)
    floor = (height < GROUND) & (points.normals[:, 1] > LEVEL) & (distance > CLEAR)
    if floor[low].sum() < REMAINS * low.sum():
        return np.zeros(len(low))
    afar = _soft((distance - AFAR[0]) / AFAR[1])
    return np.asarray(np.where(low, np.maximum(afar, np.where(floor, FLOORED, 0.0)), 0.0))


def shoe_probability(features: Features) -> float:
    """Compute the probability that the person wears shoes, from the feet's usual offset and roughness."""
    foot = features.place.parts[:, PART_NAMES.index("foot")] > 0.7
    if foot.sum() < 50:
        return 0.5
    size = float(np.quantile(np.abs(features.column("offset")[foot]) * FEATURE_LENGTH_SCALE, 0.7))
    forward = features.column("rest_forward")
    front = foot & (forward > 0.75 * forward[foot].max())
    toes = float(np.median(features.column("normal_spread_20")[front]))
    odds = SHOD + np.clip((size - SOLE) / 0.0015, -3.0, 3.0) + np.clip((TOES[0] - toes) / TOES[1], -2.0, 2.0)
    return float(np.clip(_soft(odds), 0.05, 0.95))


def _soft(x: np.ndarray | float) -> np.ndarray:
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(x, -30.0, 30.0))))
