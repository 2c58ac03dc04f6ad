"""Grade rules for girths: the moves of a shipped template's control points that widen it at one place."""

from __future__ import annotations

from functools import cache

import numpy as np

from ...body.girths import BELOW_ARMPIT
from ...garment.measures import BodyMeasures
from ...garment.pattern import Panel, Pattern
from ...garment.templates import draft_template

SEWN_POINT_TOLERANCE = 5e-3
"""Distance up to which placed control points are sewn together [m], more than the equalisation of seams moves."""

MAX_CONTROL_POINT_DISTANCE = 0.1
"""Largest distance of a place's control points from the place [m]; points further away shape another place."""


def widening_rules(template: str) -> dict[str, np.ndarray]:
    """Return the moves of control points that lengthen a line of cloth by its unit, by the place of the line.

    Around trunk and legs each place is at the height of control points, those nearest to where the draft measures it; a
    waist from which the garment hangs is at that of its edge. There each panel is widened about its middle, by its
    share of the whole line. Between places the widening is interpolated linearly; it is constant below the lowest, and
    fades above the highest up to the panel's top. Sleeves are widened along the underarm; the corners of their armholes
    go down with them. The rules depend on the template only, so that one refit reverses another.

    Args:
        template: Name of a shipped template.

    Returns:
        By place: moves in the panels' axes, shape [point_count, 2]. The unit is about the line's length [m].

    Raises:
        TemplateUnknown: where there is none of that name.
    """
    return dict(_rules(template))


@cache
def _rules(template: str) -> tuple[tuple[str, np.ndarray], ...]:
    measures = BodyMeasures()
    pattern = draft_template(template, measures)
    placed = _place_points(pattern)
    sleeve = np.concatenate([np.full(len(panel.points), panel.label == "sleeve") for panel in pattern.panels])
    rules = _body_rules(pattern, placed, sleeve, measures)
    if sleeve.any():
        rules["upper_arm"] = _arm_rule(pattern, placed, sleeve)
    found = []
    for name, moves in rules.items():
        turned = np.einsum("nij,ni->nj", _axes(pattern), moves)  # the world's x, y to the panels' axes
        turned.flags.writeable = False
        found.append((name, turned))
    return tuple(found)


def _axes(pattern: Pattern) -> np.ndarray:
    """Return each control point's panel axes in the world's x, y, shape [point_count, 2, 2]."""
    return np.concatenate([np.tile(panel.rotation[:2, :2], (len(panel.points), 1, 1)) for panel in pattern.panels])


def _place_points(pattern: Pattern) -> np.ndarray:
    """Return the control points where the draft places them: across and up [m], shape [point_count, 2]."""
    return np.concatenate([_place_panel(panel) for panel in pattern.panels])


def _place_panel(panel: Panel) -> np.ndarray:
    return np.asarray(panel.points @ panel.rotation[:2, :2].T + panel.translation[:2])


def _body_rules(
    pattern: Pattern, placed: np.ndarray, sleeve: np.ndarray, measures: BodyMeasures
) -> dict[str, np.ndarray]:
    """Return the rules of all places around trunk and legs, moves in the world's x, y, shape [point_count, 2] each."""
    knots = _find_girth_heights(pattern, placed[~sleeve, 1], measures)
    heights = placed[:, 1]
    order = sorted(knots, key=lambda name: knots[name])  # from below
    levels = [knots[name] for name in order]
    tops = np.concatenate([np.full(len(panel.points), _place_panel(panel)[:, 1].max()) for panel in pattern.panels])
    fade = np.clip((tops - heights) / np.maximum(tops - levels[-1], SEWN_POINT_TOLERANCE), 0.0, 1.0)
    rules = {}
    for index, name in enumerate(order):
        weights = np.interp(heights, levels, np.eye(len(order))[index])
        if index == len(order) - 1 and not _hangs_from_waist(pattern):
            weights = np.where(heights > levels[-1], fade, weights)
        middles, widths = _chords(pattern, placed, levels[index])
        moves = np.zeros_like(placed)
        moves[:, 0] = weights * (placed[:, 0] - middles) / widths
        moves *= 2.0 if name == "thigh" else 1.0  # all panels together are two lines there
        rules[name] = np.where(sleeve[:, None], 0.0, moves)
    return rules


