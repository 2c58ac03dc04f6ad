"""Choose the garment's category from its contours and the bones they encircle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...body.body import Body
from .contours import ARM_BONES, LEG_BONES, limb_place
from .encirclement import find_crossings
from .target import Contour

LONG_SLEEVE = 1.5
"""Place on the arm [bones: 1 is the elbow, 2 the wrist] beyond which a cuff makes a sleeve long: the middle of the
forearm. Loose T-shirt sleeves reach a little past the elbow."""
SHORTS_END = 1.4
"""Place on the leg [bones: 1 the knee, 2 the ankle] above which trousers are shorts: knee-length shorts still are."""
DRESS_START = 0.4
"""Place on the leg [bones: 0 is the hip joint, 1 the knee] below which a hem makes a top a dress. The crotch is at
about 0.25, and a long shirt covers it."""


class LimbLimit(NamedTuple):
    """Describe a limit between two categories.

    Attributes:
        kind: First word of the openings' names.
        place: On the limb [bones].
        above: Category of garments that end above it.
        below: Category of those that end below.
    """

    kind: str
    place: float
    above: str
    below: str


LIMB_LIMITS = (
    LimbLimit("cuff", LONG_SLEEVE, "tshirt", "long_sleeve_tshirt"),
    LimbLimit("leg", SHORTS_END, "shorts", "trousers"),
)
"""Limits between categories by where sleeves or legs end."""


def choose_category(contours: tuple[Contour, ...], vertices: np.ndarray, body: Body) -> str:
    """Choose the category of a garment.

    | contours | category |
    |---|---|
    | legs and an upper contour at neck or arms | jumpsuit |
    | legs | trousers or shorts, by the knee |
    | waist, hem | skirt |
    | neck or arms, hem below mid-thigh | dress |
    | neck or arms, cuffs | tshirt or long_sleeve_tshirt, by the elbow |
    | neck or arms, no cuffs | tank |

    Args:
        contours: Named contours, from `name_contours`.
        vertices: Positions that the contours index [m], shape [vertex_count, 3].
        body: The wearer.
    """
    names = {contour.name: contour for contour in contours}
    is_top = any(name == "neck" or name.startswith(("cuff", "armhole")) for name in names)
    legs = _places(contours, vertices, body, "leg", LEG_BONES)
    if legs:
        if is_top:
            return "jumpsuit"
        return "shorts" if float(np.mean(legs)) < SHORTS_END else "trousers"
    if not is_top:
        return "skirt"
    hem = names.get("hem")
    if hem is not None:
        crossings = find_crossings(vertices[hem.vertices], body)
        places = [limb_place(crossings, side, LEG_BONES) for side in ("left", "right")]
        below = [place for place in places if np.isfinite(place)]
        if below and float(np.mean(below)) > DRESS_START:
            return "dress"
    cuffs = _places(contours, vertices, body, "cuff", ARM_BONES)
    if not cuffs:
        return "tank"
    return "long_sleeve_tshirt" if float(np.mean(cuffs)) > LONG_SLEEVE else "tshirt"


def _places(
    contours: tuple[Contour, ...], vertices: np.ndarray, body: Body, kind: str, limb: tuple[str, ...]
) -> list[float]:
    """Place a kind's contours along their limb; one that no longer goes around it (NaN) counts only if none does."""
    places = []
    for contour in contours:
        stem, _, side = contour.name.partition(".")
        if stem == kind:
            places.append(limb_place(find_crossings(vertices[contour.vertices], body), side, limb))
    return [place for place in places if np.isfinite(place)] or places
