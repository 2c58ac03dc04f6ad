"""Measure how fair a pattern's curves are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..garment.curves import panel_outline
from ..garment.fairness import NO_PROVED_CORNERS, SmoothJoin, interior_angles, unplanned_corners
from ..garment.pattern import Panel, Pattern

FAIRNESS_SEGMENT_COUNT = 64
"""Number of segments of each curve: a corner is then one angle, and a bend many small ones."""

MIN_BEND_ANGLE = np.radians(2.0)
"""Smallest total turn of a stretch that counts as a bend [rad]; a stretch that turns by less counts as straight."""

MIN_NARROWING_ANGLE = np.radians(20.0)
"""Smallest narrowing of a corner that is due to the recovery [rad]; collars, darts and gores are pointed by design."""


def measure_fairness(
    pattern: Pattern, base: Pattern, proved: Mapping[SmoothJoin, float] = NO_PROVED_CORNERS
) -> dict[str, float | None]:
    """Measure corners and waves of a recovered pattern that its base pattern does not have.

    `pattern.corner_deg`: the largest corner of a boundary where the base pattern is smooth, within a panel or across
    the end of a seam; the difference from it where the scan proves a corner; None where the base is smooth nowhere.
    `pattern.proved_corner_deg`: the largest proved corner, or None. `pattern.waves`: how many more often than the base
    pattern's the outlines change between turning left and right. `pattern.pointed_corner_deg`: how far the narrowest
    corner of a panel is below a right angle, of those narrower than the base pattern's by `MIN_NARROWING_ANGLE`, or 0.

    Args:
        pattern: The recovered pattern.
        base: The base pattern, with the same panels.
        proved: Turning angle of each corner that the scan proves [rad].
    """
    corners = np.degrees(np.abs(unplanned_corners(pattern, base, proved)))
    pairs = tuple(zip(pattern.panels, base.panels, strict=True))
    waves = sum(max(0, count_waves(edge) - count_waves(truth)) for edge, truth in pairs)
    angles = [(interior_angles(edge), interior_angles(truth)) for edge, truth in pairs]
    pointed = max(
        float(np.max(0.5 * np.pi - edge[truth - edge > MIN_NARROWING_ANGLE], initial=0.0)) for edge, truth in angles
    )
    return {
        "pattern.corner_deg": float(corners.max()) if len(corners) else None,
        "pattern.proved_corner_deg": max((float(np.degrees(abs(angle))) for angle in proved.values()), default=None),
        "pattern.pointed_corner_deg": float(np.degrees(pointed)),
        "pattern.waves": float(waves),
    }


def count_waves(panel: Panel) -> int:
    """Count how often a panel's closed outline changes between turning left and turning right."""
    outline = panel_outline(panel, FAIRNESS_SEGMENT_COUNT)
    step = np.roll(outline, -1, axis=0) - outline
    after = np.roll(step, -1, axis=0)
    turn = np.arctan2(step[:, 0] * after[:, 1] - step[:, 1] * after[:, 0], (step * after).sum(axis=1))
    sign = np.sign(turn)
    first = int(np.argmax(np.abs(turn)))  # a corner: a stretch continues across it only with the same sign
    turn, sign = np.roll(turn, -first), np.roll(sign, -first)
    stretch = np.cumsum(np.r_[True, sign[1:] != sign[:-1]]) - 1
    total = np.bincount(stretch, turn)
    signs = np.sign(total[np.abs(total) > MIN_BEND_ANGLE])
    return int(np.sum(signs != np.roll(signs, 1)))
