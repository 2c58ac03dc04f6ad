"""Make a pattern to measure: move it by what its draft changes from one body to another, or by grade rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from types import MappingProxyType

import numpy as np

from ...body.body import Body
from ...body.girths import TapeMeasure
from ...cloth.fabric import Fabric
from ...garment.measure_change import move_by_drafts, scale_panels
from ...garment.pattern import Pattern
from ...garment.sewing import mesh_pattern
from ...garment.sizes.errors import CapUnfit
from ...garment.sizes.graded import grade_pattern
from ...garment.templates import TemplateUnknown
from ...recover.drape.sizing import measure_wearer
from ...run.clock import Clock
from ...run.hooks import SILENT_HOOKS, Hooks
from .body_growth import measure_growth, measure_stature
from .dressing import DressedGarment, dress_body
from .ease import Ease, measure_ease
from .fitting import fit_draft
from .kept_ease import EasePrediction, max_ease_change, preserve_ease
from .widening import widening_rules
from .worn import WornGarment

EASE_CHANGE_TOLERANCE = 5e-3
"""Largest change of the ease at which it counts as kept [m]."""

MAX_DRAFT_EASE_CHANGE = 1e-2
"""Change of the ease beyond which a pattern's form counts as different from its draft's [m]. For the library's own
trousers, which are their draft, the prediction's error is 5.5 mm at the thighs."""

MAX_GIRTH_EDGE_COUNT = 8
"""Largest number of panel edges around a place, front and back in halves. A pattern whose control points are d from its
draft's loses at most 8 d more ease than it. Where a line meets the crotch on one of the bodies the prediction is larger
(148 mm at the thighs of shorts that are 8 mm off) and wrong."""

MIN_GRADED_FIGURE_COUNT = 3
"""Smallest number of figures by which a pattern without a draft is graded: a skirt has its waist, its hips or its hem,
and its length; with fewer, points are missing that rules move."""


class RefitWay(StrEnum):
    """List the ways in which a pattern is made to measure."""

    DRAFT = "draft"
    RULES = "rules"
    SCALE = "scale"


WAY_WARNINGS: Mapping[RefitWay, str] = MappingProxyType({
    RefitWay.RULES: "the pattern is not a shipped template's, so its draft is not known: its named points were moved "
    "by grade rules for the difference of both bodies' measures, and the rest was spread between them.",
    RefitWay.SCALE: "the pattern is not a shipped template's, and too few of its points can be named for grade rules; "
    "its panels were scaled by the ratios of both bodies' girths and heights, which is approximate.",
})  # fmt: skip
"""Warnings of a pattern without a draft."""


@dataclass(frozen=True)
class RefittedPattern:
    """Describe a pattern made to measure, seams equalised, and how: moved by a draft, by grade rules on named points,
    or scaled by ratios of measures."""

    pattern: Pattern
    way: RefitWay


def refit_pattern(worn: WornGarment, body: Body, hooks: Hooks = SILENT_HOOKS) -> RefittedPattern:
    """Return a worn garment's pattern made to the measures of another body.

    Control points move by what the draft changes, p + D(b1) - D(b0) with b0 the wearer, b1 the other body, and D the
    template's draft fitted to a body (`fit_draft`), like grade rules; handles are relative and follow. So a refit there
    and back returns the pattern. Where a pattern's form differs so much from its draft's that more than
    `MAX_DRAFT_EASE_CHANGE` of ease is predicted to be lost beyond the draft's loss, and no more than its form can lose,
    it is widened itself. Seams are equalised. For a body of the wearer's own measures nothing moves.

    A pattern without a draft is graded by its named points (`grade_pattern`); one in which too few can be named, or
    whose sleeves fit no armhole of that size, is scaled.

    Args:
        worn: The garment on its wearer.
        body: The new wearer.
        hooks: Progress and cancellation.

    Raises:
        Cancelled: where the hooks cancel.
    """
    pattern = worn.pattern
    if measure_wearer(worn.body) == measure_wearer(body):
        return RefittedPattern(pattern, RefitWay.DRAFT)
    try:
        old, new = (fit_draft(worn.template, each, hooks) for each in (worn.body, body))
    except TemplateUnknown:
        return _refit_without_draft(worn, body)
    moved = move_by_drafts(pattern, old.pattern, new.pattern)
    if moved is None:
        return _refit_without_draft(worn, body)
    laid, error = EasePrediction.of(worn.garment, worn.body, worn.waist, body), old.predict_ease(new)
    laid = replace(laid, ease={place: ease + error.get(place, 0.0) for place, ease in laid.ease.items()})
    off = float(np.linalg.norm(pattern.points - old.pattern.points, axis=1).max())
    if MAX_DRAFT_EASE_CHANGE < max_ease_change(laid, moved) <= MAX_GIRTH_EDGE_COUNT * off:
        moved = preserve_ease(moved, laid, widening_rules(worn.template))
    return RefittedPattern(moved, RefitWay.DRAFT)


