"""Search the cut whose flat pattern has the scan's girths (skirt, legs, waist and bodice), without a drape."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ...body.body import Body
from ...garment.measures import BodyMeasures
from ...garment.parts.cut import PARTS, Bodice, Cut, Front, Legs, Shaping, Skirt
from ...garment.parts.draft import draft_cut
from ...garment.parts.part_words import differing_parts
from ...garment.pattern import Pattern
from ...garment.sewing import mesh_pattern
from ...run.errors import BadInput
from ...scan.contours.target import Target
from ..drape.sizing import measure_wearer
from .girth_profile import GirthProfile, profile_pattern, profile_target
from .waist_seam import sew_waist

SPECIAL_SEAM_SKIRTS = (Skirt.GATHERED, Skirt.TIERED, Skirt.GORED)
"""Skirts whose seams differ from those of two plain panels."""


@dataclass(frozen=True)
class GirthSettings:
    """Describe how cuts are compared and ranked by their girths.

    Attributes:
        vertices: Number of vertices of a candidate's flat mesh: its girths are within 0.1 to 0.5 % of those of 1500.
        stations: Number of places along the garment at which two profiles are compared.
        start_margin: Distance below the sleeves at which the comparison begins [m]: above, level lines run into them.
        end_margin: Distance above the lower end at which it ends [m]: hems rest on feet, and cut borders have teeth.
        length_ratios: Ratios of a garment's length to its draft's that are tried: it may be made for another height.
        misfit_floor: Relative difference of girths of the right cut: stretch, cut folds and sizes leave 0.01 to 0.04.
        shape_share: Share of its misfit below which the cut chosen by contours is replaced by one of other proportions.
        seam_share: Share of the same for one that is sewn otherwise, since grading adds no seam. Of 52 drawn cuts none
            then has fewer right parts than by contours; 0.7 for both makes 93 of 110 right, not 84, and one cut worse.
        rival_share: Share of the misfit of the clearly better cut with fewest changes, below which another is taken.
    """

    vertices: int = 400
    stations: int = 40
    start_margin: float = 0.02
    end_margin: float = 0.03
    length_ratios: tuple[float, ...] = tuple(np.linspace(0.90, 1.20, 31).tolist())
    misfit_floor: float = 0.02
    shape_share: float = 0.5
    seam_share: float = 0.6
    rival_share: float = 0.85

    def total(self, fit: CutFit) -> float:
        """Return the misfit of a cut including that of the right one."""
        return float(np.hypot(fit.misfit, self.misfit_floor))


@dataclass(frozen=True)
class CutFit:
    """Describe how well the girths of a cut, named by a template, fit a scan's: `misfit` is the standard deviation
    along the garment of the logarithm of the ratio of both girths, independent of size."""

    template: str
    cut: Cut
    misfit: float


def search_cuts(
    target: Target,
    body: Body,
    templates: Sequence[tuple[str, Cut]],
    fixed: Iterable[str] = (),
    *,
    curved: bool = False,
    settings: GirthSettings = GirthSettings(),
) -> tuple[CutFit, ...]:
    """Rank the cuts that a garment may have by its girths, the chosen one first.

    The first template, chosen by contour lengths, stays unless others have clearly nearer girths (`rank_fits`).

    Args:
        target: The target.
        body: The wearer, to whose measures every candidate is drafted.
        templates: Names and cuts of the templates that have the target's contours, the best by contours first.
        fixed: Parts that the user chose, which stay.
        curved: The cloth is curved across the waist: only cuts with a seam there compete (`sew_waist`).
        settings: Of the search.

    Returns:
        The candidates; none where the scan does not show its girths from end to end.
    """
    seen = profile_target(target)
    if seen is None:
        return ()
    usual, measures = templates[0][1], measure_wearer(body)

    def fit(cuts: Iterable[tuple[str, Cut]]) -> list[CutFit]:
        return [found for name, cut in cuts if (found := fit_cut(name, cut, seen, measures, settings)) is not None]

    fits = fit(templates)
    if fits and settings.seam_share * settings.total(fits[0]) > settings.misfit_floor:  # else none is clearly better
        fits += fit(_variants(templates, set(fixed), curved))
    return rank_fits(fits, usual, replace(settings, shape_share=settings.rival_share) if curved else settings)


def compare_girths(seen: GirthProfile, drawn: GirthProfile, settings: GirthSettings = GirthSettings()) -> float:
    """Return the standard deviation of ln(seen / drawn girth) along the garment.

    Both begin at the waist or below the arms. The drawn garment is lengthened or shortened within `length_ratios` to
    the best fit: its crotch and hips can be lower or higher than its wearer's. One that ends sooner is
    extrapolated; one that ends later is cut off, for grading changes lengths. A common factor is size.
    """
    begin = seen.arms + settings.start_margin
    end = max(float(seen.distances[-1]) - settings.end_margin, begin + settings.end_margin)
    at = np.linspace(begin, end, settings.stations)
    target = np.log(np.interp(at, seen.distances, seen.girths))
    last = len(drawn.distances) // 6
    slope = (drawn.girths[-1] - drawn.girths[-last]) / (drawn.distances[-1] - drawn.distances[-last])
    there = drawn.arms + (at - seen.arms) / np.array(settings.length_ratios)[:, None]
    girths = np.interp(there, drawn.distances, drawn.girths)
    beyond = np.maximum(there - drawn.distances[-1], 0.0)
    girths = np.maximum(girths + slope * beyond, 0.5 * girths)
    return float((target - np.log(girths)).std(axis=1).min())


def rank_fits(fits: Sequence[CutFit], usual: Cut, settings: GirthSettings = GirthSettings()) -> tuple[CutFit, ...]:
    """Return fits by their misfit, the chosen one first; none if the usual cut is not among them.

    The usual cut is chosen unless others are clearly nearer; then, of these, the one with the fewest changes that none
    is much nearer than. `shape_share` is larger where the usual cut is that of contours with a seam that they lack.
    """
    ranked = sorted(fits, key=lambda fit: fit.misfit)
    chosen = next((fit for fit in fits if fit.cut == usual), None)
    if chosen is None:
        return ()
    total = settings.total
    shares = (settings.seam_share if has_other_seams(fit.cut, usual) else settings.shape_share for fit in ranked)
    clear = [fit for fit, share in zip(ranked, shares, strict=True) if total(fit) < share * total(chosen)]
    if clear:
        rivals = [fit for fit in clear if settings.rival_share * total(fit) <= total(clear[0])]
        chosen = min(rivals, key=lambda fit: _count_changes(fit.cut, usual))
    return (chosen, *(fit for fit in ranked if fit is not chosen))


def has_other_seams(cut: Cut, usual: Cut) -> bool:
    """Check whether a cut has seams that another has not: grading can add none."""
    changed = cut.skirt is not usual.skirt and (cut.skirt in SPECIAL_SEAM_SKIRTS or usual.skirt in SPECIAL_SEAM_SKIRTS)
    return changed or (cut.waist, cut.waistband, cut.panels) != (usual.waist, usual.waistband, usual.panels)


def _count_changes(cut: Cut, usual: Cut) -> int:
    """Count the parts in which two cuts differ, and the number of panels: six gores have the girths of four."""
    return len(differing_parts(cut, usual)) + (cut.panels_around != usual.panels_around)


def _variants(templates: Sequence[tuple[str, Cut]], fixed: set[str], curved: bool) -> Iterator[tuple[str, Cut]]:
    """Yield the templates with other parts that girths show, each cut once."""
    met = {_without_neck_depths(cut) for _, cut in templates}
    for template, base_cut in templates:
        for other in other_cuts(base_cut, fixed) if base_cut.panels == 2 else ():
            cut = _at_waist(other, fixed) if curved else other
            if _without_neck_depths(cut) not in met:
                met.add(_without_neck_depths(cut))
                yield template, cut


def _at_waist(cut: Cut, fixed: set[str]) -> Cut:
    """Return a cut sewn at the waist, with the darts of its own skirt."""
    return sew_waist(cut if "shaping" in fixed else replace(cut, shaping=Shaping.NONE), fixed)


def _without_neck_depths(cut: Cut) -> Cut:
    """Return a cut with the necklines' usual depths, which girths do not show."""
    return replace(cut, neck_depth=None, back_depth=None)


