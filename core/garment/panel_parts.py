"""Find the part of a garment that a panel belongs to, and its side of the wearer: by words, or by its place."""

from __future__ import annotations

import re
from enum import StrEnum

import numpy as np

from .memo import memoise
from .orientation import place_points
from .pattern import EdgeRef, Panel, Pattern
from .seams import find_sewn_partners

PART_WORDS = ("sleeve", "arm", "cuff", "collar", "hood", "band", "wb", "skirt", "leg", "pant", "yoke", "body", "torso")
"""Words of labels, or else of names, of panels that say which part of a garment they belong to."""

ARM_PARTS = ("sleeve", "arm", "cuff")
"""Parts of a garment on the arms."""

MIDDLE_REACH = 0.03
"""Distance of a panel from the wearer's middle up to which it belongs to trunk or legs [m]: panels are placed at the
middle to within the play of a seam."""

MIN_FACING_COSINE = np.cos(np.radians(60.0))
"""Smallest cosine between a panel's normal and the wearer's front or back at which it is on that side (60 degrees)."""


class Side(StrEnum):
    """List the sides of the wearer on which a panel can be."""

    BACK = "back"
    FRONT = "front"
    BESIDE = "beside"


def find_part(panel: Panel) -> str:
    """Return the part of a garment that a panel belongs to, one of `PART_WORDS`; an empty text where neither label nor
    name says it."""
    for text in (panel.label.lower(), panel.name.lower()):
        for word in PART_WORDS:
            if word in text:
                return word
    return ""


def find_side(panel: Panel) -> Side:
    """Return the side of the wearer on which a panel is: as its name says, else by the outward normal of its place."""
    words = {*re.split(r"[\W_]+", panel.name.lower())}
    for side in (Side.BACK, Side.FRONT):
        if side in words:
            return side
    depth = float(panel.rotation[2, 2])
    if abs(depth) < MIN_FACING_COSINE:
        return Side.BESIDE
    return Side.BACK if depth < 0.0 else Side.FRONT


@memoise
def find_arm_panels(pattern: Pattern) -> dict[str, int]:
    """Return the panels on the arms, each with its number of seams from the trunk: those that are called so, and those
    that lie beside the trunk, as far from the middle as its panels are wide, and are no gores of it."""
    spans = {panel.name: place_points(panel, panel.points)[:, 0] for panel in pattern.panels}
    x = np.concatenate(list(spans.values()))
    middle = (x.min() + x.max()) / 2.0
    at_middle = {
        name for name, own in spans.items() if own.min() - middle < MIDDLE_REACH and own.max() - middle > -MIDDLE_REACH
    }
    half = max((float(np.abs(spans[name] - middle).max()) for name in at_middle), default=np.inf)
    called = {panel.name for panel in pattern.panels if find_part(panel) in ARM_PARTS}
    beside = {
        panel.name
        for panel in pattern.panels
        if not find_part(panel) and panel.name not in at_middle and abs(spans[panel.name].mean() - middle) > half
    }
    while gores := {name for name in beside if _is_gore(pattern, name, called | beside)}:
        beside -= gores
    arms = called | beside
    depths: dict[str, int] = {}
    reached, depth = set(spans) - arms, 0
    while reached:
        depth += 1
        sides = [(seam.a.panel, seam.b.panel) for seam in pattern.seams]
        links = {one for pair in sides for one, other in (pair, pair[::-1]) if other in reached}
        reached = {name for name in links & arms if name not in depths}
        depths |= dict.fromkeys(reached, depth)
    return depths


def _is_gore(pattern: Pattern, name: str, arms: set[str]) -> bool:
    """Check whether a panel beside the trunk is a part of it: each of its open runs, waist and hem, begins or ends at a
    seam with the trunk, and it is sewn to one other such panel at most. A sleeve's end lies between seams of the arm;
    the free edge of a sleeve that is a cap alone lies between both ends of one seam."""
    partners, count = find_sewn_partners(pattern), len(pattern.panel(name).edges)
    found = [partners.get(EdgeRef(name, i)) for i in range(count)]
    others = [None if ref is None else ref.panel for ref in found]
    trunk = {other for other in others if other is not None and other not in arms}
    beyond = {other for other in others if other in arms}
    starts = [i for i in range(count) if others[i] is None and others[i - 1] is not None]
    if not trunk or not starts or len(beyond) > 1 or (not beyond and len(starts) == 1 and len(trunk) < 3):
        return False
    for start in starts:
        end = next(k % count for k in range(start, start + count) if others[k % count] is not None)
        if not {others[start - 1], others[end]} & trunk:
            return False
    return True