def make_to_measure(worn: WornGarment, body: Body, fabric: Fabric | None, clock: Clock) -> DressedGarment:
    """Make a garment to measure and dress the body in it; warn where the ease is not kept.

    Args:
        worn: The garment of a stored result.
        body: The new wearer.
        fabric: The cloth, or None for the garment's own.
        clock: Times the stages.

    Raises:
        Cancelled: where the clock's hooks cancel.
    """
    with clock.stage("refit", "making the pattern to measure") as hooks:
        found, before = refit_pattern(worn, body, hooks), measure_ease(worn.garment, worn.body)
        made = worn
        if found.pattern is not worn.pattern:
            mesh = mesh_pattern(found.pattern, len(worn.garment.nodes))
            made = replace(worn, garment=mesh)
    dressed = dress_body(made, body, fabric, clock)
    notes = (WAY_WARNINGS[found.way],) if found.way in WAY_WARNINGS else ()
    changes = {one.place: one.value - was for one, was in _pair_ease(dressed.ease, before)}
    deviations = [
        f"{1e3 * change:+.0f} mm at the {place}"
        for place, change in changes.items()
        if abs(change) > EASE_CHANGE_TOLERANCE
    ]
    if deviations:
        notes = (*notes, f"the ease is not the wearer's: {', '.join(deviations)}.".replace("_", " "))
    metrics: dict[str, float | None] = {f"ease_change.{place}_mm": 1e3 * change for place, change in changes.items()}
    told_first = dict.fromkeys((*notes, *dressed.report.warnings))
    report = replace(dressed.report, metrics=dressed.report.metrics | metrics, warnings=tuple(told_first))
    return replace(dressed, before=worn, report=report)


def _pair_ease(now: tuple[Ease, ...], before: tuple[Ease, ...]) -> list[tuple[Ease, float]]:
    """Return what was measured on both bodies, each with the ease on the first [m]."""
    was = {one.place: one.value for one in before}
    return [(one, was[one.place]) for one in now if one.place in was]


def _refit_without_draft(worn: WornGarment, body: Body) -> RefittedPattern:
    """Return a pattern of which no draft is known made to measure: by grade rules, or else scaled."""
    growth, base = measure_growth(worn.body, body), measure_wearer(worn.body)
    try:
        graded = grade_pattern(worn.pattern, base, measure_stature(worn.body), growth)
    except CapUnfit:
        return RefittedPattern(_scale(worn, body), RefitWay.SCALE)
    if len(graded.figures) < MIN_GRADED_FIGURE_COUNT:
        return RefittedPattern(_scale(worn, body), RefitWay.SCALE)
    return RefittedPattern(graded.pattern, RefitWay.RULES)


def _scale(worn: WornGarment, body: Body) -> Pattern:
    """Return the pattern scaled by both bodies' ratios: across by the mean of girths, along by that of heights."""
    tapes = [TapeMeasure.of(one) for one in (worn.body, body)]
    places = [one.place for one in measure_ease(worn.garment, worn.body)] or ["chest", "waist", "hip"]
    across = float(np.mean([tapes[1].measure(place).value / tapes[0].measure(place).value for place in places]))
    tall = [float(np.ptp(tape.body.vertices[:, 1])) for tape in tapes]
    return scale_panels(worn.pattern, across, tall[1] / tall[0])
