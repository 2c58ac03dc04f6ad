"""The cut of a garment: one choice for each of its parts, and measures that differ from a part's defaults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from ...run.errors import BadInput


class PartUnknown(BadInput):
    """A part or a choice of it is not one there is; `garmentq templates list --parts` shows them."""

    code = "part.unknown"


class PartsConflict(BadInput):
    """Two parts of a cut cannot be sewn to each other, or a cut has no place for one."""

    code = "part.conflict"


class Bodice(StrEnum):
    """Describe the trunk's cover: by its girths, from wide to close, and with bare shoulders."""

    NONE = "none"
    BOXY = "boxy"
    SHIFT = "shift"
    SKIMMING = "skimming"
    HALTER = "halter"
    STRAPLESS = "strapless"


class Neckline(StrEnum):
    """Describe the line of a neck opening between the two side neck points, in front or behind."""

    CREW = "crew"
    SCOOP = "scoop"
    V = "v"
    SQUARE = "square"
    BOAT = "boat"


class Sleeve(StrEnum):
    """Describe a sleeve by its length."""

    NONE = "none"
    CAP = "cap"
    SHORT = "short"
    ELBOW = "elbow"
    LONG = "long"


class SleeveHead(StrEnum):
    """Describe how the upper end of a sleeve meets the bodice."""

    FLAT = "flat"
    SET_IN = "set-in"
    RAGLAN = "raglan"
    DROPPED = "dropped"


class SleevePieces(StrEnum):
    """Describe the number of pieces of a sleeve."""

    ONE = "one"
    TWO = "two"


class Cuff(StrEnum):
    """Describe the finish of a sleeve; a shirt's is a band that is buttoned below a slit."""

    NONE = "none"
    BAND = "band"
    SHIRT = "shirt"
    RIB = "rib"


class HemBand(StrEnum):
    """Describe the finish of a top's hem."""

    NONE = "none"
    RIB = "rib"


class Vent(StrEnum):
    """Describe where a slit opens the hem of a skirt or a top."""

    NONE = "none"
    BACK = "back"
    SIDES = "sides"


class Shaping(StrEnum):
    """Describe what takes in the waist, beside the side seams."""

    NONE = "none"
    DARTS = "darts"
    PRINCESS = "princess"
    GATHERS = "gathers"


class Yoke(StrEnum):
    """Describe a piece of its own above the rest of a part: across the shoulders, or around the hips."""

    NONE = "none"
    BACK = "back"
    FRONT = "front"
    SHOULDERS = "shoulders"
    HIP = "hip"

    @property
    def faces(self) -> tuple[str, ...]:
        """Return the faces of a bodice that it divides, `front` and `back`; none for a hip yoke."""
        return ("front", "back") if self is Yoke.SHOULDERS else (str(self),) if self in (Yoke.FRONT, Yoke.BACK) else ()


class Collar(StrEnum):
    """Describe what is sewn to a neckline."""

    NONE = "none"
    STAND = "stand"
    RIB = "rib"
    TURTLENECK = "turtleneck"
    SHIRT = "shirt"
    CONVERTIBLE = "convertible"
    POLO = "polo"
    NOTCHED = "notched"
    SHAWL = "shawl"


class Hood(StrEnum):
    """Describe a hood by its number of pieces: two sides, or two sides and a strip between them."""

    NONE = "none"
    TWO = "two"
    THREE = "three"


class HoodWorn(StrEnum):
    """Describe how a hood is worn: on the head, or down on the back, as on most scans."""

    DOWN = "down"
    UP = "up"


class Front(StrEnum):
    """Describe how the front of a bodice is cut at its centre: in one piece, with a slit from the neck (a placket),
    closed over its whole length by a zip or by buttons, worn open, or as two fronts of which one is wrapped over the
    other."""

    NONE = "none"
    PLACKET = "placket"
    ZIP = "zip"
    BUTTONS = "buttons"
    OPEN = "open"
    WRAP = "wrap"


class Skirt(StrEnum):
    """Describe a skirt by the shape of its panels."""

    NONE = "none"
    STRAIGHT = "straight"
    PENCIL = "pencil"
    A_LINE = "a-line"
    GORED = "gored"
    HALF_CIRCLE = "half-circle"
    FULL_CIRCLE = "full-circle"
    GATHERED = "gathered"
    TIERED = "tiered"
    PLEATED = "pleated"


