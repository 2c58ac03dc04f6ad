"""Fair curves: keep a boundary smooth where the cut is smooth, within a panel and across a seam that ends there."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..geometry.rigid import plane_rotation
from .curves import edge_area, edge_length, is_flat_arc, unit_circle
from .memo import memoise
from .pattern import Edge, EdgeRef, Panel, Pattern
from .seams import equalise_seams

MAX_SMOOTH_CORNER_ANGLE = np.radians(5.0)
"""Turn of a boundary below which it is smooth [rad]: it is not visible in cut cloth."""

MAX_BENT_ARC_ANGLE = 2.0 * np.pi / 3.0
"""Arcs of a larger sweep [rad] stay arcs: a cubic curve would differ from them by more than 0.3 % of their radius."""

EDGE_BLEND_LENGTH = 0.06
"""Length over which a straight edge begins to bend [m]: a hem is squared and a hip blended over 5 to 8 cm; the rest of
the edge stays a line."""

MIN_DIRECTED_EDGE_LENGTH = 0.005
"""Smallest length of an edge with a significant direction [m]: the steps of 2 mm that programs draw at a corner turn by
40 degrees where a point moves by 1 mm."""

Corner = tuple[str, int]
"""Panel's name, and index of a control point in it."""


@dataclass(frozen=True)
class FairingSettings:
    """Describe how corners are made smooth.

    Attributes:
        angle: Smallest corner that is corrected [rad], so that a straight edge does not become a curve for less.
        iterations: Largest number of iterations, each of which turns the curves, moves the control points and equalises
            the seams. The corner that remains halves each time, so that corners of 30 degrees fall below 0.5.
        proved_angle: Difference from its angle at which a proved corner stays as it was fitted [rad]: scans have it to
            within 0.5 to 2 degrees, and a straight hem does not become a curve for that.
        rcond: Cut-off of the singular values [share of the largest] in the move of a control point. Two edges that meet
            at less than 33 degrees count as parallel: the point moves across both by their mean, not far along them.
    """

    angle: float = float(np.radians(0.5))
    iterations: int = 8
    proved_angle: float = float(np.radians(2.0))
    rcond: float = 0.3


@dataclass(frozen=True)
class SmoothJoin:
    """Describe a place where a boundary continues without a corner: one corner, between two edges of a panel; or two
    corners on both sides of a seam that ends there, with the sewn edge of each."""

    corners: tuple[Corner, ...]
    seam: tuple[EdgeRef, ...] = ()


NO_PROVED_CORNERS: Mapping[SmoothJoin, float] = {}
"""No proved corners: there is no scan."""


@memoise
def find_smooth_joins(pattern: Pattern) -> tuple[SmoothJoin, ...]:
    """Find all joins where the corner of a pattern's boundary is below `MAX_SMOOTH_CORNER_ANGLE`. An edge below
    `MIN_DIRECTED_EDGE_LENGTH` is part of a corner, so its ends are no smooth joins."""
    single = [SmoothJoin(((panel.name, i),)) for panel in pattern.panels for i in range(len(panel.points))]
    joins = [*single, *_across_seams(pattern)]
    return tuple(
        join
        for join in joins
        if abs(measure_corner(pattern, join)) < MAX_SMOOTH_CORNER_ANGLE
        and all(
            edge_length(pattern.panel(ref.panel), ref.edge) >= MIN_DIRECTED_EDGE_LENGTH
            for ref in boundary_edges(pattern, join)
        )
    )


def measure_corner(pattern: Pattern, join: SmoothJoin) -> float:
    """Compute the corner of a boundary at a join [rad]: 0 where it is smooth, positive where it is convex. Let t be the
    angle by which a counter-clockwise outline turns left at a corner. Within a panel the corner is t. Where a seam
    ends, the boundary continues in the other panel; its interior angles pi - t add up, so that the corner is t_a + t_b
    - pi. Full turns are subtracted."""
    turns = [_turn(pattern.panel(name), index) for name, index in join.corners]
    corner = turns[0] if len(turns) == 1 else sum(turns) - np.pi
    return float((corner + np.pi) % (2.0 * np.pi) - np.pi)


def unplanned_corners(
    pattern: Pattern, base: Pattern, proved: Mapping[SmoothJoin, float] = NO_PROVED_CORNERS
) -> np.ndarray:
    """Compute the corners of a pattern [rad] wherever its base pattern is smooth, shape [join_count]. A proved corner
    is planned: there the value is the difference from the proved angle [rad]."""
    return np.array([measure_corner(pattern, join) - proved.get(join, 0.0) for join in find_smooth_joins(base)])


def interior_angles(panel: Panel) -> np.ndarray:
    """Return the interior angle at each control point of a panel [rad]: pi where its outline is smooth. It is NaN
    beside an edge below `MIN_DIRECTED_EDGE_LENGTH`."""
    short = np.array([edge_length(panel, i) < MIN_DIRECTED_EDGE_LENGTH for i in range(len(panel.points))])
    turns = np.array([_turn(panel, i) for i in range(len(panel.points))])
    return np.where(short | np.roll(short, 1), np.nan, np.pi - turns)


