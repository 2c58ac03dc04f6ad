"""Find the line at which a bodice is sewn to a skirt or legs by the curvature of the cloth there."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass

import numpy as np

from ...garment.parts.cut import Cut, Skirt
from ...garment.pattern import Pattern, Seam
from .trunk_curvature import TrunkCurvature

WAIST_LABEL_PREFIX = "waist."
"""Beginning of the labels of a draft's edges at its waist seam."""

SHEATH_SKIRTS = (Skirt.STRAIGHT, Skirt.PENCIL, Skirt.A_LINE)
"""Skirts whose upper edge, without darts, is nearly straight, as a bodice's lower one: they leave no curvature."""


@dataclass(frozen=True)
class WaistSeamSettings:
    """Describe the search of a waist seam.

    Attributes:
        half_width: Share of the waist girth up to which curvature is counted on both sides of the middle plane: 13 cm
            of 82. Half the width of a waist is 0.19 of it and more; at its sides a dress is curved by its side seams.
        band_height: Height of the bands by which curvature is summed [m]: a seam across is within two of them.
        bands: Number of the bands, half of them below the waist: they reach from below the bust to the hips.
        curvature: Curvature of front and back together from which a line is accepted [rad]. Four dresses with darts at
            a waist seam, draped by another simulator, have 2.3 to 5.5; garments without one at most 0.6 at 1 mm noise.
        curvature_share: Smallest share of its two bands in all absolute curvature: strained cloth is curved everywhere.
        height_step: Step in height by which the line is searched [m].
        tilt_step, max_tilt: Ratio of rise to run of a step of the line's slope, and of the largest slope, 17 degrees.
        line_std: Standard deviation of the height over which curvature is counted as the line's [m]: an edge of a scan
            of 10 000 faces; with 0.5 mm of noise the line is within 2.5 mm.
    """

    half_width: float = 0.16
    band_height: float = 0.04
    bands: int = 8
    curvature: float = 1.0
    curvature_share: float = 0.5
    height_step: float = 0.0025
    tilt_step: float = 0.02
    max_tilt: float = 0.3
    line_std: float = 0.01


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


def has_curved_waist(cloth: TrunkCurvature, settings: WaistSeamSettings = WaistSeamSettings()) -> bool:
    """Return whether the cloth is curved along a line across front and back near the waist, as by a seam there.

    Where darts end at a waist seam, or a curved edge is sewn to a straight one, the cloth has negative curvature; a
    dress without that seam has none between its side seams. A seam between two straight edges leaves no trace.
    """
    return _find_band(cloth, settings) is not None


def find_waist_line(cloth: TrunkCurvature, settings: WaistSeamSettings = WaistSeamSettings()) -> WaistLine | None:
    """Find the plane of the cloth's curved line; None where there is none (`has_curved_waist`).

    Of all planes near the line's bands, the one with most negative curvature, vertices at a height h off it weighted by
    exp(-(h / line_std)^2 / 2). It may slope between front and back, and is level across.
    """
    band = _find_band(cloth, settings)
    if band is None:
        return None
    counted, above = _select_vertices(cloth, settings)
    above, forwards = above[counted], cloth.points[counted, 2]
    middle, curvature = float(np.median(forwards)), cloth.curvature[counted]
    size = settings.band_height
    heights = size * (band - settings.bands // 2) + np.arange(-size, 3.0 * size, settings.height_step)
    tilts = np.arange(-settings.max_tilt, settings.max_tilt + settings.tilt_step / 2, settings.tilt_step)

    def found_at(height: float, tilt: float) -> float:
        off = above - height - tilt * (forwards - middle)
        return -float(curvature @ np.exp(-0.5 * (off / settings.line_std) ** 2))

    height, tilt = max(((h, t) for h in heights for t in tilts), key=lambda place: found_at(*place))
    normal = cloth.axes[1] - tilt * cloth.axes[2]
    offset = cloth.origin @ normal + cloth.measures.waist_height + height - tilt * middle
    length = float(np.linalg.norm(normal))
    sideways = cloth.axes[0]
    reach = settings.half_width * cloth.measures.waist
    return WaistLine(normal / length, float(offset) / length, sideways, float(cloth.origin @ sideways), reach)


def _find_band(cloth: TrunkCurvature, settings: WaistSeamSettings) -> int | None:
    """Return the lower of the line's two bands, counted from below; None where there is no line."""
    counted, above = _select_vertices(cloth, settings)
    band = np.floor(above / settings.band_height).astype(np.int64) + settings.bands // 2
    counted &= (band >= 0) & (band < settings.bands)
    bands = np.bincount(band[counted], weights=cloth.curvature[counted], minlength=settings.bands)
    lines = bands[:-1] + bands[1:]
    at = int(np.argmin(lines[1:-1])) + 1  # not at the ends of the bands
    is_strong = -lines[at] > settings.curvature and -lines[at] > settings.curvature_share * np.abs(bands).sum()
    return at if is_strong else None


def _select_vertices(cloth: TrunkCurvature, settings: WaistSeamSettings) -> tuple[np.ndarray, np.ndarray]:
    """Return which vertices are in front or behind, within the bands' reach, and all heights above the waist."""
    above = cloth.points[:, 1] - cloth.measures.waist_height
    counted = np.abs(cloth.points[:, 0]) < settings.half_width * cloth.measures.waist
    return counted & (np.abs(above) < settings.band_height * (settings.bands // 2)), above
