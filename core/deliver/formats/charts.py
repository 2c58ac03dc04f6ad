"""Charts of sizes by name, from published sizes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from .registry import TABLE_UNITS
from .size_lines import SizeLine


@dataclass(frozen=True)
class Chart:
    """Describe a chart: one line for users, the source of its numbers, and its sizes."""

    title: str
    source: str
    lines: tuple[SizeLine, ...]


BUST_GIRTHS_CM = (80, 84, 88, 92, 96, 100, 104, 110, 116, 122)
"""Bust girths of women's sizes by EN 13402-3 [cm]: 4 cm apart, from 104 on 6 cm."""

WAIST_GIRTHS_CM = (64, 68, 72, 76, 80, 84, 88, 94, 100, 106)
"""Waist girths of these sizes [cm]."""

HIP_GIRTHS_CM = (88, 92, 96, 100, 104, 108, 112, 118, 124, 132)
"""Hip girths of these sizes [cm]."""

NECK_GIRTHS_CM = (35, 36, 37, 38, 39, 40, 41, 42, 43, 44)
"""Neck girths of these sizes [cm]."""

SHOULDER_LENGTHS_CM = (11.75, 12.0, 12.25, 12.5, 12.75, 13.0, 13.25, 13.6, 13.9, 14.2)
"""Lengths of a shoulder of these sizes [cm]."""

WOMEN_SOURCE = (
    "W. Aldrich, Metric Pattern Cutting for Women's Wear, 6th edition, women of medium height, sizes by EN 13402-3"
)
"""Where the women's sizes are published."""


MEN_SOURCE = (
    "GOST 17521-72, typical figures of men, first group of fullness, 176 cm tall: the measures of size 50 and their "
    "steps for 4 cm of chest, as published in Seamly2D's table gost_man_ru"
)
"""Where the men's sizes are published."""

MEN_SIZES: Mapping[str, tuple[float, float]] = MappingProxyType({
    "bust": (100.0, 4.0), "waist": (78.0, 4.0), "hip": (96.4, 2.4), "neck": (40.4, 0.8), "shoulder": (16.0, 0.1),
    "upper_arm": (31.6, 1.2), "wrist": (18.0, 0.4), "armhole_depth": (20.8, 0.3), "arm_length": (59.4, 0.3),
    "back_length": (43.8, 0.2), "rise": (26.0, 0.1),
})  # fmt: skip
"""Measures of men's size 50 and their steps from size to size [cm]; hips without the abdomen, the armhole's depth from
the nape to the level of the armpits, and the rise at the side of a sitting man."""

MEN_STEPS = range(-3, 5)
"""Sizes 44 to 58, in steps from size 50; a size is half the chest's girth [cm]."""


def _make_men() -> tuple[SizeLine, ...]:
    def measure(step: int) -> dict[str, float]:
        return {name: round(value + step * more, 1) for name, (value, more) in MEN_SIZES.items()}

    return tuple(SizeLine(f"{50 + 2 * step}", height=176.0, **measure(step)) for step in MEN_STEPS)


def _make_women(names: tuple[str, ...], height: float | None) -> tuple[SizeLine, ...]:
    columns = zip(
        names, BUST_GIRTHS_CM, WAIST_GIRTHS_CM, HIP_GIRTHS_CM, NECK_GIRTHS_CM, SHOULDER_LENGTHS_CM, strict=True
    )
    return tuple(
        SizeLine(name, bust, waist, hip, height, neck=neck, shoulder=shoulder)
        for name, bust, waist, hip, neck, shoulder in columns
    )


def _make_misses() -> tuple[SizeLine, ...]:
    inch = TABLE_UNITS["inch"]
    columns = zip(
        ("6", "8", "10", "12", "14", "16", "18", "20"),
        (30.5, 31.5, 32.5, 34.0, 36.0, 38.0, 40.0, 42.0),
        (23.0, 24.0, 25.0, 26.5, 28.0, 30.0, 32.0, 34.0),
        (32.5, 33.5, 34.5, 36.0, 38.0, 40.0, 42.0, 44.0),
        (15.5, 15.75, 16.0, 16.25, 16.5, 16.75, 17.0, 17.25),
        strict=True,
    )
    return tuple(
        SizeLine(name, inch * bust, inch * waist, inch * hip, back_length=inch * back)
        for name, bust, waist, hip, back in columns
    )


PUBLISHED_CHARTS: Mapping[str, Chart] = MappingProxyType({
    "uk-women": Chart(
        "British women's sizes 6 to 24", WOMEN_SOURCE,
        _make_women(("6", "8", "10", "12", "14", "16", "18", "20", "22", "24"), None),
    ),
    "de-women": Chart(
        "German women's sizes 34 to 52, 168 cm tall", f"{WOMEN_SOURCE}; numbers and height of German women's sizes",
        _make_women(("34", "36", "38", "40", "42", "44", "46", "48", "50", "52"), 168.0),
    ),
    "us-misses": Chart(
        "misses' sizes 6 to 20 of paper patterns", "Measurement Standard Committee of the pattern industry, 1968",
        _make_misses(),
    ),
    "ru-men": Chart("men's sizes 44 to 58, half the chest, 176 cm tall", MEN_SOURCE, _make_men()),
})  # fmt: skip
"""The charts by name."""


def find_chart(name: str | None) -> tuple[SizeLine, ...]:
    """Return the sizes of a chart; none where no chart has that name."""
    return PUBLISHED_CHARTS[name].lines if name is not None and name in PUBLISHED_CHARTS else ()
