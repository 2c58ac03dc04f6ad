"""The handles of a pattern's curves as one vector, and derivatives of the pattern by them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from .control import spread_inside
from .curves import chord, edge_area, place_on_chord, unit_length, unit_points
from .fairness import SmoothJoin
from .garment import Garment
from .pattern import Edge, EdgeRef, Pattern
from .symmetry import find_symmetry

CURVE_KINDS = ("quadratic", "cubic")
"""Kinds of edges whose handles can move; an arc stays an arc."""

HANDLE_DIFFERENCE_STEP = 1e-5
"""Step of central differences [chords]: lengths and points are then accurate to 1e-9."""

Measure = Callable[[Edge], np.ndarray | float]


def list_curves(pattern: Pattern) -> Iterator[tuple[EdgeRef, Edge, slice]]:
    """Yield each curve with the slice of its handles in `handles_of`."""
    first = 0
    for panel in pattern.panels:
        for index, edge in enumerate(panel.edges):
            if edge.kind in CURVE_KINDS:
                yield EdgeRef(panel.name, index), edge, slice(first, first + len(edge.handles))
                first += len(edge.handles)


def handles_of(pattern: Pattern) -> np.ndarray:
    """Return the handles of all curves, panel after panel, in units of their chords, shape [handle_count, 2]."""
    return np.concatenate([np.zeros((0, 2)), *(edge.handles for _, edge, _ in list_curves(pattern))])


def with_handles(pattern: Pattern, handles: np.ndarray) -> Pattern:
    """Move the handles of all curves; control points stay.

    Args:
        pattern: The pattern.
        handles: As `handles_of` returns them, shape [handle_count, 2].
    """
    drawn = {ref: replace(edge, handles=handles[run]) for ref, edge, run in list_curves(pattern)}
    panels = tuple(
        replace(
            panel, edges=tuple(drawn.get(EdgeRef(panel.name, index), edge) for index, edge in enumerate(panel.edges))
        )
        for panel in pattern.panels
    )
    return replace(pattern, panels=panels)


def find_free_handles(pattern: Pattern, fixed: Collection[EdgeRef] = ()) -> np.ndarray:
    """Return an orthonormal basis of the motions that keep mirror images, shape [2 handle_count, free_count].

    Args:
        pattern: The pattern, with its symmetry.
        fixed: Curves that stay fixed.
    """
    places = {ref: own for ref, _, own in list_curves(pattern)}
    count = len(handles_of(pattern))
    ties = [
        row for ref, own in places.items() if ref in fixed for row in np.eye(2 * count)[2 * own.start : 2 * own.stop]
    ]
    for mirror in find_symmetry(pattern).mirrors:
        source, target = pattern.panels[mirror.source], pattern.panels[mirror.target]
        for index in range(len(mirror.order)):
            run = places.get(EdgeRef(target.name, index))
            image = places.get(EdgeRef(source.name, int(mirror.order[index] - 1) % len(mirror.order)))
            if run is None or image is None:
                continue
            for one, other in zip(range(run.start, run.stop), range(image.stop - 1, image.start - 1, -1), strict=True):
                # a mirrored curve is reversed: (along, across) becomes (1 - along, across)
                for axis, sign in ((0, 1.0), (1, -1.0)):
                    tie = np.zeros((count, 2))
                    tie[one, axis] += 1.0
                    tie[other, axis] += sign
                    ties.append(tie.ravel())
    if not ties:
        return np.eye(2 * count)
    _, values, right = np.linalg.svd(np.array(ties))
    return np.asarray(right[int((values > HANDLE_DIFFERENCE_STEP).sum()) :].T)


def differentiate(edge: Edge, measure: Measure) -> np.ndarray:
    """Return the derivative of a measure of an edge by its handles [1/chord], shape [..., 2 handle_count]."""
    rates = []
    for index in np.ndindex(edge.handles.shape):
        ends = []
        for step in (HANDLE_DIFFERENCE_STEP, -HANDLE_DIFFERENCE_STEP):
            handles = edge.handles.copy()
            handles[index] += step
            ends.append(np.asarray(measure(replace(edge, handles=handles))))
        rates.append((ends[0] - ends[1]) / (2.0 * HANDLE_DIFFERENCE_STEP))
    return np.stack(rates, axis=-1)


def length_rates(pattern: Pattern, by: Mapping[EdgeRef, float]) -> np.ndarray:
    """Return the derivative of a weighted sum of lengths by the handles [m], shape [2 handle_count].

    Args:
        pattern: The pattern.
        by: Weight of each edge.
    """
    return _edge_rates(pattern, by, unit_length, 1)


def area_rates(pattern: Pattern, by: Mapping[EdgeRef, float]) -> np.ndarray:
    """Return the derivative of a weighted sum of areas beside edges by the handles [m2], shape [2 handle_count].

    Args:
        pattern: The pattern.
        by: Weight of each edge.
    """
    return _edge_rates(pattern, by, edge_area, 2)


def _edge_rates(pattern: Pattern, by: Mapping[EdgeRef, float], measure: Measure, power: int) -> np.ndarray:
    """Return the derivative of a weighted sum of measures that grow with a power of each edge's chord."""
    rates = np.zeros((len(handles_of(pattern)), 2))
    for ref, edge, run in list_curves(pattern):
        if ref in by:
            start, end = chord(pattern.panel(ref.panel), ref.edge)
            found = by[ref] * float(np.linalg.norm(end - start)) ** power * differentiate(edge, measure)
            rates[run] = found.reshape(-1, 2)
    return rates.ravel()


