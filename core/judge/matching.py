"""Match the panels of a recovered pattern to those of a true one: by name, else by shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..garment.curves import panel_outline
from ..garment.pattern import Panel, Pattern
from ..garment.polygon import polygon_area
from ..geometry.curves import Curve
from .true_pattern import TruePanel, TruePattern
from .turning_distance import turning_distance

MAX_PANEL_AREA_RATIO = 2.0
"""Ratio of areas from which two panels do not match, whatever their shape: base patterns of the same cut start up to 47
% wrong, and a piece that one author cuts in halves differs by 2."""

MATCHING_POINT_COUNT = 48
"""Number of points on an outline for matching. Different shapes differ by ten times the sampling error."""

PANEL_MIRROR_SIGNS = np.array([-1.0, 1.0])
"""Factors on x and y that mirror a flat panel, shape [2]."""


@dataclass(frozen=True)
class PanelPair:
    """Describe two matched panels. `by_name` is True where both have one name, and so their edges correspond; else only
    their shapes agree."""

    ours: Panel
    truth: TruePanel
    by_name: bool


def match_panels(pattern: Pattern, truth: TruePattern) -> tuple[PanelPair, ...]:
    """Pair the panels of both patterns: those of one name, then the others by shape.

    By shape means the assignment of least total cost (Hungarian method); a pair costs its turning distance [rad] plus
    |ln(area / true area)|: unrelated outlines differ by 0.4 to 0.8 rad, as much as areas by a factor of 1.5 to 2.2.
    Either may be turned over, since some authors draw a back panel from the inside. Pairs with areas that differ by a
    factor of `MAX_PANEL_AREA_RATIO` or more are excluded.

    Returns:
        The pairs in the order of the true panels.
    """
    by_name = {panel.name: panel for panel in pattern.panels}
    true_names = {panel.name for panel in truth.panels}
    pairs = {panel.name: PanelPair(by_name[panel.name], panel, True) for panel in truth.panels if panel.name in by_name}
    left = [panel for panel in pattern.panels if panel.name not in true_names]
    unnamed = [panel for panel in truth.panels if panel.name not in by_name]
    if left and unnamed:
        cost = np.array([[_dissimilarity(panel, other) for other in unnamed] for panel in left])
        for row, column in zip(*linear_sum_assignment(np.minimum(cost, 1e6)), strict=True):
            if np.isfinite(cost[row, column]):
                pairs[unnamed[column].name] = PanelPair(left[row], unnamed[column], False)
    return tuple(pairs[panel.name] for panel in truth.panels if panel.name in pairs)


def orient_counter_clockwise(outline: np.ndarray) -> np.ndarray:
    """Return an outline [m], shape [n, 2], counter-clockwise; a clockwise one is mirrored, not renumbered."""
    return outline if polygon_area(outline) > 0.0 else outline * PANEL_MIRROR_SIGNS


def mirror_outline(outline: np.ndarray) -> np.ndarray:
    """Return the mirror image of a counter-clockwise outline [m], again counter-clockwise."""
    return np.asarray((outline * PANEL_MIRROR_SIGNS)[::-1])


def _dissimilarity(panel: Panel, truth: TruePanel) -> float:
    """Return the cost of matching two panels; inf where they cannot match."""
    outline, true_outline = orient_counter_clockwise(panel_outline(panel)), orient_counter_clockwise(truth.outline)
    grown = abs(float(np.log(polygon_area(outline) / polygon_area(true_outline))))
    if grown >= np.log(MAX_PANEL_AREA_RATIO):
        return np.inf
    outline, true_outline = (
        Curve(outline).resample(MATCHING_POINT_COUNT),
        Curve(true_outline).resample(MATCHING_POINT_COUNT),
    )
    return grown + min(turning_distance(either, true_outline) for either in (outline, mirror_outline(outline)))
