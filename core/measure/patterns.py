"""Measure how well the recovered pattern matches the true one, panel by panel and seam by seam."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..pattern import EdgeRef, Panel, Pattern, edge_length, edge_points
from .outlines import edge_rms, outline_rms, polygon_area, polygon_width, polyline_length
from .turning import turning_distance

WIDE = 0.12
"""Panels narrower than this [m] are bands: a tight band's length cannot be told from its stretch (up to 20 %)."""

CURVE_SEGMENTS = 100
"""Segments that stand for a drawn curve: its chord error on a 50 cm curve is then below 0.01 mm."""

MM = 1e3

PATTERN_METRICS = ("panel_area_error", "panel_area_error_all", "panel_outline_mm", "panel_turning")
"""What `measure_pattern` finds whatever the pattern; all None where the true pattern's own template was not used."""


@dataclass(frozen=True)
class TruePanel:
    """Hold one panel of a true pattern as its author drew it.

    Attributes:
        name: Its name.
        outline: Closed polygon [m], shape [n, 2], either way round.
        edges: Polyline [m] of each edge in the author's order, ends included; empty where nobody said.
    """

    name: str
    outline: np.ndarray
    edges: tuple[np.ndarray, ...] = ()


@dataclass(frozen=True)
class TrueSeam:
    """Hold one seam of a true pattern: the author's panel name and edge index of both sides."""

    a: tuple[str, int]
    b: tuple[str, int]


@dataclass(frozen=True)
class TruePattern:
    """Hold a true pattern: panels and seams."""

    panels: tuple[TruePanel, ...]
    seams: tuple[TrueSeam, ...] = ()


def measure_seams(pattern: Pattern) -> dict[str, float | None]:
    """Measure `seam_mismatch_mm`, the largest difference in length of the two sides of an ungathered seam."""
    gaps = [abs(_length(pattern, s.a) - _length(pattern, s.b)) for s in pattern.seams if not s.gathered]
    return {"seam_mismatch_mm": MM * max(gaps) if gaps else None}


def measure_pattern(pattern: Pattern, truth: TruePattern) -> dict[str, float | None]:
    """Measure a pattern against the truth that was drawn from the same template.

    Args:
        pattern: The recovered pattern.
        truth: The true one; panels correspond by name, edges by the author's order.

    Returns:
        `panel_area_error` (panels at least 12 cm wide) and `_all`: mean of |dA| / A, an unmatched panel counts 1;
        `panel_outline_mm` (at least 12 cm wide); `panel_turning` [rad]; `panels_unmatched`; `seam_mismatch_mm`;
        `gather_ratio_error.SEAM`: |ratio / true ratio - 1| of every gathered seam.
    """
    unmatched = unmatched_panels(pattern, truth)
    areas: list[float] = []
    wide_areas: list[float] = []
    outlines: list[float] = []
    turnings: list[float] = []
    for panel in truth.panels:
        wide = polygon_width(panel.outline) >= WIDE
        area = 1.0
        if panel.name not in unmatched:
            area, outline, turning = _compare(pattern.panel(panel.name), panel)
            turnings.append(turning)
            outlines += [outline] * wide
        areas.append(area)
        wide_areas += [area] * wide
    known = {panel.name for panel in truth.panels}
    for extra in pattern.panels:
        if extra.name not in known:
            areas.append(1.0)
            wide_areas += [1.0] * (polygon_width(_join(_edges(extra))) >= WIDE)
    found: dict[str, float | None] = {
        "panel_area_error": _mean(wide_areas),
        "panel_area_error_all": _mean(areas),
        "panel_outline_mm": MM * float(np.mean(outlines)) if outlines else None,
        "panel_turning": _mean(turnings),
        "panels_unmatched": float(len(unmatched)),
    }
    return found | measure_seams(pattern) | _measure_gathers(pattern, truth)


def measure_panels(pattern: Pattern, truth: TruePattern) -> dict[str, dict[str, float]]:
    """Measure each panel that both patterns have, by name: `area_error`, `outline_mm` and `turning` [rad]."""
    unmatched = unmatched_panels(pattern, truth)
    found = {}
    for panel in truth.panels:
        if panel.name not in unmatched:
            area, outline, turning = _compare(pattern.panel(panel.name), panel)
            found[panel.name] = {"area_error": area, "outline_mm": MM * outline, "turning": turning}
    return found


