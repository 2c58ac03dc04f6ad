"""Find the line at which a bodice is sewn to a skirt or legs by the curvature of the cloth there."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass

import numpy as np

from ...garment.parts.cut import Cut, Skirt
from ...garment.pattern import Pattern, Seam
from .trunk_curvature import TrunkCurvature

WAIST_HALF_WIDTH_SHARE = 0.16
"""Share of the waist girth up to which curvature is counted on both sides of the middle plane: 13 cm of 82. Half the
width of a waist is 0.19 of its girth and more, and at the sides a dress in one piece is curved by its side seams."""

CURVATURE_BAND_HEIGHT, CURVATURE_BAND_COUNT = 0.04, 8
"""Height [m] of the bands by which curvature is summed, and their number, half of them below the waist. A seam across
is within two of them; together they reach from below the bust to the hips."""

MIN_WAIST_CURVATURE = 1.0
"""Curvature of front and back together from which a line is accepted [rad]. Four dresses with darts at a waist seam,
draped by another simulator, have 2.3 to 5.5; garments without one at most 0.6 at 1 mm of noise."""

MIN_LINE_CURVATURE_SHARE = 0.5
"""Smallest share of the line's two bands in the absolute curvature of all: strained cloth is curved everywhere."""

HEIGHT_STEP, TILT_STEP, MAX_WAIST_TILT = 0.0025, 0.02, 0.3
"""Steps in height [m] and slope by which the line is searched, and the largest slope, 17 degrees."""

WAIST_LINE_STD = 0.01
"""Standard deviation of the height over which curvature is counted as the line's [m]: an edge of a scan of 10 000
faces; with 0.5 mm of noise the line is within 2.5 mm."""

WAIST_LABEL_PREFIX = "waist."
"""Beginning of the labels of a draft's edges at its waist seam."""

SHEATH_SKIRTS = (Skirt.STRAIGHT, Skirt.PENCIL, Skirt.A_LINE)
"""Skirts whose upper edge, without darts, is nearly straight, as a bodice's lower one: they leave no curvature."""


@dataclass(frozen=True)
class WaistLine:
    """Describe the plane of a waist seam across front and back.

    Attributes:
        normal: Its unit normal, upwards, shape [3].
        offset: Of its points along the normal [m].
        sideways: Unit vector to the wearer's left, shape [3].
        middle: Of the body, along `sideways` [m].
        reach: How far to both sides of the middle the line is visible [m].
    """

    normal: np.ndarray
    offset: float
    sideways: np.ndarray
    middle: float
    reach: float

    def is_seen_at(self, points: np.ndarray) -> np.ndarray:
        """Return which points are where the line is visible: not at the sides, shape [n]."""
        return np.asarray(np.abs(points @ self.sideways - self.middle) < self.reach)


def sew_waist(cut: Cut, fixed: Container[str]) -> Cut:
    """Return the cut whose waist is curved as seen: with a waist seam, and with darts where an edge would be straight.

    Args:
        cut: The cut; unchanged without a place for a waist seam.
        fixed: Parts that stay.
    """
    if "waist" in fixed or not cut.has_place_for("waist"):
        return cut
    darts = cut.skirt in SHEATH_SKIRTS and "shaping" not in fixed
    return cut.choose({"waist": "seam", **({"shaping": "darts"} if darts else {})})


def is_waist_seam(pattern: Pattern, seam: Seam) -> bool:
    """Return whether a seam of a drafted pattern joins a bodice to what hangs from it."""
    return pattern.panel(seam.a.panel).edges[seam.a.edge].label.startswith(WAIST_LABEL_PREFIX)


def has_curved_waist(cloth: TrunkCurvature) -> bool:
    """Return whether the cloth is curved along a line across front and back near the waist, as by a seam there.

    Where darts end at a waist seam, or a curved edge is sewn to a straight one, the cloth has negative curvature; a
    dress without that seam has none between its side seams. A seam between two straight edges leaves no trace.
    """
    return _find_band(cloth) is not None


def find_waist_line(cloth: TrunkCurvature) -> WaistLine | None:
    """Find the plane of the cloth's curved line; None where there is none (`has_curved_waist`).

    Of all planes near the line's bands, the one with most negative curvature, vertices at a height h off it weighted by
    exp(-(h / WAIST_LINE_STD)^2 / 2). It may slope between front and back, and is level across.
    """
    band = _find_band(cloth)
    if band is None:
        return None
    counted, above = _select_vertices(cloth)
    above, forwards = above[counted], cloth.points[counted, 2]
    middle, curvature = float(np.median(forwards)), cloth.curvature[counted]
    heights = CURVATURE_BAND_HEIGHT * (band - CURVATURE_BAND_COUNT // 2) + np.arange(
        -CURVATURE_BAND_HEIGHT, 3.0 * CURVATURE_BAND_HEIGHT, HEIGHT_STEP
    )
    tilts = np.arange(-MAX_WAIST_TILT, MAX_WAIST_TILT + TILT_STEP / 2, TILT_STEP)

    def found_at(height: float, tilt: float) -> float:
        off = above - height - tilt * (forwards - middle)
        return -float(curvature @ np.exp(-0.5 * (off / WAIST_LINE_STD) ** 2))

    height, tilt = max(((h, t) for h in heights for t in tilts), key=lambda place: found_at(*place))
    normal = cloth.axes[1] - tilt * cloth.axes[2]
    offset = cloth.origin @ normal + cloth.measures.waist_height + height - tilt * middle
    length = float(np.linalg.norm(normal))
    sideways = cloth.axes[0]
    reach = WAIST_HALF_WIDTH_SHARE * cloth.measures.waist
    return WaistLine(normal / length, float(offset) / length, sideways, float(cloth.origin @ sideways), reach)


def _find_band(cloth: TrunkCurvature) -> int | None:
    """Return the lower of the line's two bands, counted from below; None where there is no line."""
    counted, above = _select_vertices(cloth)
    band = np.floor(above / CURVATURE_BAND_HEIGHT).astype(np.int64) + CURVATURE_BAND_COUNT // 2
    counted &= (band >= 0) & (band < CURVATURE_BAND_COUNT)
    bands = np.bincount(band[counted], weights=cloth.curvature[counted], minlength=CURVATURE_BAND_COUNT)
    lines = bands[:-1] + bands[1:]
    at = int(np.argmin(lines[1:-1])) + 1  # not at the ends of the bands
    return (
        at if lines[at] < -MIN_WAIST_CURVATURE and -lines[at] > MIN_LINE_CURVATURE_SHARE * np.abs(bands).sum() else None
    )


def _select_vertices(cloth: TrunkCurvature) -> tuple[np.ndarray, np.ndarray]:
    """Return which vertices are in front or behind, within the bands' reach, and all heights above the waist."""
    above = cloth.points[:, 1] - cloth.measures.waist_height
    counted = np.abs(cloth.points[:, 0]) < WAIST_HALF_WIDTH_SHARE * cloth.measures.waist
    return counted & (np.abs(above) < CURVATURE_BAND_HEIGHT * (CURVATURE_BAND_COUNT // 2)), above
