"""Grade a pattern to a size by rules: its named points by figures, the rest by its draft or by spreading."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..measures import BodyMeasures
from ..pattern import Pattern
from .arm_points import find_arm_halves, is_cap_low
from .closing import close_seams, measure_ease
from .errors import CapUnfit
from .figures import Figure, find_figures
from .growth import Growth
from .moves import match_drafts, move_panel_by_drafts
from .sleeve_moves import move_sleeves
from .spread import spread_pattern
from .tangents import keep_tangents

MAX_CAP_STEP_COUNT = 30
"""Largest number of secant steps by which the height of a cap is found; five are taken."""

CAP_LENGTH_TOLERANCE = 1e-7
"""Difference of a cap's ease at which its height is found [m]."""

MAX_CAP_MISFIT = 1e-4
"""Largest difference of all caps' ease that is left to the closing of seams [m]: what can be sewn."""

MIN_CAP_HEIGHT_SHARE = 0.3
"""Smallest share of its height that the cap of a size keeps; a lower one lifts the sleeve off the shoulder."""

MAX_CAP_HEIGHT_SHARE = 2.0
"""Largest ratio of the height of a size's cap to that of the graded pattern's."""


@dataclass(frozen=True)
class GradedPattern:
    """Describe a pattern in another size.

    Attributes:
        pattern: Its pattern; caps have the ease of the graded one's, other seams are equal.
        figures: What was graded by rule.
        is_drafted: Whether what no figure says follows a draft; else the pattern was spread between named points.
    """

    pattern: Pattern
    figures: tuple[Figure, ...]
    is_drafted: bool


def grade_pattern(
    pattern: Pattern,
    base: BodyMeasures,
    height: float,
    growth: Growth,
    drafts: tuple[Pattern, Pattern] | None = None,
) -> GradedPattern:
    """Return a pattern in another size.

    Args:
        pattern: The pattern, for a wearer of the measures `base`.
        base: The wearer's measures.
        height: The wearer's height [m].
        growth: Of the size.
        drafts: The base pattern's drafts for the wearer and for the size; None where there is none.

    Raises:
        CapUnfit: where no cap fits the size's arm and armhole.
    """
    figures = find_figures(pattern, base, height)
    if growth.is_zero:
        return GradedPattern(pattern, figures, True)
    is_drafted = drafts is not None and match_drafts(pattern, drafts[0]) and match_drafts(pattern, drafts[1])
    if drafts is not None and is_drafted:
        triples = zip(pattern.panels, drafts[0].panels, drafts[1].panels, strict=True)
        moved = replace(pattern, panels=tuple(move_panel_by_drafts(*panels, growth.stature) for panels in triples))
    else:
        moved = spread_pattern(pattern, base, growth)
    moved = keep_tangents(pattern, _apply_rules(pattern, moved, figures, growth))
    if find_arm_halves(pattern):
        moved = _fit_caps(pattern, moved, growth, height)
        moved = _apply_rules(pattern, moved, figures, growth)
    rows = np.array([figure.row(pattern) for figure in figures]).reshape(-1, 2 * len(pattern.points))
    return GradedPattern(close_seams(moved, pattern, rows), figures, is_drafted)


def _apply_rules(pattern: Pattern, moved: Pattern, figures: tuple[Figure, ...], growth: Growth) -> Pattern:
    """Return a moved pattern whose figures have grown by their rules."""
    for figure in figures:
        due = figure.value(pattern) + figure.rule.grow(growth, figure.value(pattern))
        moved = figure.change(moved, due - figure.value(moved))
    return moved


def _fit_caps(pattern: Pattern, trunk: Pattern, growth: Growth, height: float) -> Pattern:
    """Return a pattern whose caps have that growth at which all of them together keep their ease: of their height, or
    of height and width alike where they are low.

    Raises:
        CapUnfit: where there is none.
    """
    ease, halves = float(measure_ease(pattern).sum()), find_arm_halves(pattern)
    cap = min(half.cap_height for half in halves)
    bicep = 2.0 * float(np.mean([half.width for half in halves]))

    def move(share: float) -> Pattern:
        wider = replace(growth, upper_arm=share * bicep) if is_cap_low(halves) else growth
        return move_sleeves(pattern, trunk, wider, height, share * cap)

    def excess(share: float) -> float:
        return float(measure_ease(move(share)).sum()) - ease

    least, most = MIN_CAP_HEIGHT_SHARE - 1.0, MAX_CAP_HEIGHT_SHARE - 1.0
    shares = [0.0, 0.1]
    values = [excess(share) for share in shares]
    for _ in range(MAX_CAP_STEP_COUNT):
        if abs(values[-1]) < CAP_LENGTH_TOLERANCE or values[-1] == values[-2]:
            break
        step = values[-1] * (shares[-1] - shares[-2]) / (values[-1] - values[-2])
        shares.append(float(np.clip(shares[-1] - step, least, most)))
        values.append(excess(shares[-1]))
    if abs(values[-1]) > MAX_CAP_MISFIT or not least < shares[-1] < most:
        raise CapUnfit()
    return move(shares[-1])
