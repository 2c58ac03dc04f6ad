"""Choose a sleeve by its length: how far along the arm the scan's cuffs are."""

from __future__ import annotations

import math

import numpy as np

from ...body.body import Body
from ...garment.parts.cut import Cut, Sleeve
from ...garment.parts.sleeves import SLEEVES
from ...scan.contours.target import Target
from .distances import limb_chain, loop_centre, position_along

DRAFT_ARM_LENGTH = 0.49
"""Length of the arm from shoulder to wrist that sleeves are drafted for [m]: the built-in female body's of 1.70 m."""

MIN_SLEEVE_MISMATCH_FACTOR = 1.5
"""Factor by which a sleeve has to be too long or too short to be replaced: grading corrects lengths, and with a dropped
shoulder seam a short sleeve reaches 1.3 to 1.5 times its length."""

MAX_SLEEVE_DISTANCE_SHARE = 1.0 / 3.0
"""Share of a sleeve's distance from the scan's length, in logarithms, below which another's distance replaces it:
halfway between two a change gains nothing (that of a T-shirt at 0.47: panels 3.0 % off become 3.4 % off)."""


def fit_sleeve(target: Target, body: Body, cut: Cut) -> Cut:
    """Return the cut with the sleeve whose length is clearly the scan's; unchanged where none is, or its own is near.

    Lengths run from the shoulder joint along the arm to the middle of the cuff, as a share of the arm's length.
    """
    reach = cuff_reach(target, body)
    if reach is None or cut.sleeve is Sleeve.NONE:
        return cut
    distances = {sleeve: abs(math.log(reach * DRAFT_ARM_LENGTH / drawn.length)) for sleeve, drawn in SLEEVES.items()}
    nearest, current = min(distances, key=distances.__getitem__), distances[cut.sleeve]
    return (
        cut.choose({"sleeve": str(nearest)})
        if current > math.log(MIN_SLEEVE_MISMATCH_FACTOR) and distances[nearest] < MAX_SLEEVE_DISTANCE_SHARE * current
        else cut
    )


def cuff_reach(target: Target, body: Body) -> float | None:
    """Return the distance of the cuffs along the arm as a share of shoulder to wrist; None where none is trusted."""
    found = []
    for contour in target.contours:
        if contour.name.startswith("cuff") and contour.trusted:
            chain = limb_chain(contour.name, body)
            shoulder, wrist = (position_along(chain, chain[i]) for i in (1, 3))
            cuff = position_along(chain, loop_centre(target.vertices[contour.vertices]))
            found.append((cuff - shoulder) / (wrist - shoulder))
    return max(float(np.mean(found)), 0.05) if found else None
