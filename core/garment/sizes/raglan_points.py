"""Find the halves of raglan sleeves: their caps reach past the shoulder's tip to the neckline, a part of which is
theirs.

The trade grades such a sleeve from the side neck point, which is on the sleeve: along the arm by shoulder and arm,
across by the upper arm, and its neckline with that of the bodice (W. Aldrich, Metric Pattern Cutting for Women's Wear,
raglan sleeve; G. Cooklin, Pattern Grading for Women's Clothes)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..memo import memoise
from ..orientation import place_points
from ..panel_parts import Side, find_arm_panels, find_side
from ..pattern import EdgeRef, Pattern
from ..seams import find_sewn_partners
from .bodice_points import MAX_WALKED_EDGE_COUNT, FacePoints, PointRef, find_bodice_points, find_middle

MIN_NECK_EXTENT = 1e-3
"""Smallest extent of a neckline of which shares are taken [m]."""


@dataclass(frozen=True)
class RaglanHalf:
    """Describe the neck of one half of a raglan sleeve.

    Attributes:
        face: Front or back.
        sign: The side of the wearer.
        tip: The trunk's point where its neckline meets the sleeve.
        neck: The sleeve's point there.
        top: The side neck point, where the sleeve's neckline meets the seam over the arm.
        shoulder: Along that seam the next point of the outline, the shoulder's tip, or its end.
        over: The last edge of that seam, towards the hand: its first and last point.
    """

    face: Side
    sign: int
    tip: PointRef
    neck: PointRef
    top: PointRef
    shoulder: PointRef
    over: tuple[PointRef, PointRef]


@memoise
def find_raglan_halves(pattern: Pattern) -> tuple[RaglanHalf, ...]:
    """Find the halves of raglan sleeves whose seam over the arm joins a front and a back half; empty where sleeves end
    at a shoulder's tip, or are cut in one over the arm."""
    halves = (_find_half(pattern, face, sign) for face in find_bodice_points(pattern) for sign in face.tips)
    return tuple(half for half in halves if half is not None)


def find_shares(pattern: Pattern, half: RaglanHalf, throat: tuple[PointRef, ...]) -> tuple[float, float]:
    """Return the trunk's shares of the width and of the depth of half a neckline that a raglan sleeve ends in [1]; the
    sleeve has the rest.

    Args:
        pattern: The pattern.
        half: One of its halves.
        throat: The trunk's points of the neckline in the middle.
    """
    tip, neck, top = (_place(pattern, ref) for ref in (half.tip, half.neck, half.top))
    low = np.mean([_place(pattern, ref) for ref in throat], axis=0) if throat else tip
    own = np.abs(tip - [find_middle(pattern), low[1], 0.0])[:2]
    along, across = find_arm_axes(pattern, half)
    sleeve = np.abs([(top - neck) @ along, (neck - top) @ across])
    wide, deep = own / np.maximum(own + sleeve, MIN_NECK_EXTENT)
    return float(wide), float(deep)


def measure_neck_depth(pattern: Pattern, half: RaglanHalf) -> float:
    """Return how far the trunk's point lies below the side neck point [m], measured across the arm."""
    _, across = find_arm_axes(pattern, half)
    return float((_place(pattern, half.neck) - _place(pattern, half.top)) @ across)


def find_arm_axes(pattern: Pattern, half: RaglanHalf) -> tuple[np.ndarray, np.ndarray]:
    """Return the direction of the arm as placed, along the end of the seam over it, and the one across it from there
    towards the underarm, shape [3] each."""
    start, end = (_place(pattern, ref) for ref in half.over)
    along = (end - start) / np.linalg.norm(end - start)
    across = np.cross(pattern.panel(half.top[0]).rotation[:, 2], along)
    inward = _place(pattern, half.neck) - _place(pattern, half.top)
    return along, np.asarray(np.copysign(1.0, inward @ across) * across)


