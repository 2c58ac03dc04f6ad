"""Grade a pattern to the sizes of an export: by steps, by a table, or by a chart of that name."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

import numpy as np

from ...garment.measures import BodyMeasures
from ...garment.parts.cut import PartsConflict, PartUnknown
from ...garment.pattern import Pattern
from ...garment.sizes.figures import NECK_SHARE, Figure
from ...garment.sizes.graded import grade_pattern
from ...garment.sizes.growth import Growth
from ...garment.templates import TemplateUnknown, draft_template
from .errors import SizesBad, SizesUnclear
from .options import ExportOptions
from .size_lines import GIRTHS, SizeLine

MAX_SIZE_NAME_LENGTH = 8
"""Largest length of a size's name [letters]; with the piece's it is a block's name, in R12 of at most 31."""

MIN_GRADED_RATIO, MAX_GRADED_RATIO = 0.7, 1.45
"""Smallest and largest usual ratio of a size's girth to the wearer's [1]: both ends of a range from XS to 4XL about its
middle; a size further away is a misprint, or needs a fit of its own."""

HEIGHTS = ("nape_height", "armpit_height", "waist_height", "hip_height", "crotch_height")
"""Heights of a wearer that follow the stature."""


@dataclass(frozen=True)
class Size:
    """Describe one size.

    Attributes:
        name: Upper case letters and digits, unique.
        measures: Measures of its wearer.
        pattern: The graded pattern, both sides of its seams equal.
        is_base: Whether it is the recovered size.
        is_drafted: Whether a draft says what no rule of a named point does; else the pattern was spread between them.
        growth: By how much its wearer's measures exceed those of the recovered size's.
        figures: What was graded by rule.
    """

    name: str
    measures: BodyMeasures
    pattern: Pattern
    is_base: bool
    is_drafted: bool
    growth: Growth = field(default_factory=Growth)
    figures: tuple[Figure, ...] = ()


def grade_sizes(
    pattern: Pattern, template: str, base: BodyMeasures, height: float, options: ExportOptions
) -> list[Size]:
    """Return the sizes of the options, with the recovered one among them, by increasing bust.

    Args:
        pattern: The recovered pattern, for a wearer of the measures `base`.
        template: Name of its base pattern.
        base: The wearer's measures.
        height: The wearer's height [m].
        options: Step and range, or a table.

    Raises:
        SizesBad: where two sizes have one name.
        SizesUnclear: where a size of a table is far from the wearer's.
        CapUnfit: where no sleeve fits a size's armhole.
    """
    lines = options.size_lines
    chosen = [line for line in lines if not options.chosen or line.name in options.chosen]
    if not options.is_sure:
        _check_against_wearer(chosen, base)
    requested = [(line.name, table_growth(base, height, line, lines)) for line in chosen]
    if not requested:
        steps = range(options.first, options.last + 1)
        grown = [step_growth(step * options.step / 100.0) for step in steps]
        requested = list(zip(_name_steps(base, grown, options), grown, strict=True))
    named = [(_normalise_size_name(name), growth) for name, growth in requested]
    if not any(growth.is_zero for _, growth in named):
        named.append(("BASE", Growth()))
    if len({name for name, _ in named}) < len(named) or not all(name for name, _ in named):
        raise SizesBad("two sizes have one name, or one has none; name them by letters and digits, at most 8.")
    sizes = [_grade(name, pattern, template, base, height, growth) for name, growth in named]
    return sorted(sizes, key=lambda size: (size.measures.bust, size.measures.hip, size.name))


def step_growth(growth: float) -> Growth:
    """Return the growth of a step in bust, waist and hips [m]; other measures follow."""
    return Growth.follow(growth, growth, growth)


