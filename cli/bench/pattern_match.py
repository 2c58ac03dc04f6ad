"""Measure how well the recovered pattern matches the true one, panel by panel and seam by seam."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull

from ...core.garment.curves import edge_length, edge_points, panel_outline
from ...core.garment.pattern import EdgeRef, Panel, Pattern
from ...core.garment.polygon import polygon_area
from ...core.geometry.curves import polyline_length, resample_polyline
from ...core.geometry.rigid import fit_rigid
from ...core.judge.matching import PanelPair, match_panels, mirror_outline, orient_counter_clockwise
from ...core.judge.outlines import fit_outline
from ...core.judge.patterns import measure_seams
from ...core.judge.true_pattern import TruePanel, TruePattern
from ...core.judge.turning_distance import turning_distance
from ...core.run.units import MM_PER_M

MAX_BAND_WIDTH = 0.12
"""Width below which a panel is a band [m]: a tight band's length and its stretch (up to 20 %) cannot be separated."""

EDGE_SAMPLES = 50
"""Number of points on each edge: 2 cm apart on the longest side of trousers."""

MEASURED_CURVE_SEGMENT_COUNT = 100
"""Number of segments of a measured curve: its chord error on a 50 cm curve is below 0.01 mm."""

PATTERN_METRICS = (
    "panel_area_error",
    "panel_area_error_all",
    "panel_area_error_narrow",
    "panel_outline_mm",
    "panel_outline_narrow_mm",
    "panel_turning",
)
"""Metrics that `measure_pattern` returns for every pattern; all None where the true pattern has another cut."""


def measure_pattern(pattern: Pattern, truth: TruePattern, same_template: bool = True) -> dict[str, float | None]:
    """Measure a pattern against the truth.

    Args:
        pattern: The recovered pattern.
        truth: The true one; panels correspond as `match_panels` finds.
        same_template: Whether both come from one template: edges of panels of one name then correspond, in the author's
            order. Otherwise outlines are compared by closest points, and gathers not at all.

    Returns:
        `panel_area_error` (panels at least 12 cm wide), `_narrow` (the others) and `_all`: mean of |dA| / A, an
        unmatched panel counts 1; `panel_outline_mm` and `panel_outline_narrow_mm` likewise; `panel_turning` [rad];
        `panels_unmatched`; `seam_mismatch_mm`; `gather_ratio_error.SEAM`: |ratio / true ratio - 1| of gathered seams.
    """
    pairs = {pair.truth.name: pair for pair in match_panels(pattern, truth)}
    areas: dict[bool, list[float]] = {True: [], False: []}
    outlines: dict[bool, list[float]] = {True: [], False: []}
    turnings: list[float] = []
    for panel in truth.panels:
        wide, area = is_wide(panel.outline), 1.0
        if panel.name in pairs:
            area, outline, turning = _compare(pairs[panel.name], same_template)
            turnings.append(turning)
            outlines[wide].append(MM_PER_M * outline)
        areas[wide].append(area)
    matched = {pair.ours.name for pair in pairs.values()}
    extra = [panel for panel in pattern.panels if panel.name not in matched]
    for ours in extra:
        areas[is_wide(panel_outline(ours))].append(1.0)
    found: dict[str, float | None] = {
        "panel_area_error": _mean(areas[True]),
        "panel_area_error_all": _mean(areas[True] + areas[False]),
        "panel_area_error_narrow": _mean(areas[False]),
        "panel_outline_mm": _mean(outlines[True]),
        "panel_outline_narrow_mm": _mean(outlines[False]),
        "panel_turning": _mean(turnings),
        "panels_unmatched": float(len(extra) + len(truth.panels) - len(pairs)),
    }
    return found | measure_seams(pattern) | (_measure_gathers(pattern, truth) if same_template else {})


def measure_panels(pattern: Pattern, truth: TruePattern, same_template: bool = True) -> dict[str, dict[str, float]]:
    """Measure each panel with a counterpart, by its true name: `area_error`, `outline_mm` and `turning` [rad]."""
    found = {}
    for pair in match_panels(pattern, truth):
        area, outline, turning = _compare(pair, same_template)
        found[pair.truth.name] = {"area_error": area, "outline_mm": MM_PER_M * outline, "turning": turning}
    return found


def unmatched_panels(pattern: Pattern, truth: TruePattern) -> tuple[str, ...]:
    """List the panels of either pattern without a counterpart in the other, by name."""
    pairs = match_panels(pattern, truth)
    ours = {panel.name for panel in pattern.panels} - {pair.ours.name for pair in pairs}
    return tuple(sorted(ours | ({panel.name for panel in truth.panels} - {pair.truth.name for pair in pairs})))


