"""Turn sleeves that were drafted for hanging arms along the arms of a T-pose, before panels are welded."""

from __future__ import annotations

import numpy as np

from ...body.body import Body
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...geometry.rigid import plane_rotation
from ...scan.contours.loop import find_loops

MAX_SLEEVE_ARM_ANGLE = np.radians(15.0)
"""Angle between sleeve and arm up to which a sleeve stays as drafted if the arm then starts inside it [rad]. T-shirts
droop by 12 degrees, and patterns for an A-pose by 30 to 60."""
MIN_HANGING_TUBE_ANGLE = np.radians(75.0)
"""Angle below the horizontal from which a tube belongs to a leg or hangs along the trunk, and is no sleeve [rad]."""

MAX_CUFF_SINK_SHARE = 0.5
"""Share of half the thickness of an arm by which the upper end of a cuff, as drafted, may be below the upper side of
the arm. It must end above the middle of the arm, to be pushed up; welded and placed, a T-shirt's was 2 cm lower."""

MAX_SLEEVE_RAISE_ANGLE = np.radians(45.0)
"""Angle above the arm from which a panel that ends in an opening of its own is no sleeve [rad]: none is drafted for
raised arms, and from the seams of the side panel of a bodice to its armhole it is 60 degrees and more."""


def turn_sleeves(garment: Garment, body: Body, lift: float) -> tuple[np.ndarray, np.ndarray]:
    """Turn sleeves in the plane of the panels until they point along the wearer's arms.

    A sleeve is a group of sewn panels beyond one shoulder that ends in an open contour of its own; its axis runs from
    the middle of the seams by which it hangs to the middle of that contour. Sleeves near the arm's direction stay
    unchanged, as do tubes along the trunk and panels whose opening is above their seams (the side panels of a bodice
    with princess seams). A sleeve whose upper end would sink to the middle of the arm is raised until it does not, for
    the arm would come out through it and not through the cuff. The gap at a turned sleeve's armhole is the difference
    between the author's pose and the T-pose; welding spreads it into the panels.

    Args:
        garment: The sewn garment; its nodes are not used.
        body: The body in its T-pose, facing +z.
        lift: Height of the garment above the body's shoulders [m].

    Returns:
        Panel axes in the x, y plane, shape [panel_count, 2, 2], and panel origins [m], shape [panel_count, 2].
    """
    pattern = garment.pattern
    rotation = np.stack([panel.rotation[:2, :2] for panel in pattern.panels])
    origin = np.stack([panel.translation[:2] for panel in pattern.panels])
    place = np.einsum("nij,nj->ni", rotation[garment.panel_of_uv], garment.uv) + origin[garment.panel_of_uv]
    centre = 0.5 * (place[:, 0].min() + place[:, 0].max())
    shoulder = 0.5 * abs(float(body.joint("left_shoulder")[0] - body.joint("right_shoulder")[0]))
    middle = np.array([0.5 * np.ptp(place[members, 0]) + place[members, 0].min() for members in _members(garment)])
    loops = find_loops(garment.faces)
    for side, name in ((1.0, "left"), (-1.0, "right")):
        direction = body.joint(f"{name}_wrist") - body.joint(f"{name}_shoulder")
        arm = np.arctan2(-direction[1], side * direction[0])
        upward = np.array([side * np.sin(arm), np.cos(arm)])
        half = _half_thickness(body, name)
        for group in _groups(pattern, side * (middle - centre) > shoulder):
            ends = _ends(garment, place, group, loops)
            if ends is None:
                continue
            cap, cuff = (points.mean(axis=0) for points in ends)
            axis = cuff - cap
            droop = np.arctan2(-axis[1], side * axis[0])
            is_sinking = float((ends[0] @ upward).max() - (ends[1] @ upward).max()) > lift + MAX_CUFF_SINK_SHARE * half
            if (
                (abs(droop - arm) <= MAX_SLEEVE_ARM_ANGLE and not is_sinking)
                or abs(droop) >= MIN_HANGING_TUBE_ANGLE
                or arm - droop >= MAX_SLEEVE_RAISE_ANGLE
            ):
                continue
            raised = max(droop - arm, _raise_above(ends, side, upward, lift)) if is_sinking else droop - arm
            turned = plane_rotation(side * raised)
            rotation[group] = turned @ rotation[group]
            origin[group] = (origin[group] - cap) @ turned.T + cap
    return rotation, origin


def _raise_above(ends: tuple[np.ndarray, np.ndarray], side: float, upward: np.ndarray, sunk: float) -> float:
    """Return the least angle that raises a sleeve until its cuff's top is at most `sunk` below its cap's [m].

    A sleeve that is cut in one with a wide body narrows from below and above: with its axis along the arm, it would be
    below the arm. The angle is at most `MAX_SLEEVE_RAISE_ANGLE`.
    """
    for angle in np.arange(0.0, MAX_SLEEVE_RAISE_ANGLE, np.radians(1.0)):
        along = plane_rotation(side * angle).T @ upward
        cap, cuff = ((points @ along).max() for points in ends)
        if cap - cuff <= sunk:
            return float(angle)
    return float(MAX_SLEEVE_RAISE_ANGLE)


def _members(garment: Garment) -> list[np.ndarray]:
    return [garment.panel_of_uv == index for index in range(len(garment.pattern.panels))]


def _groups(pattern: Pattern, chosen: np.ndarray) -> list[list[int]]:
    """Return the groups of chosen panels that are sewn together."""
    index = {panel.name: i for i, panel in enumerate(pattern.panels)}
    label = np.arange(len(pattern.panels))
    for seam in pattern.seams:
        a, b = index[seam.a.panel], index[seam.b.panel]
        if chosen[a] and chosen[b]:
            label[label == label[b]] = label[a]
    return [np.flatnonzero(chosen & (label == name)).tolist() for name in np.unique(label[chosen])]


def _half_thickness(body: Body, name: str) -> float:
    """Return half the height of an upper arm of a body in its T-pose [m], within 1 cm of its middle."""
    shoulder, elbow = body.joint(f"{name}_shoulder"), body.joint(f"{name}_elbow")
    middle = 0.5 * (shoulder + elbow)
    is_near = (np.abs(body.vertices[:, 0] - middle[0]) < 0.01) & (np.abs(body.vertices[:, 1] - middle[1]) < 0.1)
    return 0.5 * float(np.ptp(body.vertices[is_near, 1])) if is_near.any() else 0.0


def _ends(
    garment: Garment, place: np.ndarray, group: list[int], loops: tuple[np.ndarray, ...]
) -> tuple[np.ndarray, np.ndarray] | None:
    """Return a sleeve's vertices at cap and cuff [m], shape [n, 2] each, or None where a group lacks one."""
    inside = np.isin(garment.panel_of_uv, group)
    count = np.bincount(garment.uv_node)
    counted = np.bincount(garment.uv_node[inside], minlength=len(count))
    cuffs = [loop for loop in loops if (counted[loop] == count[loop]).all()]
    cap = inside & (counted[garment.uv_node] < count[garment.uv_node])
    if len(cuffs) != 1 or not cap.any():
        return None
    cuff = inside & np.isin(garment.uv_node, cuffs[0])
    return place[cap], place[cuff]
