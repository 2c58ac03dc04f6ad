"""Find the halves of sleeves with the points that grade rules move: the cap's top, the underarm, the sleeve's end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..memo import memoise
from ..orientation import place_points
from ..panel_parts import find_arm_panels
from ..pattern import EdgeRef, Panel, Pattern
from ..seams import find_sewn_partners
from .bodice_points import PointRef, find_bodice_points
from .raglan_points import find_arm_axes, find_raglan_halves

SAME_PLANE_TOLERANCE = 1e-6
"""Difference of two panels' rotations up to which they lie in one plane [1]: a file's rounding."""

MAX_LOW_CAP_RATIO = 1.0 / 3.0
"""Largest ratio of the height of a low cap to half its width: its length is nearly the bicep's, and hardly changes with
its height."""


@dataclass(frozen=True)
class ArmHalf:
    """Describe one half of a sleeve, from its fold or its seam over the arm to the underarm; coordinates are along the
    arm from the cap's top, and across it from there.

    Attributes:
        sign: The side of the wearer.
        top, under: The cap's top, and the underarm point.
        ends: Points at the sleeve's end with the smallest and the largest coordinate across.
        panels: Names of its panels, those of cuffs too.
        along, across: Unit vectors of the coordinates, in the placed plane, shape [3].
        cap_height, width, length, end_width: Underarm point along and across, sleeve's end along and its width [m].
        shoulder: How far the shoulder's tip is along from the top [m]: more than 0 where a raglan sleeve begins at the
            neck.
    """

    sign: int
    top: PointRef
    under: PointRef
    ends: tuple[PointRef, PointRef]
    panels: tuple[str, ...]
    along: np.ndarray
    across: np.ndarray
    cap_height: float
    width: float
    length: float
    end_width: float
    shoulder: float = 0.0


@memoise
def find_arm_halves(pattern: Pattern) -> tuple[ArmHalf, ...]:
    """Find the halves of both sleeves; empty where no cap reaches from a shoulder's tip, or a neckline, to an underarm
    point."""
    tops = {ref: sign for face in find_bodice_points(pattern) for sign, ref in face.tips.items()}
    unders = {ref: sign for face in find_bodice_points(pattern) for sign, ref in face.underarms.items()}
    depths = find_arm_panels(pattern)
    sewn = _map_to_trunk(pattern)
    caps = {name for name, depth in depths.items() if depth == 1}
    halves: list[ArmHalf | None] = []
    for top, sign in ((ref, tops[trunk]) for ref, trunk in sewn if trunk in tops):
        group = [name for name in depths if _in_one_plane(pattern.panel(name), pattern.panel(top[0]))]
        group = [name for name in group if _find_sign(pattern, name) == sign]
        own = list(dict.fromkeys(ref for ref, trunk in sewn if trunk in unders and ref[0] in group))
        if any(half is not None and half.top == top for half in halves):
            continue
        along = _find_direction(pattern, top, own, caps)
        if along is None:
            continue
        halves += [_measure_half(pattern, sign, top, under, along, tuple(group), len(own) == 2) for under in own]
    found = tuple(half for half in halves if half is not None)
    return found or tuple(_list_raglan_arms(pattern, unders, sewn))


def _list_raglan_arms(
    pattern: Pattern, unders: dict[PointRef, int], sewn: list[tuple[PointRef, PointRef]]
) -> Iterator[ArmHalf]:
    """Yield the halves of raglan sleeves, their caps' tops at the side neck points.

    Args:
        pattern: The pattern.
        unders: Underarm points of the trunk, with their sides.
        sewn: Points of sleeves with those of the trunk that they are sewn to.
    """
    depths = find_arm_panels(pattern)
    for raglan in find_raglan_halves(pattern):
        own = [ref for ref, trunk in sewn if trunk in unders and ref[0] == raglan.top[0]]
        plane = [name for name in depths if _in_one_plane(pattern.panel(name), pattern.panel(raglan.top[0]))]
        group = tuple(name for name in plane if _find_sign(pattern, name) == raglan.sign)
        along, _ = find_arm_axes(pattern, raglan)
        half = _measure_half(pattern, raglan.sign, raglan.top, own[0], along, group, False) if own else None
        if half is not None:
            panel = pattern.panel(raglan.shoulder[0])
            tip, _ = arm_coordinates(pattern, half, panel, panel.points[[raglan.shoulder[1]]])
            yield replace(half, shoulder=float(tip[0]) if raglan.shoulder != raglan.over[1] else 0.0)


def is_cap_low(halves: tuple[ArmHalf, ...]) -> bool:
    """Check whether caps are so low that a sleeve's width follows from its armhole rather than from the arm."""
    return any(half.cap_height < MAX_LOW_CAP_RATIO * half.width for half in halves)


