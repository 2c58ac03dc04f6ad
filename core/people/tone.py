"""The wearer's own skin colour, learnt from face and hands: which other points have it, and which cannot be skin."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter

from ..body.body import Body
from .colour import BINS, LEAST, cells_of
from .limbs import FOLDED_BODY_PARTS, BodyPlace
from .prior import scalp

BLUR = (2.5, 1.0, 1.0)
"""Width of the smoothing of the skin's colours [cells of L*, a*, b*], standard deviation: 20 units of lightness, by
which a leg in a skirt's shade is darker than the face, and 4 of chroma."""

AGREE = 0.2
"""Least overlap of the colours of face and hands: below it there are gloves or a mask, and neither shows the skin."""

SKIN_COLOUR_EVIDENCE = (-3.0, 1.5)
"""Least and largest evidence for skin: skin has one colour and cloth any, so that another colour says more against
skin than the skin's own says for it."""


def skin_evidence(lab: np.ndarray, place: BodyPlace, body: Body) -> np.ndarray | None:
    """Compute log p(colour | skin) - log p(colour) of each sample, clipped by `SKIN_COLOUR_EVIDENCE`, shape [n].

    p(colour | skin) is that of the face and the hands, p(colour) of all that is not on them. Where all of it has the
    skin's colour the evidence is near 0: nothing can be told.

    Args:
        lab: Colours in L*a*b*, shape [n, 3].
        place: Where on the body the samples lie.
        body: The fitted body.

    Returns:
        The evidence; None where face and hands do not show the skin.
    """
    share = {name: place.parts[:, list(FOLDED_BODY_PARTS).index(name)] for name in ("head", "hand")}
    bare = scalp(place, body) < 0.3
    face, hands = (share["head"] > 0.8) & bare, share["hand"] > 0.7
    if min(face.sum(), hands.sum()) < LEAST:
        return None
    cells = np.ravel_multi_index(cells_of(lab), BINS)
    both = [_histogram(cells[mine]) for mine in (face, hands)]
    if float(np.minimum(*both).sum()) < AGREE:
        return None
    skin, rest = 0.5 * (both[0] + both[1]), _histogram(cells[~(face | hands)])
    ratio = skin.ravel()[cells] / np.maximum(rest.ravel()[cells], 1e-9)
    return np.asarray(np.clip(np.log(np.maximum(ratio, 1e-9)), *SKIN_COLOUR_EVIDENCE))


def _histogram(cells: np.ndarray) -> np.ndarray:
    """Return the share of each cell, blurred, shape `BINS`."""
    counts = np.bincount(cells, minlength=int(np.prod(BINS))).reshape(BINS).astype(float)
    blurred = gaussian_filter(counts, BLUR, mode="constant", truncate=3.0)
    return np.asarray(blurred / max(float(blurred.sum()), 1e-300))
