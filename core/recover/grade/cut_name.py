"""Name the cut of a recovered pattern: grading changes proportions, and a pencil skirt may become A-line."""

from __future__ import annotations

from collections.abc import Collection

from ...body.body import Body
from ...garment.parts.cut import PARTS, Cut
from ...garment.parts.part_words import differing_parts
from ...garment.parts.shipped_cuts import CUTS
from ...garment.pattern import Pattern
from ...garment.templates import find_cut, name_cut
from ..drape.sizing import measure_wearer
from .cut_search import GirthSettings, fit_cut, has_other_seams, other_cuts, profile_flat, rank_fits

PROPORTION_PARTS = ("skirt", "legs")
"""Parts whose choices differ only in widths, if they are sewn alike."""


def name_recovered(pattern: Pattern, template: str, body: Body, fixed: Collection[str] = ()) -> str:
    """Return the name of the cut of a pattern graded from a library template.

    It stays the template's unless the girths of another cut, sewn alike but with another line of skirt or legs, are
    clearly nearer: if its misfit, including that of the right cut, is below `rival_share` of the template's.

    Args:
        pattern: The recovered pattern.
        template: Name of the base pattern that it was graded from.
        body: The wearer, to whose measures the cuts are drafted.
        fixed: Parts that the user chose, which stay.
    """
    base_cut, settings = find_cut(template), GirthSettings(shape_share=GirthSettings.rival_share)
    kept = (set(PARTS) - set(PROPORTION_PARTS)) | set(fixed)
    alike = [cut for cut in other_cuts(base_cut, kept) if not has_other_seams(cut, base_cut)]
    seen = profile_flat(pattern, settings) if len(alike) > 1 else None
    if seen is None:
        return template
    measures = measure_wearer(body)
    fits = [fit for cut in alike if (fit := fit_cut(template, cut, seen, measures, settings)) is not None]
    ranked = rank_fits(fits, base_cut, settings)
    return template if not ranked or ranked[0].cut == base_cut else _name(ranked[0].cut)


def describe_cut_change(cut: str, template: str) -> tuple[str, ...]:
    """Return a note on a cut that is not its template's, or nothing."""
    return () if cut == template else (f"Graded from '{template}' the pattern has the girths of '{cut}'.",)


def _name(cut: Cut) -> str:
    """Return the shortest name of a cut, after the template that shares most of its parts."""
    stems = (stem for stem, one in CUTS.items() if one.category == cut.category)
    return name_cut(min(stems, key=lambda stem: len(differing_parts(CUTS[stem], cut))), cut)
