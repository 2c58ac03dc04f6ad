"""Whether an outer layer is worn, and what of the cloth is its: by its front's edges, two colours, and looseness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..body.body import JOINTS, Body
from .cloths import overlap_of_cloths
from .colour import cells_of, histogram
from .diffusion import Links, diffuse
from .evidence import find_spans, measure_tube
from .features import Features
from .front import FrontEdges, find_front_edges
from .limbs import BodyPlace, Limb
from .looseness import loose_evidence, measure_looseness
from .part import GARMENTS, PARTS
from .points import PersonPoints
from .rules import ALIKE, BLOCKED, OVERLAP, two_piece_prior

OUTER = -2.2
"""Log-odds of an outer layer before anything is seen: one person in ten, as simulated ones wear them."""
CLOSED = 0.25
"""Share of outer layers that do not show two edges: they are closed, or of the colour of what is below."""
PANELLED = 0.003
"""Share of those who wear none and show two such edges all the same: a placket or a panel from neckline to hem."""
EDGES = (20.0, 2.0)
"""Score of two edges between cloths of different colours that says nothing, and by how much more it is e times as
likely of an open front. Of 293 scans of simulated persons without an outer layer 292 have at most 16; of 30 in one, 23
whose cloths differ have 24 to 101, the others (closed, or of one cloth) at most 8."""
LEAST = 60
"""Fewest samples, 30 cm2, that show a cloth's colours."""
MARGIN = 0.012
"""Distance from an edge [m] within which no colour is learnt: textures bleed by 1 cm."""
RATIO = 4.0
"""Largest log-ratio of two cloths' colours: dirt and prints may have any."""
RARE = 1e-5
"""Share of a cell that every cloth has: a colour that neither shows says nothing."""
SURE = 0.8
"""Probability from which on a sample shows the colours of the cloth it is told to be."""
PLACED = 1.5
"""Log-odds that what lies beside the edges is the outer layer's, and between them what is below."""
SLEEVED = 0.5
"""The same of the arms: sleeves may be shorter than those below."""
HANGING = -1.0
"""The same below the ends of the edges, where the outer layer may end as well."""
ROUNDS = 3
"""Times that colours are learnt: beside the edges, then of what is told to be the one and the other."""


@dataclass(frozen=True)
class Coat:
    """What is known of an outer layer.

    Attributes:
        odds: Log-odds that one is worn.
        over: Probability of each sample's cloth to be its if it is worn, shape [n]; None where nothing tells.
        several: Probability that several garments are worn below it, and not one piece; None where nothing tells.
    """

    odds: float = OUTER
    over: np.ndarray | None = None
    several: float | None = None


def find_coat(points: PersonPoints, features: Features, posterior: np.ndarray, links: Links, body: Body) -> Coat:
    """Find out whether an outer layer is worn, and where it is.

    Without colours only its looseness tells: by shape alone the edges of a front show no more than a shirt's folds.

    Args:
        points: The samples.
        features: Their description.
        posterior: Of the parts as if no outer layer were worn, shape [n, part_count].
        links: Neighbours, as `link_alike` gives them where there are colours.
        body: The fitted body.
    """
    cloth = posterior[:, [PARTS.index(part) for part in GARMENTS]].sum(axis=1) > 0.5
    prior = OUTER + loose_evidence(measure_looseness(features, cloth, body))
    lab = points.lab
    edges = None if lab is None else find_front_edges(features, lab, body)
    if lab is None or edges is None:
        return Coat(prior if lab is None else prior + open_evidence(0.0))
    sides = _place(edges, features.place, body)
    over = tell_cloths(sides, lab, cloth, links)
    if over is None:
        return Coat(prior + open_evidence(0.0))
    inner = cloth & (over < 0.5) & (sides.aside < 0.0) | cloth & (over < 0.5) & (sides.below > 0.0)
    overlap = overlap_of_cloths(lab, features.place, body, inner)
    several = several_below(overlap, measure_tube(find_spans(points, features)))
    odds = prior + open_evidence(edges.score * (1.0 - shared_colours(sides, lab, cloth)))
    return Coat(odds, over, several)


def open_evidence(shown: float) -> float:
    """Compute the log-odds of an outer layer that a front is worth.

    The likelihood ratio is (c + (1 - c) L) / (1 - p + p L), L = exp((s - s0) / d), c = `CLOSED`, p = `PANELLED`.

    Args:
        shown: s, the edges' score times the share of colours that the cloths beside and between them do not share.
    """
    likely = np.exp(np.clip((shown - EDGES[0]) / EDGES[1], -30.0, 30.0))
    return float(np.log((CLOSED + (1.0 - CLOSED) * likely) / (1.0 - PANELLED + PANELLED * likely)))