def find_raglan_throat(pattern: Pattern, face: FacePoints) -> tuple[PointRef, ...]:
    """Return the points in the middle of the neckline between a face's raglan sleeves; two where it is open there."""
    found = (_walk_to_throat(pattern, half.tip) for half in find_raglan_halves(pattern) if half.face is face.face)
    return tuple(dict.fromkeys(ref for ref in found if ref is not None))


def _find_half(pattern: Pattern, face: FacePoints, sign: int) -> RaglanHalf | None:
    tip = face.tips[sign]
    meeting = next(iter(_list_meeting_points(pattern, tip)), None)
    if sign in face.necks or meeting is None:
        return None
    (name, at), step = meeting
    arms, partners, count = find_arm_panels(pattern), find_sewn_partners(pattern), len(pattern.panel(name).points)
    neck = (name, at)
    for _ in range(count):
        partner = partners.get(_edge(pattern, (name, at), step))
        if partner is not None and partner.panel not in arms and find_side(pattern.panel(partner.panel)) is face.face:
            return None
        if partner is not None and partner.panel in arms:
            break
        at = (at + step) % count
    top, walked = (name, at), [at]
    while (partner := partners.get(_edge(pattern, (name, at), step))) is not None and partner.panel in arms:
        if partner.panel == name or len(walked) > count:
            return None
        at = (at + step) % count
        walked.append(at)
    if top == neck or len(walked) < 2:
        return None
    over = (name, walked[-2]), (name, walked[-1])
    return RaglanHalf(face.face, sign, tip, neck, top, (name, walked[1]), over)


def _list_meeting_points(pattern: Pattern, tip: PointRef) -> Iterator[tuple[PointRef, int]]:
    """Yield the sleeve's points that are sewn to the upper end of a trunk's armhole and from which its outline leads on
    to no other seam of the trunk, each with the step along the outline that leads away from the armhole."""
    arms, partners = find_arm_panels(pattern), find_sewn_partners(pattern)
    name, at = tip
    for seam in pattern.seams:
        for trunk, cap in ((seam.a, seam.b), (seam.b, seam.a)):
            count = len(pattern.panel(trunk.panel).points)
            ends = [trunk.edge, (trunk.edge + 1) % count]
            if trunk.panel != name or at not in ends or cap.panel not in arms:
                continue
            is_last = (ends.index(at) == 1) != seam.reversed
            point = (cap.panel, (cap.edge + is_last) % len(pattern.panel(cap.panel).points))
            step = 1 if is_last else -1
            partner = partners.get(_edge(pattern, point, step))
            if partner is None or partner.panel not in arms:
                yield point, step


def _walk_to_throat(pattern: Pattern, tip: PointRef) -> PointRef | None:
    """Return the trunk's point in the middle of the wearer on the neckline from a raglan sleeve on."""
    arms, partners, middle = find_arm_panels(pattern), find_sewn_partners(pattern), find_middle(pattern)
    panel = pattern.panel(tip[0])
    count = len(panel.points)
    partner = partners.get(_edge(pattern, tip, 1))
    step = -1 if partner is not None and partner.panel in arms else 1
    x = place_points(panel, panel.points)[:, 0] - middle
    for k in range(1, min(count, MAX_WALKED_EDGE_COUNT)):
        at = (tip[1] + step * k) % count
        if x[at] * x[tip[1]] <= 0.0 or abs(x[at]) <= abs(x).min() + MIN_NECK_EXTENT:
            return tip[0], at
    return None


def _edge(pattern: Pattern, point: PointRef, step: int) -> EdgeRef:
    """Return the edge that leaves a point along an outline, or against it."""
    name, at = point
    return EdgeRef(name, at if step > 0 else (at - 1) % len(pattern.panel(name).points))


def _place(pattern: Pattern, ref: PointRef) -> np.ndarray:
    panel = pattern.panel(ref[0])
    placed: np.ndarray = place_points(panel, panel.points[ref[1]])
    return placed
