"""Choose the base pattern for a target: the template, and the parts in which the scan shows another cut."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ...body.body import Body
from ...garment.curves import flat_contours
from ...garment.neckline_fit import NecklineFit, NecklineFits, fit_necklines
from ...garment.parts.cut import Collar, Cut, Front, Hood, Neckline, Skirt, Waist
from ...garment.parts.draft import draft_cut, half_neck_width
from ...garment.parts.shipped_cuts import CUTS
from ...garment.parts.wraps import check_wrap
from ...garment.pattern import Pattern
from ...garment.templates import list_templates, load_template, name_cut
from ...run.errors import BadInput
from ...run.finding import Finding, FindingKind
from ...scan.contours.slits import find_slits
from ...scan.contours.target import Target
from ..drape.sizing import oversize_measures
from .cut_search import GirthSettings, search_cuts
from .hem_gores import HemGores, find_gores
from .lap import find_lap
from .neck_finish import NeckFinish, ShownSides, rank_finishes
from .neck_shape import NeckShape
from .openings import Opening, find_openings, open_slits
from .sleeve_length import fit_sleeve
from .trunk_curvature import TrunkCurvature
from .waist_seam import has_curved_waist, sew_waist
from .wrap_choice import add_wrap, draw_wrapped_necklines, unwrap

STAND_IN_CATEGORIES = {"long_sleeve_tshirt": "tshirt", "shorts": "trousers"}
"""Categories whose templates replace those of a category without its own: grading changes lengths, but adds no seam."""


MAX_NAMED_CUT_COUNT = 3
"""Largest number of cuts in a result, the chosen one among them."""


@dataclass(frozen=True)
class Candidate:
    """Describe one cut that was compared with a scan.

    Attributes:
        template: Name by which it is drafted.
        misfit: Root sum of squares of `girths` (if None, that of contour lengths), `neckline` and `collar`.
        girths: Deviation of its girths along the garment; None where the scan does not show its girths.
        neckline: Distance between its necklines and the scan's; None where it has none to compare.
        collar: Misfit of its collar and front, a standard deviation counted as the girths' of the right cut; None where
            the scan does not show its neck.
        collar_probability: That the scan's neck has that collar or hood, or none; None likewise.
    """

    template: str
    misfit: float
    girths: float | None = None
    neckline: float | None = None
    collar: float | None = None
    collar_probability: float | None = None

    def describe(self) -> Finding:
        """Return the cut as a finding, with the parts of its misfit."""
        parts = {"misfit": self.misfit, "girths": self.girths, "neckline": self.neckline, "collar": self.collar}
        parts["collar_probability"] = self.collar_probability
        known = {name: float(np.round(value, 4)) for name, value in parts.items() if value is not None}
        return Finding(FindingKind.CUT, value=self.misfit, evidence={"template": self.template} | known)


@dataclass(frozen=True)
class Choice:
    """Describe the base pattern that was chosen for a target.

    Attributes:
        template: Its name.
        pattern: Drafted with the parts and measures that the scan shows.
        candidates: The best cuts, the chosen one first; empty where the user named it.
        notes: Notes to the user, one sentence each.
        openings: Of the garment, beside its contours.
    """

    template: str
    pattern: Pattern
    candidates: tuple[Candidate, ...] = ()
    notes: tuple[str, ...] = ()
    openings: tuple[Opening, ...] = ()


class TemplateMissing(BadInput):
    """No template fits this garment; name one with --template NAME or give a pattern file."""

    code = "template.none_fits"


def choose_cut(
    target: Target, body: Body, parts: Mapping[str, str] | None = None, sides: ShownSides = ShownSides.BOTH
) -> Choice:
    """Choose template and parts for a target by its contours.

    The template is that of `rank_templates`, with the collar and front (`rank_finishes`), the sleeves and the girths
    that the scan shows; the next likely collars on it are candidates. A garment with a neck and without a collar
    then gets the necklines, in front and behind, nearest to the scan's (`fit_necklines`): the shipped ones where they
    agree or differ in depth only, else ones drafted with the scan's ratio of depth to width. Grading corrects depths
    but makes no corner, so a V has to be drafted. A wearer too large for the library's size gets a draft.

    Args:
        target: The target.
        body: The wearer.
        parts: Choices of parts that the user fixed, by part. Parts that garments of the target's category do not have
            are noted and left out: each of a person's garments takes those that apply to it.
        sides: The sides of the cloth that the scan shows.

    Raises:
        TemplateMissing: where there is no template for the category.
        PartUnknown, PartsConflict: where the user's parts do not exist, or cannot be sewn to each other.
    """
    choices, fits, gores = dict(parts or {}), fit_necklines(target, body), find_gores(target)
    templates, found = rank_templates(target, list(CUTS)), dict[str, tuple[int, Candidate, Cut]]()
    shape, slits = NeckShape.of(target, body), find_slits(target, body)
    usual_cut, lap = CUTS[templates[0][0]], find_lap(target, body, sides)
    if choices.get("front") == Front.WRAP:
        check_wrap(usual_cut.choose({"neckline": Neckline.V.value} | choices))
    finishes = () if shape is None else rank_finishes(shape, usual_cut, choices, sides)
    finishes = add_wrap(finishes, lap, fits, usual_cut, choices)
    ranked = _rank_cuts(target, body, choices, templates, gores, unwrap(finishes[:1]))
    pairs = [*product(ranked, finishes[:1] or (None,)), *product(ranked[:1], finishes[1:MAX_NAMED_CUT_COUNT])]
    for one, finish in pairs:
        finished = open_slits(_finish(one.cut, finish), slits, choices)
        for named, line in _with_necklines(finished, fits, choices):
            name, unlike, likely = name_cut(one.template, named), None, None
            if finish is not None:
                unlike, likely = finish.misfit * GirthSettings.misfit_floor, finish.probability
            misfit = math.hypot(one.misfit, line or 0.0, unlike or 0.0)
            candidate = Candidate(name, misfit, one.girths, line, unlike, likely)
            found.setdefault(name, (one.missing, candidate, named))
    (_, chosen, cut), *others = found.values()
    others.sort(key=lambda each: (each[0], each[1].misfit))
    name, candidates = chosen.template, (chosen, *(candidate for _, candidate, _ in others))[:MAX_NAMED_CUT_COUNT]
    notes = list(describe_absent(cut, choices))
    if gores is not None and cut.skirt is not Skirt.NONE and not gores.is_cut(cut):
        notes.append(gores.describe(cut))
    measures = oversize_measures(body)
    usual = cut == CUTS.get(name) and measures is None
    pattern = load_template(name) if usual else draft_cut(cut, measures, name)
    return Choice(name, pattern, candidates, tuple(notes), find_openings(target, shape, finishes, slits, lap))


def describe_absent(cut: Cut, parts: Mapping[str, str]) -> tuple[str, ...]:
    """Return a note for each choice of a part that garments of a cut's kind do not have."""
    absent = [part for part in parts if not cut.has_place_for(part)]
    return tuple(f"A {cut.category} has no {part}; '{part}={parts[part]}' was left out." for part in absent)


