"""The cuts of the shipped templates."""

from __future__ import annotations

from .cut import Bodice, Cut, Legs, Neckline, Skirt, Sleeve, Waistband

CUTS: dict[str, Cut] = {
    "tshirt": Cut(Bodice.BOXY, sleeve=Sleeve.SHORT),
    "long_sleeve_tshirt": Cut(Bodice.BOXY, sleeve=Sleeve.LONG),
    "tank": Cut(Bodice.SKIMMING, Neckline.SCOOP, Neckline.SCOOP),
    "dress": Cut(Bodice.SHIFT, skirt=Skirt.A_LINE, neck_depth=0.11, back_depth=0.04),
    "sleeved_dress": Cut(Bodice.SHIFT, sleeve=Sleeve.ELBOW, skirt=Skirt.A_LINE),
    "trousers": Cut(legs=Legs.STRAIGHT),
    "shorts": Cut(legs=Legs.SHORT),
    "skirt": Cut(skirt=Skirt.A_LINE),
    "four_panel_skirt": Cut(skirt=Skirt.A_LINE, panels=4),
    "pencil_skirt": Cut(skirt=Skirt.PENCIL, waistband=Waistband.BAND),
    "jumpsuit": Cut(Bodice.SHIFT, legs=Legs.STRAIGHT, neck_depth=0.12, back_depth=0.04),
    "sleeved_jumpsuit": Cut(Bodice.SHIFT, sleeve=Sleeve.ELBOW, legs=Legs.STRAIGHT),
}
"""The cut of each shipped template by its name."""