@dataclass(frozen=True)
class _Sides:
    """How far each sample lies outside the edges and below their ends [m], and if on an arm; their length [m]."""

    aside: np.ndarray
    below: np.ndarray
    arm: np.ndarray
    length: float


def _place(edges: FrontEdges, place: BodyPlace, body: Body) -> _Sides:
    neck, pelvis = (body.rest_joints[JOINTS.index(name)] for name in ("neck", "pelvis"))
    rest = place.rest
    station = neck[1] - rest[:, 1]
    left, right = (np.interp(station, edges.stations, side) for side in (edges.left, edges.right))
    middle = np.interp(rest[:, 1], [pelvis[1], neck[1]], [pelvis[2], neck[2]])
    aside = np.where(rest[:, 2] > middle, np.maximum(rest[:, 0] - left, right - rest[:, 0]), np.inf)
    arm = np.isin(place.limb, (Limb.LEFT_ARM, Limb.RIGHT_ARM))
    return _Sides(aside, station - edges.stations[-1], arm, float(np.ptp(edges.stations)))


def tell_cloths(sides: _Sides, lab: np.ndarray, cloth: np.ndarray, links: Links) -> np.ndarray | None:
    """Find out by place and colour what of the cloth beside and between a front's edges is the outer layer's.

    Args:
        sides: Where the samples lie beside the edges.
        lab: Their colours, shape [n, 3].
        cloth: Whether each is cloth, shape [n].
        links: Neighbours.

    Returns:
        The probability of each sample's cloth to be its, shape [n]; None where one of the two cloths is hardly seen.
    """
    outside = sides.aside > 0.0
    prior = np.where(outside, np.where(sides.below < 0.0, PLACED, HANGING), -PLACED)
    prior[sides.arm] = SLEEVED
    along = cloth & (sides.below < 0.0) & ~sides.arm
    own, other = _beside(sides, cloth)
    cells, over = cells_of(lab), None
    for _ in range(ROUNDS):
        if min(own.sum(), other.sum()) < LEAST:
            break
        ours, theirs = (histogram(lab, mine.astype(float)) for mine in (own, other))
        ratio = np.clip(np.log((ours[cells] + RARE) / (theirs[cells] + RARE)), -RATIO, RATIO)
        chance = 1.0 / (1.0 + np.exp(-prior - ratio))
        over = diffuse(np.stack([chance, 1.0 - chance], axis=1), links.by_colour or links)[:, 0]
        own, other = along & (over > SURE), along & (over < 1.0 - SURE)
    return over


def _beside(sides: _Sides, cloth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which samples of cloth lie beside the edges and which between them, bool, shape [n]."""
    along = cloth & (sides.below < 0.0) & ~sides.arm
    return along & (sides.aside > MARGIN), along & (sides.aside < -MARGIN)


def shared_colours(sides: _Sides, lab: np.ndarray, cloth: np.ndarray) -> float:
    """Return the overlap of the colours beside and between a front's edges, in that half of them where it is more.

    A shirt that hangs beside the trousers it is tucked into differs from what lies between its sides only below. The
    back is left out: a scan made of one photograph may have another colour there.
    """
    own, other = _beside(sides, cloth & np.isfinite(sides.aside))
    upper = sides.below < -0.5 * sides.length
    shared = []
    for half in (upper, ~upper):
        ours, theirs = own & half, other & half
        if min(ours.sum(), theirs.sum()) >= LEAST // 2:
            shared.append(np.minimum(*(histogram(lab, mine.astype(float)) for mine in (ours, theirs))).sum())
    return float(max(shared, default=1.0))


def several_below(overlap: float | None, tube: float) -> float:
    """Return the probability of several garments below an outer layer.

    Rings around the trunk say nothing of it, as the outer layer's hem is one.

    Args:
        overlap: Of the colours of what chest and legs show of it, or None.
        tube: Share of the height in which cloth spans from leg to leg.
    """
    odds = two_piece_prior(tube)
    if overlap is not None:
        odds += np.log(ALIKE / (1.0 - BLOCKED)) if overlap > OVERLAP[0] else np.log((1.0 - ALIKE) / BLOCKED)
    return float(1.0 / (1.0 + np.exp(-odds)))