@dataclass(frozen=True)
class _RankedCut:
    """Describe a cut without its necklines: number of unmatched contours, misfit, and misfit by girths if any."""

    template: str
    cut: Cut
    missing: int
    misfit: float
    girths: float | None = None


def _finish(cut: Cut, finish: NeckFinish | None) -> Cut:
    """Return a cut with a collar and a front, where it has a place for them."""
    return finish.apply(cut) if finish is not None and cut.has_place_for("collar") else cut


def _rank_cuts(
    target: Target,
    body: Body,
    chosen: Mapping[str, str],
    templates: Sequence[tuple[str, int, float]],
    gores: HemGores | None,
    finishes: Sequence[NeckFinish],
) -> list[_RankedCut]:
    """Rank the cuts without their necklines, with the first of some finishes if any; the chosen one first.

    Templates by their contours (`rank_templates`), with the sleeves that reach as far as the scan's (`fit_sleeve`);
    among those with the fewest unmatched contours every cut by its girths (`search_cuts`), where the scan shows them. A
    dress or jumpsuit whose cloth is curved across the waist has a seam there (`has_curved_waist`), which girths do not
    show. Gores that the user chose flare as the scan's hem shows.
    """
    ranked = []
    curved = CUTS[templates[0][0]].has_place_for("waist") and has_curved_waist(TrunkCurvature.of(target, body))
    for template, missing, misfit in templates:
        fixed = {part: word for part, word in chosen.items() if CUTS[template].has_place_for(part)}
        cut = CUTS[template].choose(fixed)
        cut = cut if gores is None else gores.flare(cut)
        cut = sew_waist(cut, chosen) if curved else cut
        cut = _finish(cut, finishes[0] if finishes else None)
        if cut.front is Front.OPEN and "waist" not in fixed:
            cut = replace(cut, waist=Waist.NONE)
        ranked.append(
            _RankedCut(template, cut if "sleeve" in fixed else fit_sleeve(target, body, cut), missing, misfit)
        )
    least = ranked[0].missing
    fitting = [(one.template, one.cut) for one in ranked if one.missing == least]
    fits = search_cuts(target, body, fitting, chosen, curved=curved)
    if not fits:
        return ranked
    rest = [one for one in ranked if one.missing > least]
    return [_RankedCut(fit.template, fit.cut, least, fit.misfit, fit.misfit) for fit in fits] + rest


