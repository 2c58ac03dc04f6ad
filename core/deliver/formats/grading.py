"""Grade a pattern: every size moves control points by what the draft of the base pattern changes."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from ...garment.measure_change import move_by_drafts, scale_panels
from ...garment.measures import BodyMeasures
from ...garment.pattern import Pattern
from ...garment.templates import TemplateUnknown, draft_template
from .errors import SizesBad
from .options import ExportOptions, SizeLine

SHOULDER_GROWTH_RATIO = 1.0 / 16.0
"""Ratio of the growth of half the shoulders' width to that of the bust: 2.5 mm for a step of 4 cm."""

NECK_GROWTH_RATIO = 1.0 / 40.0
"""Ratio of the growth of half the neck's width to that of the bust: 1 mm for a step of 4 cm."""

MAX_SIZE_NAME_LENGTH = 8
"""Largest length of a size's name [letters]; with the piece's it is a block's name, in R12 of at most 31."""

HEIGHTS = ("nape_height", "armpit_height", "waist_height", "hip_height", "crotch_height")


@dataclass(frozen=True)
class Size:
    """Describe one size.

    Attributes:
        name: Upper case letters and digits, unique.
        measures: Measures of its wearer.
        pattern: The graded pattern, both sides of its seams equal.
        is_base: Whether it is the recovered size.
        is_drafted: Whether it is graded by a draft; else the pattern was scaled.
    """

    name: str
    measures: BodyMeasures
    pattern: Pattern
    is_base: bool
    is_drafted: bool


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
    """
    requested = [(line.name, table_measures(base, height, line)) for line in options.sizes]
    if not requested:
        steps = range(options.first, options.last + 1)
        grown = [step_measures(base, step * options.step / 100.0) for step in steps]
        requested = list(zip(_name_steps(grown, options), grown, strict=True))
    named = [(_normalise_size_name(name), measures) for name, measures in requested]
    if not any(measures == base for _, measures in named):
        named.append(("BASE", base))
    if len({name for name, _ in named}) < len(named) or not all(name for name, _ in named):
        raise SizesBad("two sizes have one name, or one has none; name them by letters and digits, at most 8.")
    sizes = [Size(name, one, *_grade(pattern, template, base, one)) for name, one in named]
    return sorted(sizes, key=lambda size: (size.measures.bust, size.measures.hip, size.name))


def step_measures(base: BodyMeasures, growth: float) -> BodyMeasures:
    """Return measures whose girths are larger by a growth [m]; shoulders and neck follow."""
    if growth == 0.0:
        return base
    return replace(
        base,
        bust=base.bust + growth,
        waist=base.waist + growth,
        hip=base.hip + growth,
        shoulder_half_width=base.shoulder_half_width + SHOULDER_GROWTH_RATIO * growth,
        neck_half_width=base.neck_half_width + NECK_GROWTH_RATIO * growth,
    )


def table_measures(base: BodyMeasures, height: float, line: SizeLine) -> BodyMeasures:
    """Return the measures of a line of a table; missing ones are the wearer's, and heights scale with the height."""
    girths = {name: getattr(line, name) for name in ("bust", "waist", "hip")}
    lengths = {name: value / 100.0 for name, value in girths.items() if value is not None}
    grown = step_measures(base, lengths.get("bust", base.bust) - base.bust)
    ratio = 1.0 if line.height is None else line.height / 100.0 / height
    heights = {name: ratio * getattr(base, name) for name in HEIGHTS}
    return replace(grown, **{"waist": base.waist, "hip": base.hip, **lengths, **heights})


def _name_steps(grown: list[BodyMeasures], options: ExportOptions) -> list[str]:
    names = [f"B{100.0 * measures.bust:.0f}" for measures in grown]
    if len(set(names)) == len(names):
        return names
    return [f"{'M' if step < 0 else 'P'}{abs(step)}" for step in range(options.first, options.last + 1)]


def _normalise_size_name(name: str) -> str:
    return re.sub(r"[^A-Z0-9]", "", name.upper())[:MAX_SIZE_NAME_LENGTH]


def _grade(pattern: Pattern, template: str, base: BodyMeasures, other: BodyMeasures) -> tuple[Pattern, bool, bool]:
    """Return the pattern for other measures, whether it is the base, and whether it is graded by a draft."""
    if other == base:
        return pattern, True, True
    try:
        old, new = (draft_template(template, measures) for measures in (base, other))
    except TemplateUnknown:
        return _scale(pattern, base, other), False, False
    moved = move_by_drafts(pattern, old, new)
    return (_scale(pattern, base, other), False, False) if moved is None else (moved, False, True)


def _scale(pattern: Pattern, base: BodyMeasures, other: BodyMeasures) -> Pattern:
    """Return the pattern scaled across by the mean ratio of girths, along by that of the nape's heights."""
    across = float(np.mean([getattr(other, name) / getattr(base, name) for name in ("bust", "waist", "hip")]))
    return scale_panels(pattern, across, other.nape_height / base.nape_height)
