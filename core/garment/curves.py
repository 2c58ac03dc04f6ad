"""Points, lengths and parts of one edge. An edge is drawn in the frame of its chord: start (0, 0), end (1, 0), across
to the left. The panel's edge is c0 + along * x + across * R90 x with x = c1 - c0 (thesis eq. 3.1), so it follows its
two control points by a similarity."""

from __future__ import annotations

import numpy as np

from .memo import memoise
from .pattern import Edge, Panel, Pattern
from .polygon import polygon_area

LENGTH_TABLE_SPAN_COUNT = 64
"""Number of parameter spans of the length table; 5-point Gauss on each gives lengths to 1e-12 chords."""

FLAT_ARC_TOLERANCE = 1e-9
"""Distance of an arc's apex from its chord [chords] below which the arc is a line: 1 nm on a 1 m edge."""

AREA_SEGMENTS = 64
"""Number of segments of a curve whose area is summed; the error is 0.03 %."""

_GAUSS_NODES, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(5)
"""Nodes and weights [1] of 5-point Gauss-Legendre quadrature on [-1, 1]."""


def edge_points(panel: Panel, edge: int, segments: int) -> np.ndarray:
    """Return segments + 1 points [m] along an edge, uniform in arc length, ends included, shape [segments + 1, 2]."""
    return place_on_chord(unit_points(panel.edges[edge], segments), *chord(panel, edge))


def edge_length(panel: Panel, edge: int) -> float:
    """Return the length of an edge [m]."""
    start, end = chord(panel, edge)
    return float(np.linalg.norm(end - start)) * unit_length(panel.edges[edge])


def chord(panel: Panel, edge: int) -> tuple[np.ndarray, np.ndarray]:
    """Return both control points of an edge [m], shape [2] each."""
    return panel.points[edge], panel.points[(edge + 1) % len(panel.points)]


