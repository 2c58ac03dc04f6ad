"""What a scan's own colours say of its parts: models fitted where the geometry is sure, used where it is not."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter

from .diffusion import Links, diffuse
from .limbs import FOLDED_BODY_PARTS, BodyPlace
from .part import GARMENTS, PARTS, Part

BINS = (14, 52, 52)
"""Cells of the grid of L*, a*, b*: 8 units of lightness and 4 of a* and b* each. Shading changes the lightness of one
cloth by 20 and more, its chroma by a few units."""

LOW, STEP = np.array([0.0, -104.0, -104.0]), np.array([8.0, 4.0, 4.0])
"""Corner and cell of the grid."""

BLUR = 1.0
"""Width of the smoothing of a colour model [cells], standard deviation: 8 units of lightness, 4 of chroma, about what
shading and a camera's noise of 3 % make of one colour."""

SURE = 0.8
"""Least probability by geometry of a point that a model is fitted to."""

LEAST = 60
"""Fewest points that a model is fitted to: 30 cm2, the backs of two hands."""

FLOOR = 0.02
"""Share of all colours of the scan in every part's model: no colour speaks against a part by more than 1 : 50, for a
print, a pocket or a dirty knee may have any."""

OVERLAP = 0.5
"""Overlap of two parts' models above which colour does not decide between the two."""

DISAGREE = 0.15
"""Overlap of a garment's front and back below which the colours are not believed: a scan from one photograph has its
back painted, and a shirt with a printed front still shares its cloth."""


DOUBT = (0.02, 1e-3)
"""Least probability of each part by geometry, on limbs and neck and where anatomy knows: a ring found at the wrong
place is wrong on all of a sleeve at once, but a hand is no trouser leg."""

KNOWN = ("head", "hand", "foot")
"""Parts of the body of which anatomy knows what they may be."""

NEVER = {
    Part.SHOES: ("pelvis", "waist", "chest", "neck", "head", "upper_arm", "forearm", "hand", "thigh"),
    Part.HAIR: ("pelvis", "forearm", "hand", "thigh", "shank", "foot"),
}
"""Parts of the body where shoes and hair are not, whatever the colour there."""

ROUNDS = 3
"""Times that models are fitted and asked; what was sure by geometry alone grows by what colour makes sure."""

CONTRAST = np.array([0.4, 1.0, 1.0])
"""Weights of L*, a*, b* in a difference: a shadow or a fold is no border."""

EDGE = 12.0
"""Difference of neighbours' colours at which they say much less of each other: three times a camera's noise."""


@dataclass(frozen=True)
class ColourModels:
    """How likely each colour is in each part.

    Attributes:
        evidence: log p(colour | part) - log p(colour) of each cell, shape [part_count, *BINS]; for a garment without
            a model that of all garments together, 0 for another part without one.
        fitted: Which parts have a model, bool, shape [part_count].
    """

    evidence: np.ndarray
    fitted: np.ndarray

    def ask(self, lab: np.ndarray) -> np.ndarray:
        """Return the evidence for each part at colours, shape [n, part_count]."""
        light, red, yellow = cells_of(lab)
        return np.asarray(self.evidence[:, light, red, yellow].T)


def fit_colours(lab: np.ndarray, posterior: np.ndarray, sources: np.ndarray) -> ColourModels:
    """Fit a model of its colours to each part.

    A part's colours h are a histogram in L*a*b*, blurred by `BLUR`, of the points that geometry is sure of, and its
    model is p = (1 - f) h + f g with g the colours of the whole scan, f = `FLOOR`. The evidence is log p / g. Parts of
    which the models overlap by more than `OVERLAP` share one.

    Args:
        lab: Colours, shape [n, 3].
        posterior: Probability of each part by geometry, shape [n, part_count].
        sources: Which points may speak for which part, bool, shape [n, part_count].
    """
    everything = histogram(lab, np.ones(len(lab)))
    believed = np.where((posterior >= SURE) & sources, posterior, 0.0)
    fitted = (believed > 0.0).sum(axis=0) >= LEAST
    own = {int(k): histogram(lab, believed[:, k]) for k in np.flatnonzero(fitted)}
    mass = believed.sum(axis=0)
    evidence = np.zeros((posterior.shape[1], *BINS))
    for group in _overlapping(own):
        h = sum(mass[k] * own[k] for k in group) / mass[group].sum()
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(everything > 0.0, ((1.0 - FLOOR) * h + FLOOR * everything) / everything, 1.0)
        evidence[group] = np.log(np.maximum(ratio, FLOOR))
    worn = [PARTS.index(part) for part in GARMENTS]
    known = [k for k in worn if fitted[k]]
    if known:
        # A garment that nothing is sure of would be made of the others: a dress, of what was taken for top and skirt.
        share = mass[known] / mass[known].sum()
        mixed = np.log(np.einsum("k,klab->lab", share, np.exp(evidence[known])))
        evidence[[k for k in worn if not fitted[k]]] = mixed
    return ColourModels(evidence, fitted)