def follow_handles(garment: Garment) -> np.ndarray:
    """Return the derivative of a flat mesh by the handles of its pattern [m], shape [uv_count, 2, 2 handle_count].
    Outline vertices stay uniform in arc length; inner ones move by mean value coordinates, as in `update_flat_mesh`."""
    pattern = garment.pattern
    moved = np.zeros((len(garment.uv), 2, 2 * len(handles_of(pattern))))
    for ref, edge, run in list_curves(pattern):
        along = garment.edge_uv[ref]
        start, end = chord(pattern.panel(ref.panel), ref.edge)
        rates = differentiate(edge, partial(unit_points, segments=len(along) - 1))
        placed = place_on_chord(np.moveaxis(rates, -1, 0).reshape(-1, 2), np.zeros(2), end - start)
        columns = slice(2 * run.start, 2 * run.stop)
        moved[along[:-1], :, columns] = np.moveaxis(placed.reshape(-1, len(along), 2), 0, -1)[:-1]
    for index in range(len(pattern.panels)):
        spread_inside(garment, index, moved)
    return moved


def corner_rates(pattern: Pattern, join: SmoothJoin) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivative of the corner at a join, as of `measure_corner`, by control points and by handles. With the
    chord c and the tangent t in its frame, an edge has the angle atan2(c) + atan2(t); a corner is the angle of the
    departing edge less that of the arriving one.

    Returns:
        By all control points [rad/m], shape [point_count, 2], and by all handles [rad chord], shape [handle_count, 2].
    """
    by_points, by_handles = np.zeros((len(pattern.points), 2)), np.zeros((len(handles_of(pattern)), 2))
    places = {ref: run for ref, _, run in list_curves(pattern)}
    for name, index in join.corners:
        panel = pattern.panel(name)
        for number, is_end, sign in (((index - 1) % len(panel.points), True, -1.0), (index, False, 1.0)):
            ref = EdgeRef(name, number)
            first, last = pattern.ends_of(ref)
            turned = sign * _angle_rate(np.subtract(*chord(panel, number)[::-1]))
            by_points[last] += turned
            by_points[first] -= turned
            if ref in places:
                handle = panel.edges[number].handles[-1 if is_end else 0]
                tangent = np.array([1.0, 0.0]) - handle if is_end else handle
                at = places[ref].stop - 1 if is_end else places[ref].start
                by_handles[at] += sign * (-1.0 if is_end else 1.0) * _angle_rate(tangent)
    return by_points, by_handles


def _angle_rate(vector: np.ndarray) -> np.ndarray:
    """Return the derivative of a vector's angle by its end, shape [2]."""
    return np.array([-vector[1], vector[0]]) / max(float(vector @ vector), 1e-12)