def place_on_chord(unit: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Map relative (along, across) coordinates, shape [n, 2], onto a chord [m], shape [n, 2] (thesis eq. 3.1)."""
    along = end - start
    left = np.array([-along[1], along[0]])
    found: np.ndarray = start + unit[:, :1] * along + unit[:, 1:] * left
    return found


def relative_to_chord(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Invert `place_on_chord`: relative (along, across) coordinates, shape [n, 2]."""
    along = end - start
    left = np.array([-along[1], along[0]])
    offset = points - start
    found: np.ndarray = np.stack([offset @ along, offset @ left], axis=-1) / (along @ along)
    return found


def unit_points(edge: Edge, segments: int) -> np.ndarray:
    """Return segments + 1 relative points of an edge, uniform in arc length, shape [segments + 1, 2]."""
    fraction = np.arange(segments + 1) / segments
    if edge.kind == "line" or is_flat_arc(edge):
        return np.stack([fraction, np.zeros_like(fraction)], axis=-1)
    if edge.kind == "arc":
        centre, radius, first, sweep = unit_circle(edge)
        angle = first + sweep * fraction
        points = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    else:
        points = _bezier(_control(edge), _parameters(edge, fraction))
    points[0], points[-1] = (0.0, 0.0), (1.0, 0.0)
    return points


def unit_length(edge: Edge) -> float:
    """Return the length of an edge in units of its chord."""
    if edge.kind == "line" or is_flat_arc(edge):
        return 1.0
    if edge.kind == "arc":
        _, radius, _, sweep = unit_circle(edge)
        return abs(radius * sweep)
    return float(_length_table(edge)[-1])


def edge_area(edge: Edge) -> float:
    """Return the area between an edge and its chord, in squared chords; positive to the right, outside a panel."""
    x, y = unit_points(edge, AREA_SEGMENTS).T
    return float(-np.sum((x[1:] - x[:-1]) * (y[1:] + y[:-1])) / 2.0)


def is_flat_arc(edge: Edge) -> bool:
    """Return whether an arc counts as a line."""
    return edge.kind == "arc" and abs(edge.handles[0, 1]) < FLAT_ARC_TOLERANCE


def unit_circle(edge: Edge) -> tuple[np.ndarray, float, float, float]:
    """Return centre, radius, first angle and sweep [rad] of an arc in its chord's frame. With apex height b (signed,
    left positive): radius (1/4 + b^2) / (2 |b|), centre (1/2, b - sign(b) radius)."""
    height = float(edge.handles[0, 1])
    radius = (0.25 + height * height) / (2.0 * abs(height))
    centre = np.array([0.5, height - np.sign(height) * radius])
    half = 2.0 * np.arctan2(abs(height), 0.5)
    top = np.sign(height) * np.pi / 2
    return centre, radius, float(top + np.sign(height) * half), float(-2.0 * np.sign(height) * half)


def split_edge(edge: Edge, fraction: float) -> tuple[np.ndarray, Edge, Edge]:
    """Cut an edge at a fraction of its length.

    Returns:
        The cut's relative position, shape [2], and the two parts, which draw the same curve.
    """
    if edge.kind == "line" or is_flat_arc(edge):
        straight = Edge("line", label=edge.label, contour=edge.contour)
        return np.array([fraction, 0.0]), straight, straight
    if edge.kind == "arc":
        centre, radius, first, sweep = unit_circle(edge)
        angle = first + sweep * fraction
        middle = centre + radius * np.array([np.cos(angle), np.sin(angle)])
        handles = [-0.5 * np.tan(sweep * part / 4.0) for part in (fraction, 1.0 - fraction)]
        first_part, second_part = (
            Edge("arc", np.array([[0.5, across]]), edge.label, edge.contour) for across in handles
        )
        return middle, first_part, second_part
    parameter = _parameters(edge, np.array([fraction]))[0]
    left, right = _cut_bezier(_control(edge), parameter)
    cut = left[-1]
    end = np.array([1.0, 0.0])
    return (
        cut,
        Edge(edge.kind, relative_to_chord(left[1:-1], left[0], cut), edge.label, edge.contour),
        Edge(edge.kind, relative_to_chord(right[1:-1], cut, end), edge.label, edge.contour),
    )


def reverse_edge(edge: Edge) -> Edge:
    """Return the same curve from its end to its start."""
    handles = edge.handles[::-1].copy()
    handles[:, 0] = 1.0 - handles[:, 0]
    handles[:, 1] = -handles[:, 1]
    return Edge(edge.kind, handles, edge.label, edge.contour)


def mirror_edge(edge: Edge) -> Edge:
    """Return the mirror image of a curve, from its start to its end."""
    return Edge(edge.kind, edge.handles * np.array([1.0, -1.0]), edge.label, edge.contour)


def panel_outline(panel: Panel, segments: int = 16) -> np.ndarray:
    """Return the panel's outline [m] as a polygon, `segments` per curved edge and one per line, shape [n, 2]."""
    parts = []
    for index, edge in enumerate(panel.edges):
        count = 1 if edge.kind == "line" else segments
        parts.append(edge_points(panel, index, count)[:-1])
    return np.concatenate(parts)


@memoise
def panel_area(panel: Panel) -> float:
    """Return the area of a panel [m2], curves sampled finely; positive where it runs counter-clockwise."""
    return polygon_area(panel_outline(panel, 64))


def _control(edge: Edge) -> np.ndarray:
    return np.concatenate([[[0.0, 0.0]], edge.handles, [[1.0, 0.0]]])


def _bezier(control: np.ndarray, parameter: np.ndarray) -> np.ndarray:
    """Evaluate a Bezier curve by de Casteljau, shape [n, 2]."""
    points, weight = control[:, None], parameter[:, None]
    while len(points) > 1:
        points = points[:-1] + weight * (points[1:] - points[:-1])
    return np.array(np.broadcast_to(points[0], (len(parameter), 2)))


def _cut_bezier(control: np.ndarray, parameter: float) -> tuple[np.ndarray, np.ndarray]:
    """Cut a Bezier curve in two by de Casteljau."""
    left, right, points = [control[0]], [control[-1]], control
    while len(points) > 1:
        points = points[:-1] + parameter * (points[1:] - points[:-1])
        left.append(points[0])
        right.append(points[-1])
    return np.array(left), np.array(right[::-1])


def _speed_integral(control: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Integrate the speed from low to high by 5-point Gauss, shape [n]."""
    order = len(control) - 1
    hodograph = order * np.diff(control, axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    parameter = (middle[:, None] + half[:, None] * _GAUSS_NODES).ravel()
    speed = np.linalg.norm(_bezier(hodograph, parameter), axis=-1).reshape(-1, len(_GAUSS_NODES))
    found: np.ndarray = half * (speed @ _GAUSS_WEIGHTS)
    return found


@memoise
def _length_table(edge: Edge) -> np.ndarray:
    """Return the length of a Bezier edge up to each of LENGTH_TABLE_SPAN_COUNT + 1 uniform parameters, in chords."""
    grid = np.linspace(0.0, 1.0, LENGTH_TABLE_SPAN_COUNT + 1)
    return np.concatenate([[0.0], np.cumsum(_speed_integral(_control(edge), grid[:-1], grid[1:]))])


def _parameters(edge: Edge, fraction: np.ndarray) -> np.ndarray:
    """Return the Bezier parameters at fractions of the arc length, by table and three Newton steps."""
    control = _control(edge)
    table = _length_table(edge)
    grid = np.linspace(0.0, 1.0, LENGTH_TABLE_SPAN_COUNT + 1)
    goal = fraction * table[-1]
    parameter: np.ndarray = np.interp(goal, table, grid)
    hodograph = (len(control) - 1) * np.diff(control, axis=0)
    for _ in range(3):
        cell = np.clip((parameter * LENGTH_TABLE_SPAN_COUNT).astype(int), 0, LENGTH_TABLE_SPAN_COUNT - 1)
        reached = table[cell] + _speed_integral(control, grid[cell], parameter)
        speed = np.linalg.norm(_bezier(hodograph, parameter), axis=-1)
        step = np.where(speed > 1e-9, (goal - reached) / np.maximum(speed, 1e-9), 0.0)
        parameter = np.clip(
            parameter + np.clip(step, -1.0 / LENGTH_TABLE_SPAN_COUNT, 1.0 / LENGTH_TABLE_SPAN_COUNT), 0.0, 1.0
        )
    return parameter


def flat_contours(pattern: Pattern) -> dict[str, float]:
    """Measure the flat length of every named open contour [m]."""
    lengths: dict[str, float] = {}
    for panel in pattern.panels:
        for i, edge in enumerate(panel.edges):
            if edge.contour:
                lengths[edge.contour] = lengths.get(edge.contour, 0.0) + edge_length(panel, i)
    return lengths