def rank_templates(target: Target, names: Sequence[str]) -> list[tuple[str, int, float]]:
    """Rank the templates of the target's category, best first.

    First by open contours: no grading makes a cuff out of an armhole. Then by how near their shape is to the target's
    (`contour_misfit`), so that least has to be graded. The first in the library's order wins a tie.

    Args:
        target: The target; its category was chosen from its contours and the bones they encircle.
        names: Names of the available templates.

    Returns:
        For each template its name, the number of contours that only one of both has, and the root of `contour_misfit`.

    Raises:
        TemplateMissing: where there is none for the category.
    """
    infos = [info for info in list_templates() if info.name in names]
    fitting = [info.name for info in infos if info.category == target.category]
    fitting = fitting or [info.name for info in infos if info.category == STAND_IN_CATEGORIES.get(target.category)]
    if not fitting:
        raise TemplateMissing(
            f"no template fits the category '{target.category}'; name one of {', '.join(names)} with --template."
        )
    lengths = {contour.name: contour.length for contour in target.contours if contour.trusted}
    contour_names = {contour.name for contour in target.contours}
    measured = [flat_contours(load_template(name)) for name in fitting]
    costs = [(len(contour_names ^ set(flat)), contour_misfit(lengths, flat)) for flat in measured]
    order = sorted(range(len(fitting)), key=lambda i: costs[i])
    return [(fitting[i], costs[i][0], math.sqrt(costs[i][1])) for i in order]


def _with_necklines(
    cut: Cut, fits: NecklineFits | None, fixed: Mapping[str, str]
) -> Iterator[tuple[Cut, float | None]]:
    """Yield a cut with the necklines that fit a contour, the best pair first, each with the pair's misfit.

    The user's choices stay; without a misfit where the scan cannot have them. Of a garment with a collar the neck
    contour is the collar's edge, and its neckline is round. A crew neck and a scoop are one line in
    two depths; the cut's own stays for both. The pattern differs from the scan in size, so a neckline takes the scan's
    ratio of depth to half width. A V is cut straight: the apparent bow of its line is that of the shoulder, which no
    cylinder unrolls.
    """
    if fits is None or not cut.has_place_for("neckline") or _hides_neckline(cut):
        yield cut, None
        return
    if cut.front is Front.WRAP:
        fits = draw_wrapped_necklines(fits)
    fronts, backs = (
        _allowed_fits(ranked, part in fixed, getattr(cut, part))
        for part, ranked in (("neckline", fits.front), ("back_neckline", fits.back))
    )
    for front, back in product(fronts, backs):
        yield (
            _with_throat(_with_throat(cut, front, "neckline"), back, "back_neckline"),
            None if front is None or back is None else math.hypot(front.misfit, back.misfit),
        )


def _hides_neckline(cut: Cut) -> bool:
    """Check whether a cut's neckline is sewn to a collar or a hood, so that the neck contour is another edge."""
    return cut.collar is not Collar.NONE or cut.hood is not Hood.NONE


def _allowed_fits(ranked: tuple[NecklineFit, ...], fixed: bool, neckline: Neckline) -> tuple[NecklineFit | None, ...]:
    """Return the candidate fits: all, or only the fixed neckline's, None where it is not among them."""
    if not fixed:
        return ranked
    return tuple(fit for fit in ranked if _is_same_line(fit.neckline.kind, neckline)) or (None,)


def _with_throat(cut: Cut, fit: NecklineFit | None, part: str) -> Cut:
    """Return a cut whose front or back has the neckline of a fit, in proportion to the cut's own width; of the same
    line grading finds the depth, but not of a wrap's."""
    is_graded = part != "neckline" or cut.front is not Front.WRAP
    if fit is None or (is_graded and _is_same_line(fit.neckline.kind, getattr(cut, part))):
        return cut
    kind = fit.neckline.kind
    changed = cut.choose({part: str(kind)})
    depth = half_neck_width(changed) * fit.neckline.depth / fit.half_width
    return replace(changed, neck_depth=depth) if part == "neckline" else replace(changed, back_depth=depth)


def _is_same_line(one: Neckline, other: Neckline) -> bool:
    """Check whether two necklines are the same line in two depths, which grading can change into each other."""
    return one is other or {one, other} == {Neckline.CREW, Neckline.SCOOP}


def contour_misfit(target: dict[str, float], template: dict[str, float]) -> float:
    """Compute the difference in shape of two garments' contours, the variance of ln(target length / template length).

    A common factor, the size, does not count; flare and taper remain. Only contours that both have are compared.
    """
    shared = sorted(set(target) & set(template))
    ratios = [math.log(target[name] / template[name]) for name in shared]
    if len(ratios) < 2:
        return 0.0
    mean = sum(ratios) / len(ratios)
    return sum((ratio - mean) ** 2 for ratio in ratios) / len(ratios)
