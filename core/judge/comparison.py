"""Compare two patterns panel by panel (the thesis' matcher): the differences of each pair, and the unpaired panels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np

from ..garment.curves import panel_area, panel_outline
from ..garment.garmentcode import load_pattern
from ..garment.pattern import Panel, Pattern
from ..run.errors import BadInput
from ..run.units import MM_PER_M
from .matching import match_panels, mirror_outline
from .outlines import fit_outline
from .true_pattern import TruePanel, TruePattern
from .turning_distance import turning_distance

COMPARED_CURVE_SEGMENT_COUNT = 24
"""Number of segments of each compared curve: the chord error on a 50 cm curve is 0.1 mm."""

DRAWN_SEGMENTS = 12
"""Number of segments of each drawn curve: the chord error on a 50 cm curve is half a millimetre, a pixel of a page."""

TURNING_DISTANCE_TOLERANCE = 1e-6
"""Difference below which two turning distances are equal [rad]; a mirror-symmetric panel is then not turned over."""


class Pairing(StrEnum):
    """Describe why two panels are compared."""

    GIVEN = "given"
    NAME = "name"
    SHAPE = "shape"


class PairsBad(BadInput):
    """A pair names a panel that is not there, or one that is paired already; list the panels with templates show."""

    code = "match.pairs_bad"


@dataclass(frozen=True)
class PanelDifference:
    """Describe how two panels differ.

    Attributes:
        first, second: Their names.
        paired_by: Why they are compared.
        turning: Turning distance [rad], 0 for similar shapes (Arkin et al. 1991).
        area_percent: Excess of the first's area over the second's [%].
        outline_mm: RMS distance of the outlines after the best rigid fit [mm], upright by the grain unless a turned
            one is better by a third; the first turned over where that helps.
        turned_over: Whether the first is turned over: x becomes -x, before it is moved.
        angle: Rotation of the first in the best fit, counter-clockwise about the origin [rad].
        shift: Translation after that [m].
    """

    first: str
    second: str
    paired_by: Pairing
    turning: float
    area_percent: float
    outline_mm: float
    turned_over: bool
    angle: float
    shift: tuple[float, float]


@dataclass(frozen=True)
class Comparison:
    """Describe how two patterns differ: the pairs of panels, in the order of the second pattern, and the names of
    panels without a counterpart."""

    pairs: tuple[PanelDifference, ...]
    only_first: tuple[str, ...]
    only_second: tuple[str, ...]


def compare_patterns(
    first: Pattern, second: Pattern, named_pairs: Mapping[str, str] | None = None, only_given: bool = False
) -> Comparison:
    """Compare two patterns.

    Args:
        first: One pattern.
        second: The other.
        named_pairs: Names of the second's panels by the first's, for panels that are paired in any case. The others are
            paired by name, then by shape (`match_panels`).
        only_given: Pair no others.

    Raises:
        PairsBad: where a given pair names a panel that is not there, or one twice.
    """
    named_pairs = named_pairs or {}
    _check_pairs(first, second, named_pairs)
    pairs = [(a, b, Pairing.GIVEN) for a, b in named_pairs.items()]
    rest = replace(first, panels=tuple(panel for panel in first.panels if panel.name not in named_pairs), seams=())
    other_rest = _to_true_pattern(panel for panel in second.panels if panel.name not in named_pairs.values())
    for pair in () if only_given else match_panels(rest, other_rest):
        pairs.append((pair.ours.name, pair.truth.name, Pairing.NAME if pair.by_name else Pairing.SHAPE))
    places = {panel.name: place for place, panel in enumerate(second.panels)}
    pairs.sort(key=lambda pair: places[pair[1]])
    return Comparison(
        tuple(_describe(first.panel(a), second.panel(b), pairing) for a, b, pairing in pairs),
        tuple(panel.name for panel in first.panels if panel.name not in {a for a, _, _ in pairs}),
        tuple(panel.name for panel in second.panels if panel.name not in {b for _, b, _ in pairs}),
    )


def compare_files(
    first: str, second: str, pairs: Mapping[str, str], only_given: bool = False, outlines: bool = False
) -> dict[str, Any]:
    """Read two pattern files in a limited process, and compare them.

    Args:
        first, second: The files.
        pairs, only_given: As in `compare_patterns`.
        outlines: Add each pattern's outlines, as `first_outlines` and `second_outlines`.

    Raises:
        BadInput: where one is not a pattern, or a given pair is bad.
    """
    patterns = [load_pattern(Path(first)), load_pattern(Path(second))]
    found = asdict(compare_patterns(patterns[0], patterns[1], pairs, only_given))
    if outlines:
        for name, pattern in zip(("first_outlines", "second_outlines"), patterns, strict=True):
            found[name] = {panel.name: draw_outline(panel) for panel in pattern.panels}
    return found


def draw_outline(panel: Panel) -> list[list[float]]:
    """Return a panel's outline as points [m], rounded to 0.001 mm."""
    return [[round(x, 6), round(y, 6)] for x, y in panel_outline(panel, DRAWN_SEGMENTS).tolist()]


def _check_pairs(first: Pattern, second: Pattern, pairs: Mapping[str, str]) -> None:
    for names, pattern in ((list(pairs), first), (list(pairs.values()), second)):
        known = [panel.name for panel in pattern.panels]
        unknown = next((name for name in names if name not in known), None)
        if unknown is not None:
            raise PairsBad(
                f"there is no panel '{unknown[:60]}' in '{pattern.name[:60]}'; there are {', '.join(known)}."
            )
        if len(set(names)) < len(names):
            raise PairsBad(f"a panel of '{pattern.name[:60]}' is paired twice; give each at most one counterpart.")


def _to_true_pattern(panels: Iterable[Panel]) -> TruePattern:
    """Return panels as a pattern with which others are compared."""
    return TruePattern(
        tuple(TruePanel(panel.name, panel_outline(panel, COMPARED_CURVE_SEGMENT_COUNT)) for panel in panels)
    )


def _describe(first: Panel, second: Panel, pairing: Pairing) -> PanelDifference:
    """Compare two panels by their outlines, the first turned over where its turning function then fits better."""
    one, other = (
        panel_outline(first, COMPARED_CURVE_SEGMENT_COUNT),
        panel_outline(second, COMPARED_CURVE_SEGMENT_COUNT),
    )
    turning, over = turning_distance(one, other), turning_distance(mirror_outline(one), other)
    is_over = over < turning - TURNING_DISTANCE_TOLERANCE
    if is_over:
        turning, one = over, mirror_outline(one)
    area = 100.0 * (panel_area(first) / panel_area(second) - 1.0)
    fit = fit_outline(one, other, upright=second.grainline + (first.grainline if is_over else -first.grainline))
    rotation, shift = fit.motion.rotation, fit.motion.translation
    angle = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
    names, place = (first.name, second.name), (float(shift[0]), float(shift[1]))
    return PanelDifference(*names, pairing, turning, area, MM_PER_M * fit.rms, is_over, angle, place)
