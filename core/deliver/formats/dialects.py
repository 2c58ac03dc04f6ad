"""The dialects of DXF that programs for cutting pieces read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

SLIT_NOTCH_LAYER, CHECK_NOTCH_LAYER = 4, 82
"""Numbers of the layers of slit notches and of check notches (ASTM D6673)."""


class OutlineClosing(StrEnum):
    """Describe how a closed outline ends."""

    FLAG = "flag"
    REPEATED = "repeated"


@dataclass(frozen=True)
class Dialect:
    """Describe the dialect of one reader.

    Attributes:
        name: One of `DIALECTS`.
        version: Text of the style's version.
        rule_version: First line of a rule table.
        acad: `$ACADVER` of the header, or empty for an empty header.
        is_inch: Whether lengths are inches to 4 decimals; else millimetres to 3.
        grain_along_x: Whether the warp runs along x.
        closing: How an outline is closed.
        sew_layer: Layer of the sew line.
        text_layer: Layer of the piece's texts.
        notch_layer: Layer of notches.
        notch_is_line: Whether a notch is a line; else it is a point.
        marks_points: Whether turn and curve points are on layers 2 and 3.
        is_flat: Whether lines are drawn without blocks, on layers that are named by what is done there.
        has_validation: Whether the outline is repeated on layer 84 for comparison, with its tolerance.
        name_key, size_key: Keys of a piece's name and size.
        separator: Between the numbers of a rule table.
    """

    name: str
    version: str = "ANSI/AAMA-292-1993"
    rule_version: str = "ANSI/AAMA-292-B"
    acad: str = ""
    is_inch: bool = False
    grain_along_x: bool = False
    closing: OutlineClosing = OutlineClosing.FLAG
    sew_layer: int = 14
    text_layer: int = 1
    notch_layer: int = SLIT_NOTCH_LAYER
    notch_is_line: bool = False
    marks_points: bool = True
    is_flat: bool = False
    has_validation: bool = False
    name_key: str = "PIECE NAME"
    size_key: str = "SIZE"
    separator: str = ","


_ASTM = "ASTM/D13 Proposal 1 Version: D6673-10"
_ASTM_RULES = "ASTM/D13 Proposal 1 Version: D 6673-04"

DIALECTS_BY_NAME: Mapping[str, Dialect] = MappingProxyType({
    one.name: one
    for one in (
        Dialect("aama"),
        Dialect("astm", version=_ASTM, rule_version=_ASTM_RULES, text_layer=15, notch_layer=4, has_validation=True),
        Dialect("clo", acad="AC1006", rule_version=_ASTM_RULES, separator=" "),
        Dialect("gerber", is_inch=True, grain_along_x=True, closing=OutlineClosing.REPEATED, name_key="Piece Name"),
        Dialect("optitex", closing=OutlineClosing.REPEATED),
        Dialect("seamly", sew_layer=8, notch_is_line=True, marks_points=False),
        Dialect("richpeace", closing=OutlineClosing.REPEATED, notch_layer=CHECK_NOTCH_LAYER, name_key="Piece Name",
                size_key="SAMPLE SIZE"),
        Dialect("flat", is_flat=True),
    )
})  # fmt: skip
"""The dialects by name. Most readers accept `aama`; docs/lab/pieces.md lists how the others differ."""
