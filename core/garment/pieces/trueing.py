"""True a pattern before it is cut: lines that cross a seam become smooth there, and seams keep their lengths."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from math import comb

import numpy as np

from ...geometry.geometry import unit
from ...run.units import MM_PER_M
from ..curves import edge_length, edge_points, place_on_chord, relative_to_chord, unit_length
from ..fairness import (
    EDGE_BLEND_LENGTH,
    SmoothJoin,
    boundary_edges,
    can_bend,
    cubic_handles,
    find_smooth_joins,
    measure_corner,
    unit_tangent,
)
from ..outline import is_slit_side
from ..pattern import Edge, EdgeRef, Pattern
from ..seams import find_sewn_partners, seam_lengths, seam_ratios
from .piece import TruedLine
from .seam_names import name_seam
from .trued_joins import find_crossed_joins

BLENDING_TOLERANCE = 0.0065
"""Largest move of a line by trueing where nothing is known of its accuracy [m]: a quarter of an inch. What is blended
on paper is less; a larger difference is a fault of the draft (H. Joseph-Armstrong, Patternmaking for Fashion Design,
trueing)."""

KNOWN_POINT_DEVIATIONS = 1.96
"""Number of standard deviations on either side within which a recovered control point is [1]: 95 % of a normal
distribution."""

MIN_TRUED_CORNER_ANGLE = np.radians(0.5)
"""Smallest corner that is trued [rad]: 0.5 mm over `EDGE_BLEND_LENGTH`, a pencil line."""

TRUED_ANGLE_TOLERANCE = np.radians(0.05)
"""Largest corner that is left after trueing [rad]: far below what can be cut."""

TRUED_LENGTH_TOLERANCE = 1e-8
"""Largest change of the difference between a seam's sides by trueing [m]."""

MIN_BENT_HANDLE_LENGTH = 0.01
"""Smallest length of a handle that is turned [m]; a shorter one makes a hook of a centimetre or two, no blend."""

MIN_CONSTRAINT_SHARE = 1e-10
"""Share of the largest eigenvalue below which corners and lengths are combinations of others, as on both sides of the
wearer."""

MAX_STEP_HALVING_COUNT = 6
"""Largest number of lengths of a step that are tried, each half of the one before."""

MAX_TRUEING_STEP_COUNT = 30
"""Largest number of Gauss-Newton steps; corners of 40 degrees take 6 to 10."""

LENGTH_GAUSS_NODES, LENGTH_GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(32)
"""Nodes and weights [1] of the quadrature of a curve's length."""

STRAIGHT_TRUED_TOLERANCE = 1e-6
"""Distance of the handles from the chord [chords] below which a line has stayed straight."""

EQUAL_EXCESS_SHARE = 0.98
"""Share of the largest excess above which another one is as large [1]: that of its mirror image, up to a file's
rounding."""

SLIDING_WEIGHT = 0.5
"""Weight of a curve's move along itself relative to one across it: such a move only shifts points on one line, but at
weights below 0.3 handles became so short that a hem of 25 degrees bent within 1 cm, not within `EDGE_BLEND_LENGTH`."""

COMPARED_PART_COUNT = 128
"""Number of parts of an edge at whose ends its move is measured."""


@dataclass(frozen=True)
class Trueing:
    """Describe a trued pattern, and each line that was not smooth."""

    pattern: Pattern
    lines: tuple[TruedLine, ...] = ()