class Gores(StrEnum):
    """Describe the number of gores of a gored skirt all around, half of them in front."""

    FOUR = "4"
    SIX = "6"
    EIGHT = "8"
    TEN = "10"
    TWELVE = "12"


class Legs(StrEnum):
    """Describe legs by the line of their seams from the thigh down."""

    NONE = "none"
    STRAIGHT = "straight"
    TAPERED = "tapered"
    FLARED = "flared"
    WIDE = "wide"
    SHORT = "short"
    LEGGINGS = "leggings"


class Waist(StrEnum):
    """Describe how a bodice and the part below it meet at the natural waist."""

    NONE = "none"
    SEAM = "seam"


class Waistband(StrEnum):
    """Describe the finish of a waist."""

    NONE = "none"
    BAND = "band"
    ELASTIC = "elastic"


@dataclass(frozen=True)
class Cut:
    """Describe the cut of a garment; `parts.draft_cut` drafts it.

    Attributes:
        bodice: The trunk above the waist.
        neckline, back_neckline: Of the front and of the back.
        skirt: Below the waist.
        panels: Panels of a skirt all around, 2 or 4; see `panels_around`.
        sweep: Whole angle of a gored skirt's gores laid side by side [rad]; None: the usual one.
        legs: Below the waist instead of a skirt.
        waistband: Of a skirt or legs without a bodice.
        hem_band: Of a bodice without skirt and legs.
        vent: In the hem of a skirt or of a top.
        waist: Whether a bodice and its skirt or legs are cut in one piece or sewn to each other.
        sleeve_head: How each sleeve meets the bodice.
        shaping: Of bodice and skirt at the waist, or of legs that are gathered into a band.
        yoke: Across the back of a bodice, its front or both, or around the hips above a skirt.
        front: How the bodice's front is cut at its centre.
        hood: On a crew neck.
        hood_worn: Where the hood's pieces are placed before the first drape; it does not change the pieces.
        neck_depth, back_depth: Of a neckline below the side neck point [m]; None: the neckline's usual depth. The front
            edges of a wrap cross where they do.
    """

    bodice: Bodice = Bodice.NONE
    neckline: Neckline = Neckline.CREW
    back_neckline: Neckline = Neckline.CREW
    sleeve: Sleeve = Sleeve.NONE
    skirt: Skirt = Skirt.NONE
    panels: int = 2
    legs: Legs = Legs.NONE
    waistband: Waistband = Waistband.NONE
    neck_depth: float | None = None
    back_depth: float | None = None
    waist: Waist = Waist.NONE
    sleeve_head: SleeveHead = SleeveHead.FLAT
    shaping: Shaping = Shaping.NONE
    yoke: Yoke = Yoke.NONE
    collar: Collar = Collar.NONE
    cuff: Cuff = Cuff.NONE
    sleeve_pieces: SleevePieces = SleevePieces.ONE
    gores: Gores = Gores.SIX
    sweep: float | None = None
    front: Front = Front.NONE
    hem_band: HemBand = HemBand.NONE
    hood: Hood = Hood.NONE
    hood_worn: HoodWorn = HoodWorn.DOWN
    vent: Vent = Vent.NONE

    @property
    def panels_around(self) -> int:
        """Return the number of a skirt's panels all around, gores counted."""
        return int(self.gores) if self.skirt is Skirt.GORED else self.panels

    @property
    def has_equal_gores(self) -> bool:
        """Check whether a skirt's gores are all alike; six usually are a centre and two side gores on each face."""
        return self.skirt is Skirt.GORED and (self.gores is not Gores.SIX or self.sweep is not None)

    @property
    def is_shaped_by_seams(self) -> bool:
        """Check whether darts or princess seams divide the waist."""
        return self.shaping in (Shaping.DARTS, Shaping.PRINCESS)

    @property
    def category(self) -> str:
        """Return the category of a garment of this cut: one of `target.CATEGORIES`.

        Raises:
            PartsConflict: where the parts make no garment.
        """
        if self.bodice is Bodice.NONE:
            if self.sleeve is not Sleeve.NONE:
                raise PartsConflict("a sleeve needs a bodice; choose one, or sleeve=none.")
            if (self.skirt is Skirt.NONE) == (self.legs is Legs.NONE):
                raise PartsConflict("a cut without a bodice is a skirt or legs; choose one of them.")
            if self.skirt is not Skirt.NONE:
                return "skirt"
            return "shorts" if self.legs is Legs.SHORT else "trousers"
        if self.legs is not Legs.NONE:
            if self.skirt is not Skirt.NONE:
                raise PartsConflict("legs and a skirt cannot be cut in one; leave out one of them.")
            return "jumpsuit"
        if self.skirt is not Skirt.NONE:
            return "dress"
        if self.sleeve is Sleeve.NONE:
            return "tank"
        return "long_sleeve_tshirt" if self.sleeve is Sleeve.LONG else "tshirt"

    def choose(self, parts: dict[str, str]) -> Cut:
        """Return the cut with other choices for some of its parts; the settings of a former choice are dropped.

        Args:
            parts: Names of choices by names of parts: `{"neckline": "v"}`.

        Raises:
            PartUnknown: where there is no such part, or no such choice of it.
        """
        chosen: dict[str, Any] = {part: _choice(part, word) for part, word in parts.items()}
        dropped: dict[str, Any] = {}
        for part, choice in chosen.items():
            dropped |= _RESET_FIELDS.get(part, {}) if choice != getattr(self, part) else {}
        return replace(self, **{**dropped, **chosen})

    def has_place_for(self, part: str) -> bool:
        """Check whether a garment of the cut's kind can have another choice of a part: trousers have no neckline."""
        if part in ("neckline", "back_neckline"):
            return self.bodice not in (Bodice.NONE, Bodice.STRAPLESS)
        if part in ("sleeve", "sleeve_head", "sleeve_pieces", "collar", "cuff", "front", "hood"):
            return self.bodice is not Bodice.NONE
        if part == "hood_worn":
            return self.hood is not Hood.NONE
        if part == "waist":
            return self.bodice is not Bodice.NONE and (self.skirt is not Skirt.NONE or self.legs is not Legs.NONE)
        if part == "waistband":
            return self.bodice is Bodice.NONE
        if part == "hem_band":
            return self.bodice is not Bodice.NONE and self.skirt is Skirt.NONE and self.legs is Legs.NONE
        if part == "vent":
            return self.legs is Legs.NONE
        if part == "shaping":
            return self.legs is Legs.NONE or self.bodice is Bodice.NONE or self.waist is Waist.SEAM
        if part == "gores":
            return self.skirt is not Skirt.NONE
        if part == "yoke":
            return self.bodice is not Bodice.NONE or self.skirt is not Skirt.NONE
        return part not in PARTS or str(getattr(self, part)) != "none"

    def check_places(self, parts: Mapping[str, str]) -> None:
        """Check that a garment of the cut's kind has a place for each choice of a part but the usual ones.

        Raises:
            PartsConflict: where it has none; the message lists the parts that it has.
        """
        for part, word in parts.items():
            if not self.has_place_for(part) and word != str(getattr(Cut(), part)):
                places = ", ".join(other for other in PARTS if self.has_place_for(other))
                raise PartsConflict(f"'{part}={word}' has no place in a cut of {self.category}; choose {places}.")