def fair_curves(
    pattern: Pattern,
    base: Pattern,
    fixed: Collection[Corner] = (),
    proved: Mapping[SmoothJoin, float] = NO_PROVED_CORNERS,
    settings: FairingSettings = FairingSettings(),
) -> Pattern:
    """Turn the ends of a pattern's curves until each corner that is smooth in its base pattern has that pattern's
    angle.

    Each of the two edges of a boundary turns its tangent by half of the corner's excess, and moves across itself until
    it encloses the same area: the smooth line passes through the corner, not around it. A straight edge becomes a cubic
    where it has to bend. Large arcs stay: their neighbour turns by the whole corner; between two large arcs the corner
    stays.

    Args:
        pattern: The graded or fitted pattern.
        base: The pattern that it was graded from, with the same panels and edges.
        fixed: Control points that stay fixed; an edge between two of them does not change.
        proved: Corners that the scan proves, kept in place of the base pattern's, by the boundary's turn there [rad].
        settings: How corners are made smooth.
    """
    for _ in range(settings.iterations):
        turns: dict[EdgeRef, np.ndarray] = {}
        for join in find_smooth_joins(base):
            corner = measure_corner(pattern, join)
            corner = _corner_excess(corner, measure_corner(base, join), proved.get(join), settings)
            if abs(corner) < settings.angle:
                continue
            ends = [end for end in _boundary_ends(pattern, join) if can_bend(pattern, end[0], fixed)]
            for edge, is_end in ends:
                # the boundary turns left by the corner: the arriving edge turns left, the departing one right
                share = corner / len(ends)
                turns.setdefault(edge, np.zeros(2))[int(is_end)] += share if is_end else -share
        if not turns:
            break
        bent = _keep_area(_turn_ends(pattern, turns), pattern, fixed, settings.rcond)
        pattern = equalise_seams(bent, fixed, base=base)
    return pattern


def boundary_edges(pattern: Pattern, join: SmoothJoin) -> tuple[EdgeRef, EdgeRef]:
    """Return the two edges of the boundary that meet at a join."""
    (first, _), (last, _) = _boundary_ends(pattern, join)
    return first, last


def _corner_excess(corner: float, plain: float, proved: float | None, settings: FairingSettings) -> float:
    """Return the angle by which a corner has to turn back [rad], given its base pattern's and its proved angle. A base
    pattern's corner near `MAX_SMOOTH_CORNER_ANGLE` is reduced until the rest is below that angle."""
    if proved is None:
        most = MAX_SMOOTH_CORNER_ANGLE - settings.angle
        return corner - float(np.clip(plain, -most, most))
    off = corner - proved
    return float(np.sign(off) * max(0.0, abs(off) - settings.proved_angle))


def _across_seams(pattern: Pattern) -> Iterator[SmoothJoin]:
    """Yield both ends of every seam, with the corners of the two panels that it joins there. Ends where two straight
    seams meet, as a shoulder's and a sleeve's do, are left out: a sleeve is set at an angle, and the seam on top of it
    stays straight, so that its halves can be cut as one."""
    sewn = {ref for seam in pattern.seams for ref in (seam.a, seam.b)}
    for seam in pattern.seams:
        if seam.gathered:
            continue
        sides = [(pattern.panel(ref.panel), ref.edge) for ref in (seam.a, seam.b)]
        ends = [((panel.name, edge), (panel.name, (edge + 1) % len(panel.points))) for panel, edge in sides]
        (a0, a1), (b0, b1) = ends
        pairs = ((a0, b1), (a1, b0)) if seam.reversed else ((a0, b0), (a1, b1))
        for corners in pairs:
            join = SmoothJoin(corners, (seam.a, seam.b))
            edges = [edge for edge, _ in _boundary_ends(pattern, join)]
            is_straight = all(
                edge in sewn and pattern.panel(edge.panel).edges[edge.edge].kind == "line" for edge in edges
            )
            if corners[0] != corners[1] and not is_straight:
                yield join


def _boundary_ends(pattern: Pattern, join: SmoothJoin) -> Iterator[tuple[EdgeRef, bool]]:
    """Yield the edges of the boundary that meet at a join, each with whether it ends there."""
    for k, (name, index) in enumerate(join.corners):
        count = len(pattern.panel(name).points)
        arriving, departing = EdgeRef(name, (index - 1) % count), EdgeRef(name, index)
        for edge, is_end in ((arriving, True), (departing, False)):
            if not join.seam or edge != join.seam[k]:
                yield edge, is_end


def _turn(panel: Panel, index: int) -> float:
    """Return the angle by which a panel's outline turns left at a control point [rad], in -pi..pi."""
    arriving, departing = _tangent(panel, (index - 1) % len(panel.points), True), _tangent(panel, index, False)
    cross = arriving[0] * departing[1] - arriving[1] * departing[0]
    return float(np.arctan2(cross, arriving @ departing))