def arm_coordinates(pattern: Pattern, half: ArmHalf, panel: Panel, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the coordinates of a panel's points along and across a half of a sleeve [m], shape [n] each."""
    top = pattern.panel(half.top[0])
    placed = place_points(panel, points) - place_points(top, top.points[half.top[1]])
    return placed @ half.along, placed @ half.across


def _map_to_trunk(pattern: Pattern) -> list[tuple[PointRef, PointRef]]:
    """Return the ends of the cap's edges, each with the trunk's point that it is sewn to."""
    arms = find_arm_panels(pattern)
    found: list[tuple[PointRef, PointRef]] = []
    for seam in pattern.seams:
        for cap, trunk in ((seam.a, seam.b), (seam.b, seam.a)):
            if cap.panel in arms and trunk.panel not in arms:
                ends = [_list_ends(pattern, ref) for ref in (cap, trunk)]
                found += zip(ends[0], ends[1][::-1] if seam.reversed else ends[1], strict=True)
    return list(dict.fromkeys(found))


def _list_ends(pattern: Pattern, ref: EdgeRef) -> list[PointRef]:
    count = len(pattern.panel(ref.panel).points)
    return [(ref.panel, ref.edge), (ref.panel, (ref.edge + 1) % count)]


def _find_sign(pattern: Pattern, name: str) -> int:
    """Return the sign of the side of the wearer on which an arm's panel lies."""
    x = np.concatenate([place_points(panel, panel.points)[:, 0] for panel in pattern.panels])
    panel = pattern.panel(name)
    return 1 if place_points(panel, panel.points)[:, 0].mean() > (x.min() + x.max()) / 2.0 else -1


def _in_one_plane(first: Panel, second: Panel) -> bool:
    return bool(
        np.abs(first.rotation - second.rotation).max() < SAME_PLANE_TOLERANCE
        and abs((first.translation - second.translation) @ first.rotation[:, 2]) < SAME_PLANE_TOLERANCE
    )


def _find_direction(pattern: Pattern, top: PointRef, unders: list[PointRef], caps: set[str]) -> np.ndarray | None:
    """Return the direction of the arm in the placed plane, shape [3]: across both underarm points of a whole sleeve,
    along the seam over the arm of a half one; None where there is neither."""
    panel = pattern.panel(top[0])
    if len(unders) == 2:
        ends = [pattern.panel(name).points[i] for name, i in unders]
        chord = ends[1] - ends[0]
        flat = np.array([-chord[1], chord[0]])
        flat *= np.sign(flat @ (0.5 * (ends[0] + ends[1]) - panel.points[top[1]]))
    elif len(unders) == 1:
        partners, count = find_sewn_partners(pattern), len(panel.points)
        sides = {1: EdgeRef(top[0], top[1]), -1: EdgeRef(top[0], (top[1] - 1) % count)}
        over = [step for step, ref in sides.items() if ref in partners and partners[ref].panel in caps]
        if len(over) != 1:
            return None
        flat = panel.points[(top[1] + over[0]) % count] - panel.points[top[1]]
    else:
        return None
    found: np.ndarray = panel.rotation[:, :2] @ flat / np.linalg.norm(flat)
    return found


def _measure_half(
    pattern: Pattern,
    sign: int,
    top: PointRef,
    under: PointRef,
    along: np.ndarray,
    group: tuple[str, ...],
    is_whole: bool,
) -> ArmHalf | None:
    """Return a half of a sleeve with its measures; None where it has no end beyond its cap."""
    across = np.cross(pattern.panel(top[0]).rotation[:, 2], along)
    half = ArmHalf(sign, top, under, (top, top), group, along, across, 0.0, 0.0, 0.0, 0.0)
    lower = pattern.panel(under[0])
    height, width = (float(value[0]) for value in arm_coordinates(pattern, half, lower, lower.points[[under[1]]]))
    half = replace(half, across=np.copysign(1.0, width) * across, cap_height=height, width=abs(width))
    found = []
    for ref in _list_sleeve_ends(pattern, group):
        own = pattern.panel(ref[0])
        s, t = (float(value[0]) for value in arm_coordinates(pattern, half, own, own.points[[ref[1]]]))
        found.append((t, s, ref))
    if not found or width == 0.0:
        return None
    length, last = max(s for _, s, _ in found), max(found)
    first = (0.0, 0.0, top) if is_whole else min(found)
    if not 0.0 < height < length or last[0] <= first[0]:
        return None
    return replace(half, ends=(first[2], last[2]), length=length, end_width=last[0] - first[0])


def _list_sleeve_ends(pattern: Pattern, group: tuple[str, ...]) -> list[PointRef]:
    """Return the points of a sleeve's edges towards the hand: open ones, and those sewn to a cuff."""
    depths, partners = find_arm_panels(pattern), find_sewn_partners(pattern)
    found: list[PointRef] = []
    for name in (name for name in group if depths[name] == 1):
        for i in range(len(pattern.panel(name).points)):
            partner = partners.get(EdgeRef(name, i))
            if partner is None or depths.get(partner.panel, 0) > 1:
                found += _list_ends(pattern, EdgeRef(name, i))
    return list(dict.fromkeys(found))