def true_pattern(pattern: Pattern, point_std: np.ndarray | None = None) -> Trueing:
    """Return a pattern whose lines are smooth where they cross a seam (`find_crossed_joins`).

    Of all patterns with these joins smooth, and the sides of each seam as equal as before, it is the one whose outlines
    have moved least (mean square along them). Curves and lines that end at such a join become cubics; other edges
    follow their control points, and stay smooth where they are. Where a line would have to move by more than its place
    is uncertain, the corner stays: of several, the largest first.

    Args:
        pattern: The pattern.
        point_std: Standard deviation of each control point [m], shape [point_count, 2]; None where it is unknown, and
            the line may move by `BLENDING_TOLERANCE`.
    """
    corners = {join: measure_corner(pattern, join) for join in find_crossed_joins(pattern)}
    open_joins = {join: corner for join, corner in corners.items() if abs(corner) >= MIN_TRUED_CORNER_ANGLE}
    allowed = {join: _find_tolerance(pattern, join, point_std) for join in open_joins}
    refused: dict[SmoothJoin, float] = {}
    trued, moves = pattern, dict[SmoothJoin, float]()
    while chosen := [join for join in open_joins if join not in refused]:
        form = _Form.of(pattern, chosen, [join for join in corners if join not in open_joins])
        trued = form.solve()
        moves = {join: _measure_move(pattern, trued, join) for join in chosen}
        left = {join for join in chosen if abs(measure_corner(trued, join)) > TRUED_ANGLE_TOLERANCE}
        excess = {join: moves[join] / allowed[join] for join in chosen if moves[join] > allowed[join]}
        excess = {join: abs(open_joins[join]) for join in chosen} if left else excess
        if not excess:
            break
        most = EQUAL_EXCESS_SHARE * max(excess.values())
        refused |= {join: np.inf if left else moves[join] for join, value in excess.items() if value > most}
        trued, moves = pattern, {}
    lines = tuple(
        TruedLine(
            _name_line(pattern, join),
            _name_seam(pattern, join),
            corner,
            refused.get(join, moves.get(join, 0.0)),
            allowed[join],
            join not in refused,
        )
        for join, corner in open_joins.items()
    )
    return Trueing(trued, lines)


def describe_trueing(lines: tuple[TruedLine, ...]) -> tuple[str, ...]:
    """Return a sentence for each line and seam, those of both sides of the wearer as one; lines that are not smooth
    come first."""
    found: dict[tuple[bool, str, str], TruedLine] = {}
    for line in lines:
        key = (line.is_trued, line.line, line.seam)
        if key not in found or line.move > found[key].move:
            found[key] = line
    return tuple(_describe(found[key]) for key in sorted(found))


def _describe(line: TruedLine) -> str:
    where, corner = f"{line.line} at {line.seam}", f"{np.degrees(abs(line.corner)):.0f} degrees"
    if line.is_trued:
        return f"{where}: corner of {corner} trued, moved {MM_PER_M * line.move:.1f} mm"
    if np.isfinite(line.move):
        moved = f"it would move {MM_PER_M * line.move:.1f} mm, of {MM_PER_M * line.tolerance:.1f}"
        return f"{where}: corner of {corner} is left; trued, {moved}"
    return f"{where}: corner of {corner} is left; no smooth line near it keeps its seam's length"


@dataclass(frozen=True)
class _Direction:
    """Describe the direction of an edge's end: from one node to another, turned by a constant angle [rad]."""

    start: int
    end: int
    offset: float = 0.0


@dataclass(frozen=True)
class _Corner:
    """Describe a corner that is kept at an angle [rad]: the sum of signed directions."""

    terms: tuple[tuple[float, _Direction], ...]
    angle: float