def unmatched_panels(pattern: Pattern, truth: TruePattern) -> tuple[str, ...]:
    """List the panels that only one of the two patterns has, by name."""
    return tuple(sorted({panel.name for panel in pattern.panels} ^ {panel.name for panel in truth.panels}))


def _compare(ours: Panel, truth: TruePanel) -> tuple[float, float, float]:
    """Give relative error of area, RMS distance of the outlines [m] and turning distance [rad] of two panels."""
    edges = _authors_edges(ours, truth)
    # The same mirror on both sides makes both counter-clockwise, which the turning function asks for.
    mirror = np.array([1.0 if polygon_area(truth.outline) > 0.0 else -1.0, 1.0])
    edges, true_edges = [line * mirror for line in edges], [line * mirror for line in truth.edges]
    outline, true_outline = _join(edges), truth.outline * mirror
    true_area = polygon_area(true_outline)
    error = abs(polygon_area(outline) - true_area) / true_area
    matched = len(edges) == len(true_edges)
    distance = edge_rms(edges, true_edges) if matched else outline_rms(outline, true_outline)
    return error, distance, turning_distance(outline, true_outline)


def _measure_gathers(pattern: Pattern, truth: TruePattern) -> dict[str, float | None]:
    """Compare the ratio of lengths of every gathered seam with the truth's."""
    true_panels = {panel.name: panel for panel in truth.panels}
    lengths = {(panel.name, i): polyline_length(line) for panel in truth.panels for i, line in enumerate(panel.edges)}
    true_seams = {frozenset((seam.a, seam.b)) for seam in truth.seams}
    found: dict[str, float | None] = {}
    for seam in pattern.seams:
        if not seam.gathered or seam.a.panel not in true_panels or seam.b.panel not in true_panels:
            continue
        a = _authors_edge(pattern, seam.a, true_panels[seam.a.panel])
        b = _authors_edge(pattern, seam.b, true_panels[seam.b.panel])
        if frozenset((a, b)) in true_seams:
            ratio = _length(pattern, seam.a) / _length(pattern, seam.b)
            found[f"gather_ratio_error.{a[0]}:{a[1]}-{b[0]}:{b[1]}"] = abs(ratio * lengths[b] / lengths[a] - 1.0)
    return found


def _edges(panel: Panel) -> list[np.ndarray]:
    """Give each edge of our panel as its author would draw it: mirrored back where it was mirrored on import [m]."""
    mirror = np.array([-1.0 if panel.mirrored else 1.0, 1.0])
    return [
        edge_points(panel, index, 1 if edge.kind == "line" else CURVE_SEGMENTS) * mirror
        for index, edge in enumerate(panel.edges)
    ]


def _runs_against(ours: Panel, truth: TruePanel) -> bool:
    """Tell whether our edges run the other way round than the author's, as they do where a panel was turned over."""
    return polygon_area(_join(_edges(ours))) * polygon_area(truth.outline) < 0.0


def _authors_edges(ours: Panel, truth: TruePanel) -> list[np.ndarray]:
    """Give our edges in the author's order and direction [m]."""
    edges = _edges(ours)
    return [line[::-1] for line in reversed(edges)] if _runs_against(ours, truth) else edges


def _authors_edge(pattern: Pattern, ref: EdgeRef, truth: TruePanel) -> tuple[str, int]:
    """Give panel and index of an edge as the author numbers them."""
    panel = pattern.panel(ref.panel)
    return ref.panel, len(panel.edges) - 1 - ref.edge if _runs_against(panel, truth) else ref.edge


def _join(edges: list[np.ndarray]) -> np.ndarray:
    """Give the closed polygon of consecutive edges [m], shape [n, 2]."""
    return np.concatenate([line[:-1] for line in edges])


def _length(pattern: Pattern, ref: EdgeRef) -> float:
    return edge_length(pattern.panel(ref.panel), ref.edge)


def _mean(values: list[float]) -> float | None:
    return float(np.mean(values)) if values else None