PARTS: dict[str, type[StrEnum]] = {
    "bodice": Bodice,
    "neckline": Neckline,
    "back_neckline": Neckline,
    "sleeve": Sleeve,
    "skirt": Skirt,
    "legs": Legs,
    "waistband": Waistband,
    "waist": Waist,
    "sleeve_head": SleeveHead,
    "shaping": Shaping,
    "yoke": Yoke,
    "collar": Collar,
    "cuff": Cuff,
    "sleeve_pieces": SleevePieces,
    "gores": Gores,
    "front": Front,
    "hem_band": HemBand,
    "hood": Hood,
    "hood_worn": HoodWorn,
    "vent": Vent,
}
"""The parts of a cut by name, each with its choices."""

_RESET_FIELDS: dict[str, dict[str, Any]] = {
    "neckline": {"neck_depth": None},
    "back_neckline": {"back_depth": None},
    "skirt": {"gores": Gores.SIX, "sweep": None},
}
"""Settings that belong to a part's former choice."""


def _choice(part: str, word: str) -> StrEnum:
    if part not in PARTS:
        raise PartUnknown(f"'{part[:40]}' is no part of a cut; name one of {', '.join(PARTS)}.")
    try:
        return PARTS[part](word)
    except ValueError:
        raise PartUnknown(f"{part} '{word[:40]}' is not one of {', '.join(PARTS[part])}.") from None
