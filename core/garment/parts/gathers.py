"""Gather a bodice into a waist seam, or legs into a waistband (H. Joseph-Armstrong, Patternmaking for Fashion Design,
blouson and gathered waistline): a bodice is cut wider and longer than the waist it is sewn to, so that it falls over
the seam; legs are cut straight up from the hips."""

from __future__ import annotations

from .cut import Bodice, Cut, Legs, PartsConflict, Shaping, Skirt, Waist, Waistband, Yoke

BODICE_GATHER_RATIO = 1.4
"""Ratio of the length of a bodice's lower edge to that of the waist seam it is gathered into: that of a side seam which
falls nearly straight from the armhole."""

BLOUSON_OVERHANG = 0.03
"""Length of a gathered bodice below the natural waist [m], which falls over the seam: 2.5 to 5 cm."""

LEG_GATHER_RATIO = 1.5
"""Ratio of the waist of legs to the band they are gathered into: that of hips with their ease to the waist, and a
medium fullness."""


def check_gathers(cut: Cut) -> None:
    """Check that a cut has an edge of another piece that its waist can be gathered into.

    Raises:
        PartsConflict: where it has none, or that one is gathered itself.
    """
    if cut.shaping is not Shaping.GATHERS:
        return
    if cut.bodice is not Bodice.NONE:
        if cut.waist is Waist.NONE:
            raise PartsConflict("a bodice is gathered into a waist seam; add a skirt or legs and waist=seam.")
        if cut.skirt in (Skirt.GATHERED, Skirt.TIERED) and cut.yoke is not Yoke.HIP:
            raise PartsConflict("of a bodice and a skirt one is gathered into the other; choose another skirt.")
    elif cut.legs is Legs.NONE:
        raise PartsConflict("a skirt that is gathered is a part of its own; choose skirt=gathered and shaping=none.")
    elif cut.legs is Legs.LEGGINGS or cut.waistband is not Waistband.BAND:
        raise PartsConflict("legs are gathered into a band; choose waistband=band, and other legs than leggings.")