def _find_girth_heights(pattern: Pattern, heights: np.ndarray, measures: BodyMeasures) -> dict[str, float]:
    """Return the height of each place that has control points of its own [m]."""
    girth_heights = {"chest": measures.armpit_height - BELOW_ARMPIT, "waist": measures.waist_height}
    girth_heights |= {"hip": measures.hip_height}
    if any(edge.contour.startswith("leg") for panel in pattern.panels for edge in panel.edges):
        girth_heights["thigh"] = measures.crotch_height
    known: dict[str, float] = {}
    if _hangs_from_waist(pattern):
        del girth_heights["chest"], girth_heights["waist"]
        known["waist"] = _lowest_of_waist(pattern)
    pairs = [(abs(float(height) - at), name, float(height)) for name, at in girth_heights.items() for height in heights]
    for distance, name, height in sorted(pairs):
        is_free = all(abs(height - other) > SEWN_POINT_TOLERANCE for other in known.values())
        if distance <= MAX_CONTROL_POINT_DISTANCE and name not in known and is_free:
            known[name] = height
    return known


def _lowest_of_waist(pattern: Pattern) -> float:
    """Return the lowest height of the edge from which a garment hangs [m]."""
    heights = []
    for panel in pattern.panels:
        along = _place_panel(panel)[:, 1]
        ends = [(i, (i + 1) % len(along)) for i, edge in enumerate(panel.edges) if edge.contour == "waist"]
        heights += [float(along[list(pair)].min()) for pair in ends]
    return min(heights)


def _hangs_from_waist(pattern: Pattern) -> bool:
    """Check whether a pattern's garment hangs from the waist."""
    return any(edge.contour == "waist" for panel in pattern.panels for edge in panel.edges)


def _chords(pattern: Pattern, placed: np.ndarray, height: float) -> tuple[np.ndarray, float]:
    """Return the middle of each point's panel at a height, shape [point_count], and the width of all of them [m]."""
    middles, whole = [], 0.0
    for panel in pattern.panels:
        points = _place_panel(panel)
        ends = _cross_at_height(points, height)
        if ends is None:
            ends = float(points[:, 0].min()), float(points[:, 0].max())
        elif panel.label != "sleeve":
            whole += ends[1] - ends[0]
        middles.append(np.full(len(points), 0.5 * (ends[0] + ends[1])))
    return np.concatenate(middles), whole


def _cross_at_height(points: np.ndarray, height: float) -> tuple[float, float] | None:
    """Return the outermost points at which a closed polygon crosses a height [m], or None where it does not."""
    after = np.roll(points, -1, axis=0)
    low, high = np.minimum(points[:, 1], after[:, 1]), np.maximum(points[:, 1], after[:, 1])
    cut = (low <= height) & (height <= high) & (high > low)
    if not cut.any():
        return None
    share = (height - points[cut, 1]) / (after[cut, 1] - points[cut, 1])
    found = points[cut, 0] + share * (after[cut, 0] - points[cut, 0])
    return float(found.min()), float(found.max())


def _arm_rule(pattern: Pattern, placed: np.ndarray, sleeve: np.ndarray) -> np.ndarray:
    """Return the rule of the upper arms: the underarm goes down by half, for each line crosses two half sleeves."""
    moves = np.zeros_like(placed)
    starts = pattern.point_starts
    for panel, first, end in zip(pattern.panels, starts[:-1], starts[1:], strict=True):
        if panel.label == "sleeve":
            arm = placed[first:end]
            low = first + np.flatnonzero(arm[:, 1] < arm[:, 1].mean())
            moves[low, 1] = -0.5
    lowered = placed[moves[:, 1] < 0.0]
    apart = np.linalg.norm(placed[:, None] - lowered[None], axis=2).min(axis=1)
    moves[~sleeve & (apart < SEWN_POINT_TOLERANCE), 1] = -0.5
    return moves