@dataclass(frozen=True)
class _Form:
    """Describe the shapes that a pattern can take, by its nodes: control points, then handles of the bent curves [m].

    Attributes:
        handles: The first handle's index of each bent edge; the other one follows.
        corners: The corners that are made or kept.
        seams: Both edges of each seam, the planned ratio of their lengths, and by how much they differ [m]; of an edge
            that keeps its length, itself, 0 and its length.
        root: The Cholesky factor of the weights of moves, shape [2 node_count, 2 node_count]: their square is the
            integral of the outlines' squared moves along all edges.
    """

    pattern: Pattern
    nodes: np.ndarray
    handles: Mapping[EdgeRef, int]
    corners: tuple[_Corner, ...]
    seams: tuple[tuple[EdgeRef, EdgeRef, float, float], ...]
    root: np.ndarray

    @classmethod
    def of(cls, pattern: Pattern, joins: Collection[SmoothJoin], smooth: Collection[SmoothJoin]) -> _Form:
        """Return the shapes in which the lines at some joins can bend, and others stay smooth."""
        bent = dict.fromkeys(
            ref for join in joins for ref in boundary_edges(pattern, join) if _can_be_bent(pattern, ref)
        )
        handles, nodes = {}, [pattern.points]
        for ref in bent:
            handles[ref] = sum(map(len, nodes))
            start, end = (pattern.points[k] for k in pattern.ends_of(ref))
            edge = pattern.panel(ref.panel).edges[ref.edge]
            nodes.append(place_on_chord(cubic_handles(edge, float(np.linalg.norm(end - start))), start, end))
        form = cls(pattern, np.concatenate(nodes), handles, (), (), np.zeros((0, 0)))
        kept = {*smooth, *find_smooth_joins(pattern)} - set(joins)
        corners = [form._corner(join, 0.0) for join in joins]
        corners += [form._corner(join, measure_corner(pattern, join)) for join in kept]
        seams = zip(pattern.seams, seam_lengths(pattern), seam_ratios(pattern), strict=True)
        sides = tuple((seam.a, seam.b, ratio, one - ratio * other) for seam, (one, other), ratio in seams)
        return replace(form, corners=tuple(corners), seams=sides + _list_slit_sides(pattern), root=form._weigh())

    def _weigh(self) -> np.ndarray:
        """Return the Cholesky factor of the weights, of interleaved coordinates."""
        count = len(self.nodes)
        weights = np.zeros((2 * count, 2 * count))
        for panel in self.pattern.panels:
            for i in range(len(panel.edges)):
                nodes = self._edge_nodes(EdgeRef(panel.name, i))
                value, rate = _bernstein(len(nodes)), _bernstein_rates(len(nodes))
                along = unit(rate @ self.nodes[nodes])
                across = np.stack([-along[:, 1], along[:, 0]], axis=1)
                size = np.sqrt(LENGTH_GAUSS_WEIGHTS / 2.0 * edge_length(panel, i))
                for way, weight in ((across, 1.0), (along, SLIDING_WEIGHT)):
                    rows = weight * (size[:, None] * value)[:, :, None] * way[:, None, :]
                    rows = rows.reshape(len(rows), -1)
                    columns = (2 * np.array(nodes)[:, None] + np.arange(2)).ravel()
                    weights[np.ix_(columns, columns)] += rows.T @ rows
        return np.linalg.cholesky(weights).T

    def _edge_nodes(self, ref: EdgeRef) -> list[int]:
        """Return the nodes of an edge: its two control points, with two handles between where it is bent."""
        start, end = self.pattern.ends_of(ref)
        first = self.handles.get(ref)
        return [start, end] if first is None else [start, first, first + 1, end]

    def solve(self) -> Pattern:
        """Return the nearest pattern that has the corners and lengths; the pattern as it is where none is found."""
        moved, (rest, slope) = self.nodes, self._constrain(self.nodes)
        for _ in range(MAX_TRUEING_STEP_COUNT):
            if np.abs(rest).max() < TRUED_LENGTH_TOLERANCE:
                return self._draw(moved)
            back = (self.nodes - moved).ravel()
            weighted = np.linalg.solve(self.root.T, slope.T).T
            share = np.linalg.lstsq(weighted @ weighted.T, -rest - slope @ back, rcond=MIN_CONSTRAINT_SHARE)[0]
            step = (back + np.linalg.solve(self.root, weighted.T @ share)).reshape(-1, 2)
            for _ in range(MAX_STEP_HALVING_COUNT):
                new_rest, new_slope = self._constrain(moved + step)
                if (new_rest**2).sum() < (rest**2).sum():
                    break
                step = step / 2.0
            else:
                break
            moved, rest, slope = moved + step, new_rest, new_slope
        return self.pattern

    def _constrain(self, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what is wrong with corners and lengths [m], and its derivative by the nodes."""
        rest, rows = [], []
        for corner in self.corners:
            value, row = -corner.angle, np.zeros(nodes.shape)
            for sign, each in corner.terms:
                way = nodes[each.end] - nodes[each.start]
                value += sign * (np.arctan2(way[1], way[0]) + each.offset)
                turn = sign * np.array([-way[1], way[0]]) / max(float(way @ way), 1e-12)
                row[each.end] += turn
                row[each.start] -= turn
            rest.append(EDGE_BLEND_LENGTH * ((value + np.pi) % (2.0 * np.pi) - np.pi))
            rows.append(EDGE_BLEND_LENGTH * row.ravel())
        for one, other, ratio, planned in self.seams:
            (length, row), (second, second_row) = self._measure(nodes, one), self._measure(nodes, other)
            rest.append(length - ratio * second - planned)
            rows.append((row - ratio * second_row).ravel())
        return np.array(rest), np.array(rows)

    def _corner(self, join: SmoothJoin, angle: float) -> _Corner:
        """Return the corner at a join, as `measure_corner` defines it."""
        terms, turned = [], 0.0 if len(join.corners) == 1 else -np.pi
        for name, index in join.corners:
            count = len(self.pattern.panel(name).points)
            terms.append((1.0, self._direction(EdgeRef(name, index), is_end=False)))
            terms.append((-1.0, self._direction(EdgeRef(name, (index - 1) % count), is_end=True)))
        return _Corner(tuple(terms), angle - turned)

    def _direction(self, ref: EdgeRef, is_end: bool) -> _Direction:
        start, end = self.pattern.ends_of(ref)
        if ref in self.handles:
            first = self.handles[ref]
            return _Direction(first + 1, end) if is_end else _Direction(start, first)
        x, y = unit_tangent(self.pattern.panel(ref.panel).edges[ref.edge], is_end)
        return _Direction(start, end, float(np.arctan2(y, x)))

    def _measure(self, nodes: np.ndarray, ref: EdgeRef) -> tuple[float, np.ndarray]:
        """Return the length of an edge [m], and its derivative by the nodes."""
        row = np.zeros(nodes.shape)
        start, end = self.pattern.ends_of(ref)
        if ref not in self.handles:
            way = nodes[end] - nodes[start]
            chord = float(np.linalg.norm(way))
            factor = unit_length(self.pattern.panel(ref.panel).edges[ref.edge])
            row[end], row[start] = factor * way / chord, -factor * way / chord
            return factor * chord, row
        nodes_of_edge = self._edge_nodes(ref)
        rates = _bernstein_rates(4)
        speed = rates @ nodes[nodes_of_edge]
        size = np.linalg.norm(speed, axis=1)
        weights = LENGTH_GAUSS_WEIGHTS / 2.0
        row[nodes_of_edge] = (rates * weights[:, None]).T @ (speed / size[:, None])
        return float(weights @ size), row

    def _draw(self, nodes: np.ndarray) -> Pattern:
        """Return the pattern of moved nodes."""
        moved = self.pattern.with_points(nodes[: len(self.pattern.points)])
        panels = []
        for panel in moved.panels:
            edges = list(panel.edges)
            for i, edge in enumerate(edges):
                first = self.handles.get(EdgeRef(panel.name, i))
                if first is not None:
                    ends = panel.points[i], panel.points[(i + 1) % len(edges)]
                    edges[i] = _as_drawn(edge, relative_to_chord(nodes[first : first + 2], *ends))
            panels.append(replace(panel, edges=tuple(edges)))
        return replace(moved, panels=tuple(panels))


def _bernstein(count: int) -> np.ndarray:
    """Return the Bernstein polynomials of 2 or 4 points at the nodes of quadrature, shape [32, count]."""
    t, order = (LENGTH_GAUSS_NODES[:, None] + 1.0) / 2.0, count - 1
    return np.concatenate([comb(order, k) * t**k * (1.0 - t) ** (order - k) for k in range(count)], axis=1)


def _bernstein_rates(count: int) -> np.ndarray:
    """Return the derivatives of `_bernstein` by the parameter, shape [32, count]."""
    steps = (count - 1) * _bernstein(count - 1)
    return np.asarray(np.pad(steps, ((0, 0), (1, 0))) - np.pad(steps, ((0, 0), (0, 1))))


def _as_drawn(edge: Edge, handles: np.ndarray) -> Edge:
    """Return an edge with the handles of a cubic; a line that did not bend stays one."""
    if edge.kind == "line" and np.abs(handles[:, 1]).max() < STRAIGHT_TRUED_TOLERANCE:
        return edge
    return replace(edge, kind="cubic", handles=handles)


def _list_slit_sides(pattern: Pattern) -> tuple[tuple[EdgeRef, EdgeRef, float, float], ...]:
    """Return the sides of vents and slits, which lie on each other and keep their lengths, as seams of a `_Form`."""
    refs = [
        EdgeRef(panel.name, i) for panel in pattern.panels for i, edge in enumerate(panel.edges) if is_slit_side(edge)
    ]
    return tuple((ref, ref, 0.0, edge_length(pattern.panel(ref.panel), ref.edge)) for ref in refs)


def _can_be_bent(pattern: Pattern, ref: EdgeRef) -> bool:
    """Check whether an edge can be drawn as a cubic whose handles give its ends a direction."""
    start, end = (pattern.points[k] for k in pattern.ends_of(ref))
    chord = float(np.linalg.norm(end - start))
    handles = cubic_handles(pattern.panel(ref.panel).edges[ref.edge], chord)
    reach = chord * float(np.linalg.norm(handles - [[0.0, 0.0], [1.0, 0.0]], axis=1).min())
    return can_bend(pattern, ref, ()) and reach > MIN_BENT_HANDLE_LENGTH


def _find_tolerance(pattern: Pattern, join: SmoothJoin, point_std: np.ndarray | None) -> float:
    """Return how far a line may move at a join [m]: within the interval of the least known of its control points."""
    if point_std is None:
        return BLENDING_TOLERANCE
    nodes = [pattern.first_points[name] + index for name, index in join.corners]
    return float(KNOWN_POINT_DEVIATIONS * point_std[nodes].max())


def _measure_move(before: Pattern, after: Pattern, join: SmoothJoin) -> float:
    """Return the largest distance that the nearer halves of both edges at a join moved [m]."""
    half, moves = COMPARED_PART_COUNT // 2, []
    for ref in boundary_edges(before, join):
        near = slice(0, half + 1) if (ref.panel, ref.edge) in join.corners else slice(half, None)
        old, new = (edge_points(one.panel(ref.panel), ref.edge, COMPARED_PART_COUNT)[near] for one in (before, after))
        moves.append(float(np.linalg.norm(new - old, axis=1).max()))
    return max(moves)


def _name_line(pattern: Pattern, join: SmoothJoin) -> str:
    """Return the name of the line that passes a join: its contour or seam; of an unnamed seam, what it is sewn to."""
    first, _ = boundary_edges(pattern, join)
    contour = pattern.panel(first.panel).edges[first.edge].contour.split(".")[0]
    other = find_sewn_partners(pattern).get(first)
    return contour or _name_seam_of(pattern, first) or ("open edge" if other is None else f"seam to {other.panel}")


def _name_seam(pattern: Pattern, join: SmoothJoin) -> str:
    """Return the name of the seam that ends at a join; of a panel's own corner, that of the panel."""
    names = " to ".join(dict.fromkeys(name for name, _ in join.corners))
    return (_name_seam_of(pattern, join.seam[0]) if join.seam else "") or names


def _name_seam_of(pattern: Pattern, ref: EdgeRef) -> str:
    """Return the name of the seam of an edge, or an empty text."""
    return next((name_seam(pattern, seam).name for seam in pattern.seams if ref in (seam.a, seam.b)), "")
