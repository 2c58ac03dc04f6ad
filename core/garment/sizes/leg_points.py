"""Find the named points of legs that grade rules move: waist, crotch point, knee and hem."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..memo import memoise
from ..orientation import place_points
from ..panel_parts import find_arm_panels, find_side
from ..pattern import EdgeRef, Panel, Pattern
from ..seams import find_sewn_partners
from .bodice_points import LEG_CONTOUR, PointRef, find_middle, is_armhole

KNEE_SPAN = (0.3, 0.75)
"""Range of heights between a leg's hem (0) and its crotch point (1) in which a knee is [1]: knees are at 0.6 of the
crotch's height, and hems up to the calf's."""

KNEE_LEVEL_TOLERANCE = 0.03
"""Largest difference in height of both points of a knee [m]."""


@dataclass(frozen=True)
class LegPoints:
    """Describe the named points of the front or the back of one leg; pairs are towards the middle and outside.

    Attributes:
        panel: Its panel.
        sign: The side of the wearer.
        hems: Both ends of the hem.
        fork: The crotch point, where the inseam ends.
        knees: The knee's points; none where seams have no control points there.
        hip: The point of the side seam above the crotch; none where there is none.
        tops: Both ends of the waist, in the middle and at the side; none where the legs go on in a bodice.
    """

    panel: str
    sign: int
    hems: tuple[PointRef, PointRef]
    fork: PointRef
    knees: tuple[PointRef, PointRef] | None = None
    hip: PointRef | None = None
    tops: tuple[PointRef, PointRef] | None = None


@memoise
def find_leg_points(pattern: Pattern) -> tuple[LegPoints, ...]:
    """Find the named points of each panel with an open contour of a leg; empty where there is none."""
    middle, found = find_middle(pattern), []
    for panel in pattern.panels:
        own = [i for i, edge in enumerate(panel.edges) if edge.contour.startswith(LEG_CONTOUR)]
        if len(own) == 1:
            points = _find_points(pattern, panel, own[0], middle)
            if points is not None:
                found.append(points)
    return tuple(found)


def _find_points(pattern: Pattern, panel: Panel, hem: int, middle: float) -> LegPoints | None:
    """Return the points of a panel with a hem; None where no inseam goes up from it."""
    count = len(panel.points)
    placed = place_points(panel, panel.points)
    sign = 1 if placed[:, 0].mean() > middle else -1
    ends = [(hem, -1), ((hem + 1) % count, 1)]
    inner, outer = sorted(ends, key=lambda end: sign * placed[end[0], 0])
    inseam, outseam = (_walk_up(pattern, panel, *end) for end in (inner, outer))
    if len(inseam) < 2 or len(outseam) < 2:
        return None
    name, fork = panel.name, inseam[-1]
    pairs = [
        (abs(placed[i, 1] - placed[k, 1]), i, k)
        for i in inseam[1:-1]
        for k in outseam[1:-1]
        if KNEE_SPAN[0] < (placed[i, 1] - placed[inner[0], 1]) / (placed[fork, 1] - placed[inner[0], 1]) < KNEE_SPAN[1]
    ]
    gap, *knee = min(pairs, default=(np.inf, 0, 0))
    knees = ((name, int(knee[0])), (name, int(knee[1]))) if gap < KNEE_LEVEL_TOLERANCE else None
    side, step = outseam[-1], outer[1]
    edge = side if step > 0 else (side - 1) % count
    centre = (side + step) % count
    while edge != hem and _is_waist(pattern, EdgeRef(name, (edge + step) % count)):
        edge, centre = (edge + step) % count, (centre + step) % count
    tops = ((name, centre), (name, side)) if _is_waist(pattern, EdgeRef(name, edge)) else None
    above = [i for i in outseam[1:-1] if placed[i, 1] > placed[fork, 1]]
    hip = (name, above[0]) if above else None
    return LegPoints(name, sign, ((name, inner[0]), (name, outer[0])), (name, fork), knees, hip, tops)


def _is_waist(pattern: Pattern, ref: EdgeRef) -> bool:
    """Check whether an edge of a leg is at its waist: open and around no arm, or sewn to what is no leg."""
    partner = find_sewn_partners(pattern).get(ref)
    if partner is None:
        return not is_armhole(pattern, ref)
    other = pattern.panel(partner.panel)
    is_leg = any(edge.contour.startswith(LEG_CONTOUR) for edge in other.edges)
    return not is_leg and partner.panel not in find_arm_panels(pattern)


def _walk_up(pattern: Pattern, panel: Panel, start: int, step: int) -> list[int]:
    """Return the control points from a hem's end along the seam to the other face."""
    partners, count, walked = find_sewn_partners(pattern), len(panel.points), [start]
    while len(walked) < count:
        edge = walked[-1] if step > 0 else (walked[-1] - 1) % count
        partner = partners.get(EdgeRef(panel.name, edge))
        if partner is None or find_side(pattern.panel(partner.panel)) is find_side(panel):
            break
        walked.append((walked[-1] + step) % count)
    return walked