def use_colours(
    posterior: np.ndarray, lab: np.ndarray, place: BodyPlace, links: Links, tone: np.ndarray | None = None
) -> np.ndarray:
    """Return the posterior by geometry and colour, shape [n, part_count].

    Args:
        posterior: By geometry, shape [n, part_count].
        lab: Colours in L*a*b*, shape [n, 3].
        place: Where on the body the points lie.
        links: Neighbours, as `link_alike` gives them.
        tone: Evidence for skin by its colour, shape [n], or None.
    """
    if is_painted(lab, place.rest[:, 2] > np.median(place.rest[:, 2]), posterior, PARTS):
        return posterior
    sources = find_sources(place)
    geometry, belief = np.log(np.maximum(posterior, find_doubt(place))), posterior
    for _ in range(ROUNDS):
        models = fit_colours(lab, belief, sources if tone is None else sources & ~find_strays(belief, tone))
        logit = geometry + models.ask(lab)
        both = np.exp(logit - logit.max(axis=1, keepdims=True))
        belief = diffuse(both / both.sum(axis=1, keepdims=True), links.by_colour or links)
    return belief


def link_alike(links: Links, lab: np.ndarray) -> Links:
    """Return the links with the same beside them, weakened where colours in L*a*b*, shape [n, 3], change."""
    return replace(links, by_colour=links.weakened(lab * CONTRAST, EDGE))


def find_doubt(place: BodyPlace) -> np.ndarray:
    """Return the least probability of each part by geometry that colour starts from, shape [n, part_count]."""

    def on(names: tuple[str, ...]) -> np.ndarray:
        return np.asarray(place.parts[:, [list(FOLDED_BODY_PARTS).index(name) for name in names]].sum(axis=1) > 0.5)

    doubt = np.full((len(place.parts), len(PARTS)), DOUBT[0])
    doubt[on(KNOWN)] = DOUBT[1]
    for part, names in NEVER.items():
        doubt[on(names), PARTS.index(part)] = DOUBT[1]
    return doubt


def find_sources(place: BodyPlace) -> np.ndarray:
    """Mark which points may show the colours of which part, shape [n, part_count]: skin is shown by head and hands."""
    head, hand = (place.parts[:, list(FOLDED_BODY_PARTS).index(name)] for name in ("head", "hand"))
    sources = np.ones((len(place.parts), len(PARTS)), bool)
    sources[:, PARTS.index(Part.SKIN)] = head + hand > 0.5
    return sources


def find_strays(posterior: np.ndarray, tone: np.ndarray) -> np.ndarray:
    """Mark skin that was taken for a garment, bool, shape [n, part_count], so that no model learns the skin's colour.

    What has the colour of the skin is skin where most of the garment has another; a garment in the skin's colour keeps
    all that it has.

    Args:
        posterior: Probability of each part, shape [n, part_count].
        tone: Evidence for skin by its colour, shape [n].
    """
    strays = np.zeros(posterior.shape, bool)
    like_skin = tone > 0.0
    for k, part in enumerate(PARTS):
        sure = posterior[:, k] >= SURE
        if part in GARMENTS and like_skin[sure].sum() < 0.5 * sure.sum():
            strays[:, k] = like_skin
    return strays


def is_painted(lab: np.ndarray, front: np.ndarray, posterior: np.ndarray, parts: tuple[Part, ...]) -> bool:
    """Return whether a garment's back has other colours than its front, as on a scan made of one photograph.

    Args:
        lab: Colours, shape [n, 3].
        front: Whether a point faces to the wearer's front, bool, shape [n].
        posterior: Probability of each part by geometry, shape [n, part_count].
        parts: What each column is.
    """
    for k, part in enumerate(parts):
        if part in GARMENTS:
            sure = posterior[:, k] >= SURE
            if min((sure & front).sum(), (sure & ~front).sum()) < LEAST:
                continue
            a, b = (histogram(lab, (sure & side).astype(float)) for side in (front, ~front))
            if float(np.minimum(a, b).sum()) < DISAGREE:
                return True
    return False


def cells_of(lab: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the cell of each colour, shape [n, 3], in the grid of `BINS`: an index for each of its three axes."""
    cell = ((lab - LOW) / STEP).astype(np.int64)
    return tuple(np.clip(cell, 0, np.array(BINS) - 1).T)


def histogram(lab: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the share of each cell of the grid in weighed colours, shape [n, 3], blurred, shape `BINS`."""
    counts = np.bincount(np.ravel_multi_index(cells_of(lab), BINS), weight, int(np.prod(BINS))).reshape(BINS)
    blurred = gaussian_filter(counts, BLUR, mode="constant", truncate=3.0)
    return np.asarray(blurred / max(float(blurred.sum()), 1e-300))


def _overlapping(own: dict[int, np.ndarray]) -> list[list[int]]:
    """Group the parts whose models overlap by more than `OVERLAP`."""
    groups: list[list[int]] = []
    for k, h in own.items():
        joined = [g for g in groups if any(float(np.minimum(own[j], h).sum()) > OVERLAP for j in g)]
        groups = [g for g in groups if g not in joined] + [sorted(sum(joined, [k]))]
    return groups
