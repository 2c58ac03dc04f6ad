"""Measure how fair a pattern's curves are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..garment.curves import panel_outline
from ..garment.fairness import NO_PROVED_CORNERS, SmoothJoin, interior_angles, unplanned_corners
from ..garment.pattern import Panel, Pattern

FAIRNESS_SEGMENT_COUNT = 64
"""Number of parts of each curve: a corner then shows as one angle, and a bend as many small ones."""

MIN_BEND_ANGLE = np.radians(2.0)
"""Smallest total turn of a stretch that counts as a bend [rad]. A stretch that turns by less as a whole counts as
straight."""

MIN_NARROWING_ANGLE = np.radians(20.0)
"""Smallest angle by which a corner narrower than the base pattern's is the recovery's own [rad]: collars, darts and
gores are cut to a point."""


def measure_fairness(
    pattern: Pattern, base: Pattern, proved: Mapping[SmoothJoin, float] = NO_PROVED_CORNERS
) -> dict[str, float | None]:
    """Measure corners and waves of a recovered pattern that its base pattern does not have.

    `pattern.corner_deg` is the largest corner of a boundary where the base pattern is smooth, within a panel or across
    the end of a seam; None where it is smooth nowhere. Where the scan proves a corner it is the difference from that.
    `pattern.proved_corner_deg` is the largest of those; None where there is none. `pattern.waves` counts how many more
    often than the base pattern's the outlines change between turning left and right. `pattern.pointed_corner_deg` is by
    how much the narrowest corner of a panel is below a right angle, of those that are narrower than the base pattern's
    by `MIN_NARROWING_ANGLE`; 0 where there is none.

    Args:
        pattern: The recovered pattern.
        base: The base pattern, with the same panels.
        proved: Corners that the scan proves, by how far the boundary turns there [rad].
    """
    corners = np.degrees(np.abs(unplanned_corners(pattern, base, proved)))
    pairs = tuple(zip(pattern.panels, base.panels, strict=True))
    waves = sum(max(0, count_waves(ours) - count_waves(theirs)) for ours, theirs in pairs)
    angles = [(interior_angles(ours), interior_angles(theirs)) for ours, theirs in pairs]
    pointed = max(
        float(np.max(0.5 * np.pi - ours[theirs - ours > MIN_NARROWING_ANGLE], initial=0.0)) for ours, theirs in angles
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
    first = int(np.argmax(np.abs(turn)))  # a corner: no stretch goes on across it unless it turns the same way
    turn, sign = np.roll(turn, -first), np.roll(sign, -first)
    stretch = np.cumsum(np.r_[True, sign[1:] != sign[:-1]]) - 1
    total = np.bincount(stretch, turn)
    felt = np.sign(total[np.abs(total) > MIN_BEND_ANGLE])
    return int(np.sum(felt != np.roll(felt, 1)))