def _compare(pair: PanelPair, same_template: bool) -> tuple[float, float, float]:
    """Return relative error of area, RMS distance of the outlines [m] and turning distance [rad] of two panels."""
    if not (pair.by_name and same_template):
        return _compare_shapes(pair.ours, pair.truth)
    truth = pair.truth
    edges = _authors_edges(pair.ours, truth)
    # The same mirror on both sides makes both counter-clockwise, as the turning function requires.
    mirror = np.array([1.0 if polygon_area(truth.outline) > 0.0 else -1.0, 1.0])
    edges, true_edges = [line * mirror for line in edges], [line * mirror for line in truth.edges]
    outline, true_outline = _join(edges), truth.outline * mirror
    matched = len(edges) == len(true_edges)
    distance = edge_rms(edges, true_edges) if matched else fit_outline(outline, true_outline).rms
    return _area_error(outline, true_outline), distance, turning_distance(outline, true_outline)


def _compare_shapes(ours: Panel, truth: TruePanel) -> tuple[float, float, float]:
    """Compare panels whose edges do not correspond, ours turned over where its turning function then fits better."""
    outline, true_outline = orient_counter_clockwise(_join(_edges(ours))), orient_counter_clockwise(truth.outline)
    turnings = [(turning_distance(either, true_outline), either) for either in (outline, mirror_outline(outline))]
    turning, outline = min(turnings, key=lambda found: found[0])
    return _area_error(outline, true_outline), fit_outline(outline, true_outline).rms, turning


def _area_error(outline: np.ndarray, true_outline: np.ndarray) -> float:
    true_area = polygon_area(true_outline)
    return abs(polygon_area(outline) - true_area) / true_area


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
    """Return each edge of a panel as its author would draw it [m]: mirrored back where it was mirrored on import."""
    mirror = np.array([-1.0 if panel.mirrored else 1.0, 1.0])
    return [
        edge_points(panel, index, 1 if edge.kind == "line" else MEASURED_CURVE_SEGMENT_COUNT) * mirror
        for index, edge in enumerate(panel.edges)
    ]


def _has_opposite_winding(ours: Panel, truth: TruePanel) -> bool:
    """Check whether our edges run opposite to the author's, as they do where a panel was turned over."""
    return polygon_area(_join(_edges(ours))) * polygon_area(truth.outline) < 0.0


def _authors_edges(ours: Panel, truth: TruePanel) -> list[np.ndarray]:
    """Return our edges in the author's order and direction [m]."""
    edges = _edges(ours)
    return [line[::-1] for line in reversed(edges)] if _has_opposite_winding(ours, truth) else edges


def _authors_edge(pattern: Pattern, ref: EdgeRef, truth: TruePanel) -> tuple[str, int]:
    """Return panel and index of an edge in the author's numbering."""
    panel = pattern.panel(ref.panel)
    return ref.panel, len(panel.edges) - 1 - ref.edge if _has_opposite_winding(panel, truth) else ref.edge


def _join(edges: list[np.ndarray]) -> np.ndarray:
    """Return the closed polygon of consecutive edges [m], shape [n, 2]."""
    return np.concatenate([line[:-1] for line in edges])


def _length(pattern: Pattern, ref: EdgeRef) -> float:
    return edge_length(pattern.panel(ref.panel), ref.edge)


def _mean(values: list[float]) -> float | None:
    return float(np.mean(values)) if values else None


def is_wide(outline: np.ndarray) -> bool:
    """Check by its outline [m], shape [n, 2], whether a panel is wider than a band."""
    return polygon_width(outline) >= MAX_BAND_WIDTH


def is_same_cut(pattern: Pattern, truth: TruePattern) -> bool:
    """Check whether the wide panels of both patterns correspond one to one, so that they can be compared."""
    pairs = match_panels(pattern, truth)
    matched = {pair.ours.name for pair in pairs} if pairs else set()
    known = {pair.truth.name for pair in pairs}
    ours = all(panel.name in matched for panel in pattern.panels if is_wide(panel_outline(panel)))
    return ours and all(panel.name in known for panel in truth.panels if is_wide(panel.outline))


def edge_rms(ours: Sequence[np.ndarray], truth: Sequence[np.ndarray]) -> float:
    """Measure the RMS distance [m] of corresponding edges after one rigid fit of the whole panel."""
    source = np.concatenate([resample_polyline(line, EDGE_SAMPLES) for line in ours])
    target = np.concatenate([resample_polyline(line, EDGE_SAMPLES) for line in truth])
    return float(np.sqrt(np.mean(np.sum((fit_rigid(source, target).apply(source) - target) ** 2, axis=1))))


def polygon_width(polygon: np.ndarray) -> float:
    """Return the smallest distance [m] between two parallel lines with a polygon, shape [n, 2], between them."""
    corners = polygon[ConvexHull(polygon).vertices]
    side = np.roll(corners, -1, axis=0) - corners
    side = side / np.linalg.norm(side, axis=1, keepdims=True)
    height = corners @ np.stack([-side[:, 1], side[:, 0]])
    return float(np.min(height.max(axis=0) - height.min(axis=0)))