def _tangent(panel: Panel, edge: int, is_end: bool) -> np.ndarray:
    """Return the unit direction of an edge at its start or end, shape [2]."""
    along = panel.points[(edge + 1) % len(panel.points)] - panel.points[edge]
    x, y = unit_tangent(panel.edges[edge], is_end)
    found = x * along + y * np.array([-along[1], along[0]])
    return np.asarray(found / max(float(np.linalg.norm(found)), 1e-12))


def unit_tangent(edge: Edge, is_end: bool) -> np.ndarray:
    """Return the direction of an edge's start or end in the frame of its chord, shape [2]."""
    if edge.kind == "line" or is_flat_arc(edge):
        return np.array([1.0, 0.0])
    if edge.kind == "arc":
        _, _, first, sweep = unit_circle(edge)
        angle = first + (sweep if is_end else 0.0)
        return np.asarray(np.sign(sweep) * np.array([-np.sin(angle), np.cos(angle)]))
    control = np.concatenate([[[0.0, 0.0]], edge.handles, [[1.0, 0.0]]])
    steps = np.diff(control[::-1] if is_end else control, axis=0) * (-1.0 if is_end else 1.0)
    lengths = np.linalg.norm(steps, axis=1)
    return np.asarray(steps[int(np.argmax(lengths > 1e-9))])


def can_bend(pattern: Pattern, edge: EdgeRef, fixed: Collection[Corner]) -> bool:
    """Return whether an edge may change and is well approximated by a cubic curve."""
    panel = pattern.panel(edge.panel)
    if (edge.panel, edge.edge) in fixed and (edge.panel, (edge.edge + 1) % len(panel.points)) in fixed:
        return False
    curve = panel.edges[edge.edge]
    return curve.kind != "arc" or is_flat_arc(curve) or abs(unit_circle(curve)[3]) <= MAX_BENT_ARC_ANGLE


def _turn_ends(pattern: Pattern, turns: dict[EdgeRef, np.ndarray]) -> Pattern:
    """Return a pattern with the start and end tangents of edges turned left by given angles [rad]."""
    panels = []
    for panel in pattern.panels:
        edges = [
            _bend(edge, float(np.linalg.norm(panel.points[(i + 1) % len(panel.points)] - panel.points[i])), found)
            if (found := turns.get(EdgeRef(panel.name, i))) is not None
            else edge
            for i, edge in enumerate(panel.edges)
        ]
        panels.append(replace(panel, edges=tuple(edges)))
    return replace(pattern, panels=tuple(panels))


def _bend(edge: Edge, chord: float, turns: np.ndarray) -> Edge:
    """Return an edge of a chord [m] as a cubic curve whose ends are turned left by two angles [rad], shape [2]."""
    first, last = cubic_handles(edge, chord)
    end = np.array([1.0, 0.0])
    handles = np.stack([plane_rotation(turns[0]) @ first, end + plane_rotation(turns[1]) @ (last - end)])
    return replace(edge, kind="cubic", handles=handles)


def cubic_handles(edge: Edge, chord: float) -> np.ndarray:
    """Return the two handles of the cubic for an edge, shape [2, 2]; an arc is met within 0.3 % of its radius."""
    start, end = np.zeros(2), np.array([1.0, 0.0])
    if edge.kind == "cubic":
        return edge.handles
    if edge.kind == "quadratic":
        return np.stack([start + 2.0 / 3.0 * (edge.handles[0] - start), end + 2.0 / 3.0 * (edge.handles[0] - end)])
    if edge.kind == "line" or is_flat_arc(edge):
        reach = min(1.0 / 3.0, EDGE_BLEND_LENGTH / max(chord, 1e-9))
        return np.array([[reach, 0.0], [1.0 - reach, 0.0]])
    _, radius, _, sweep = unit_circle(edge)
    reach = 4.0 / 3.0 * np.tan(abs(sweep) / 4.0) * radius
    return np.stack([start + reach * unit_tangent(edge, False), end - reach * unit_tangent(edge, True)])


def _keep_area(bent: Pattern, before: Pattern, fixed: Collection[Corner], rcond: float) -> Pattern:
    """Return a pattern whose control points have moved until each bent edge encloses the same area as before. An edge
    whose curve has gained the area dA moves by -dA / chord across itself. A control point moves by the least-norm
    solution for both of its edges, by their mean where they are parallel."""
    points = {}
    for panel, old in zip(bent.panels, before.panels, strict=True):
        chord = np.roll(panel.points, -1, axis=0) - panel.points
        length = np.maximum(np.linalg.norm(chord, axis=1), 1e-9)
        gained = [edge_area(new) - edge_area(edge) for new, edge in zip(panel.edges, old.edges, strict=True)]
        outward = np.stack([chord[:, 1], -chord[:, 0]], axis=1) / length[:, None]
        move = -np.array(gained) * length
        moved = panel.points.copy()
        for i in range(len(moved)):
            if (panel.name, i) not in fixed:
                sides = [i - 1, i]
                moved[i] += np.linalg.lstsq(outward[sides], move[sides], rcond=rcond)[0]
        points[panel.name] = moved
    return bent.with_points(points)