def table_growth(base: BodyMeasures, height: float, line: SizeLine, lines: tuple[SizeLine, ...]) -> Growth:
    """Return the growth of a line of a table over the wearer.

    Girths of the trunk and the height are those of the size's wearer; missing ones are the wearer's own. Of other
    measures a table says by how much its sizes differ: the wearer's value is interpolated at her bust.

    Args:
        base: The wearer's measures.
        height: The wearer's height [m].
        line: One of the lines.
        lines: All lines of the table.
    """
    trunk = {name: getattr(line, name) for name in GIRTHS}
    more = {name: 0.0 if value is None else value / 100.0 - getattr(base, name) for name, value in trunk.items()}
    known = {}
    for name in SizeLine.more_names():
        rows = sorted((one.bust, getattr(one, name)) for one in lines if one.bust is not None and getattr(one, name))
        value = getattr(line, name)
        if value is not None and len(rows) > 1:
            known[name] = (value - _interpolate(rows, 100.0 * base.bust)) / 100.0
    stature = 1.0 if line.height is None else line.height / 100.0 / height
    return Growth.follow(more["bust"], more["waist"], more["hip"], stature, known)


def wearer_measures(base: BodyMeasures, growth: Growth) -> BodyMeasures:
    """Return the measures of a size's wearer; her heights follow the stature."""
    heights = {name: growth.stature * getattr(base, name) for name in HEIGHTS}
    girths = {name: getattr(base, name) + getattr(growth, name) for name in GIRTHS}
    neck = NECK_SHARE * growth.neck
    return replace(
        base,
        **girths,
        **heights,
        shoulder_half_width=base.shoulder_half_width + neck + growth.shoulder,
        neck_half_width=base.neck_half_width + neck,
    )


def draft_measures(base: BodyMeasures, growth: Growth) -> BodyMeasures:
    """Return the measures from which the base pattern of a size is drafted.

    Its heights give the lengths of the growth, upwards from the crotch: they are those of a garment laid flat, and of
    a body only as far as the stature changes.
    """
    if growth.is_zero:
        return base
    tall, wearer = growth.stature, wearer_measures(base, growth)
    waist = wearer.waist_height + growth.rise
    nape = wearer.nape_height + growth.rise + growth.back_length
    return replace(
        wearer,
        nape_height=nape,
        armpit_height=nape - tall * (base.nape_height - base.armpit_height) - growth.armhole_depth,
        waist_height=waist,
        hip_height=waist - tall * (base.waist_height - base.hip_height) - growth.hip_depth,
    )


def _check_against_wearer(lines: list[SizeLine], base: BodyMeasures) -> None:
    """Check that the sizes of a table are near the wearer's.

    Raises:
        SizesUnclear: where one is not; the message has both readings.
    """
    for line in lines:
        for name in GIRTHS:
            value, own = getattr(line, name), 100.0 * float(getattr(base, name))
            if value is not None and not MIN_GRADED_RATIO <= value / own <= MAX_GRADED_RATIO:
                raise SizesUnclear(
                    f"size '{line.name}' has a {name} of {value:.4g} cm, the wearer of the pattern {own:.4g} cm: too "
                    f"far for one fit. Choose sizes with --size, say the unit with --unit, or confirm with --sure "
                    f"(is_sure)."
                )


def _interpolate(rows: list[tuple[float, float]], at: float) -> float:
    """Return a table's value at some place, beyond its ends along the last difference."""
    x, y = np.array(rows).T
    k = int(np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2))
    return float(y[k] + (at - x[k]) * (y[k + 1] - y[k]) / (x[k + 1] - x[k]))


def _name_steps(base: BodyMeasures, grown: list[Growth], options: ExportOptions) -> list[str]:
    names = [f"B{100.0 * (base.bust + growth.bust):.0f}" for growth in grown]
    if len(set(names)) == len(names):
        return names
    return [f"{'M' if step < 0 else 'P'}{abs(step)}" for step in range(options.first, options.last + 1)]


def _normalise_size_name(name: str) -> str:
    return re.sub(r"[^A-Z0-9]", "", name.upper())[:MAX_SIZE_NAME_LENGTH]


def _grade(name: str, pattern: Pattern, template: str, base: BodyMeasures, height: float, growth: Growth) -> Size:
    """Return one size."""
    drafts = None
    if not growth.is_zero:
        try:
            drafts = (draft_template(template, base), draft_template(template, draft_measures(base, growth)))
        except (TemplateUnknown, PartUnknown, PartsConflict):
            drafts = None
    graded = grade_pattern(pattern, base, height, growth, drafts)
    return Size(
        name, wearer_measures(base, growth), graded.pattern, growth.is_zero, graded.is_drafted, growth, graded.figures
    )