def other_cuts(cut: Cut, fixed: set[str]) -> Iterator[Cut]:
    """Yield a cut with every other choice of the parts that show in girths and keep its kind."""
    open_parts = {part: words for part, words in _open_parts(cut).items() if part not in fixed}
    for words in product(*open_parts.values()):
        yield cut.choose(dict(zip(open_parts, words, strict=True)))


def _open_parts(cut: Cut) -> Mapping[str, list[str]]:
    """Return the choices of each part that shows in girths; a bodice's only without skirt or legs. Pleats, leggings and
    elastic waists are left to the user: the girths of cloth that stretches or folds are not those of its pattern."""
    found: dict[str, list[str]] = {}
    if cut.skirt is not Skirt.NONE:
        found["skirt"] = [word for word in PARTS["skirt"] if word not in ("none", "pleated")]
    if cut.legs not in (Legs.NONE, Legs.SHORT):
        found["legs"] = [word for word in PARTS["legs"] if word not in ("none", "short", "leggings")]
    if cut.bodice is not Bodice.NONE and cut.skirt is Skirt.NONE and cut.legs is Legs.NONE:
        found["bodice"] = [word for word in PARTS["bodice"] if word not in ("none", "strapless")]
    for part in ("waist", "waistband"):
        if cut.has_place_for(part):
            found[part] = [word for word in PARTS[part] if word != "elastic"]
    return found


def fit_cut(
    template: str, cut: Cut, seen: GirthProfile, measures: BodyMeasures, settings: GirthSettings
) -> CutFit | None:
    """Return the fit of the girths of a cut drafted to measures; None where it cannot be sewn or meshed. The fronts of
    a wrap lie on each other, and its girths are those of one front."""
    try:
        pattern = draft_cut(replace(cut, front=Front.NONE) if cut.front is Front.WRAP else cut, measures)
    except BadInput:
        return None
    drawn = profile_flat(pattern, settings)
    return None if drawn is None else CutFit(template, cut, compare_girths(seen, drawn, settings))


def profile_flat(pattern: Pattern, settings: GirthSettings) -> GirthProfile | None:
    """Return the girths of a pattern; None without two ends or a mesh that coarse."""
    try:
        garment = mesh_pattern(pattern, settings.vertices, sweeps=0)
    except BadInput:
        return None
    return profile_pattern(garment)
