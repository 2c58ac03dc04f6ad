"""Draft a garment from its parts."""

from __future__ import annotations

from dataclasses import replace

from ..division import divide_edges
from ..measures import BodyMeasures
from ..outline import sew_by_label
from ..pattern import Panel, Pattern
from .cut import (
    Bodice,
    Collar,
    Cuff,
    Cut,
    HemBand,
    Legs,
    Neckline,
    PartsConflict,
    Shaping,
    Skirt,
    Sleeve,
    SleeveHead,
    SleevePieces,
    Waist,
    Waistband,
    Yoke,
)
from .fronts import check_front
from .gathers import check_gathers
from .hoods import check_hood
from .legs import draw_legs, draw_suit, draw_suit_legs
from .ribs import sew_hem_rib
from .skirts import CIRCLE_SKIRT_ANGLES, draw_skirt
from .tops import draw_shoulder, draw_top
from .turned_collars import check_turned_collar
from .vents import check_vent, open_vents
from .wraps import check_wrap


def draft_cut(cut: Cut, measures: BodyMeasures | None = None, name: str | None = None) -> Pattern:
    """Draft the pattern of a cut.

    Args:
        cut: The parts.
        measures: Of the wearer; None: those of the built-in female body of 1.70 m.
        name: Of the pattern; None: its category.

    Raises:
        PartsConflict: where two parts cannot be sewn to each other; the message names them.
    """
    m, category = measures or BodyMeasures(), cut.category
    if cut.waistband is not Waistband.NONE and cut.bodice is not Bodice.NONE:
        raise PartsConflict("a band finishes the waist of a skirt or legs; choose waistband=none.")
    if cut.hem_band is not HemBand.NONE and not cut.has_place_for("hem_band"):
        raise PartsConflict("a hem's band finishes a top; choose a bodice without skirt and legs, or hem_band=none.")
    if cut.legs is not Legs.NONE and (cut.shaping in (Shaping.DARTS, Shaping.PRINCESS) or cut.yoke is not Yoke.NONE):
        raise PartsConflict("legs are drafted without darts and yokes; choose shaping=none and yoke=none.")
    check_gathers(cut)
    if cut.yoke is Yoke.HIP and (
        cut.skirt is Skirt.NONE or (cut.bodice is not Bodice.NONE and cut.waist is Waist.NONE)
    ):
        raise PartsConflict("a hip yoke is a skirt's; choose a skirt, below a bodice with waist=seam.")
    if cut.cuff is not Cuff.NONE and cut.sleeve in (Sleeve.NONE, Sleeve.CAP):
        raise PartsConflict("a cuff needs a sleeve that goes round the arm; choose sleeve=short, elbow or long.")
    if cut.cuff is Cuff.SHIRT and cut.sleeve is not Sleeve.LONG:
        raise PartsConflict("a shirt's cuff is buttoned at the wrist; choose sleeve=long, or cuff=band.")
    if cut.bodice is Bodice.STRAPLESS:
        if cut.sleeve is not Sleeve.NONE or cut.collar is not Collar.NONE or cut.yoke.faces:
            raise PartsConflict("a strapless bodice has no shoulders; choose sleeve=none, collar=none and yoke=none.")
        if cut.legs is not Legs.NONE:
            raise PartsConflict("legs are not drafted in one with a strapless bodice; choose another bodice.")
    if cut.bodice is Bodice.HALTER:
        if cut.sleeve is not Sleeve.NONE or cut.yoke.faces:
            raise PartsConflict("a halter leaves the shoulders bare; choose sleeve=none and yoke=none.")
        if Neckline.BOAT in (cut.neckline, cut.back_neckline):
            raise PartsConflict("a boat neck ends at the shoulders, which a halter has not; choose another neckline.")
        if cut.shaping is Shaping.PRINCESS:
            raise PartsConflict("a princess seam begins at the shoulder seam, of which a halter has too little.")
    if cut.sleeve_pieces is SleevePieces.TWO:
        if cut.sleeve is not Sleeve.LONG or cut.sleeve_head is not SleeveHead.SET_IN or cut.cuff is not Cuff.NONE:
            raise PartsConflict(
                "a sleeve of two pieces is long, set in and without a cuff: sleeve=long,sleeve_head=set-in."
            )
        if cut.yoke.faces:
            raise PartsConflict("a yoke and a sleeve of two pieces would cut one armhole in three; leave one out.")
    if cut.bodice is Bodice.NONE and (cut.collar is not Collar.NONE or cut.sleeve_head is not SleeveHead.FLAT):
        raise PartsConflict("a collar and a sleeve's head need a bodice; choose one, or leave them out.")
    check_front(cut)
    check_turned_collar(cut)
    check_hood(cut)
    check_vent(cut)
    check_wrap(cut)
    if cut.waist is Waist.SEAM and not cut.has_place_for("waist"):
        raise PartsConflict("a waist seam joins a bodice and a skirt or legs; choose both, or waist=none.")
    if cut.bodice is Bodice.NONE:
        panels = draw_skirt(cut, m) if cut.legs is Legs.NONE else draw_legs(cut, m)
    else:
        in_one = cut.legs is not Legs.NONE and cut.waist is Waist.NONE
        panels = draw_suit(cut, m) if in_one else draw_top(cut, m)
    panels = open_vents(cut, panels)
    if cut.waist is Waist.SEAM:
        kind, draw = ("skirt", draw_skirt) if cut.legs is Legs.NONE else ("leg", draw_suit_legs)
        panels += [_rename_lower_part(panel, kind) for panel in open_vents(cut, draw(cut, m))]
    if cut.hem_band is HemBand.RIB:
        panels = sew_hem_rib(cut, panels, m.nape_height)
    pattern = sew_by_label(name or category, category, panels)
    return _divide(pattern, cut) if category == "skirt" else pattern


def _rename_lower_part(panel: Panel, kind: str) -> Panel:
    """Return a skirt's or a leg's panel with names of panel and seams that differ from those of the bodice above."""
    edges = tuple(
        replace(edge, label=f"{kind}.{edge.label}") if edge.label and not edge.label.startswith("waist.") else edge
        for edge in panel.edges
    )
    return replace(panel, name=f"{kind}_{panel.name}", label=kind, edges=edges)


def half_neck_width(cut: Cut, measures: BodyMeasures | None = None) -> float:
    """Return the distance of a bodice's side neck points from the middle plane [m]."""
    return draw_shoulder(cut, measures or BodyMeasures()).neck[0]


def _divide(pattern: Pattern, cut: Cut) -> Pattern:
    """Return a pattern with more control points on waist and hem of a skirt without a band, so that grading can open it
    to a circle."""
    if cut.waistband is not Waistband.NONE or cut.skirt in CIRCLE_SKIRT_ANGLES or cut.has_equal_gores:
        return pattern
    if cut.panels == 4:
        return divide_edges(pattern, {"hem"}, 2)
    return divide_edges(divide_edges(pattern, {"hem"}, 4), {"waist"}, 2)
