"""Pieces of shipped templates, made once for all tests of a process."""

from __future__ import annotations

import functools

import pytest
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.pieces.allowance import read_allowances
from garmentq.core.garment.pieces.make import PieceSettings, Style, make_pieces
from garmentq.core.garment.pieces.piece import PieceSet
from garmentq.core.garment.templates import list_templates, load_template

DAILY = ("tshirt", "sleeved_dress", "trousers", "skirt", "jumpsuit")
"""Templates with every kind of edge, seam and piece that there is; the others are cut from the same parts."""

TEMPLATES = [
    pytest.param(info.name, marks=() if info.name in DAILY else pytest.mark.nightly) for info in list_templates()
]
"""All of them, for a test's parameters; those that are not `DAILY` are left to the nightly run."""

SLIT_CUTS = [
    "long_sleeve_tshirt+sleeve_head=set-in,cuff=shirt,collar=shirt,front=buttons,vent=sides",
    pytest.param("sleeved_dress+skirt=straight,waist=seam,shaping=gathers,vent=back", marks=pytest.mark.nightly),
    "dress+front=wrap,neckline=v",
]
"""Cuts with vents, slits of sleeves, gathers and a wrap front."""


@functools.cache
def pieces_of(name: str, text: str = "", fold: bool = False) -> PieceSet:
    """Make the pieces of a template, with allowances as `--allowance` takes them."""
    style = Style(name, "bust 92 waist 72 hip 100 height 170", "cotton_jersey")
    return make_pieces(load_template(name), PieceSettings(read_allowances(text), fold), style)


def imported(name: str, names: dict[str, str] | None = None) -> Pattern:
    """Return a template as a stranger's file gives it: without labels and this program's notes."""
    document = write_pattern(load_template(name))
    del document["properties"]["garmentq"]
    body = document["pattern"]
    for panel in body["panels"].values():
        panel.pop("label", None)
        for edge in panel["edges"]:
            edge.pop("label", None)
    body.pop("panel_order", None)
    if names:
        body["panels"] = {names.get(key, key): value for key, value in body["panels"].items()}
        for stitch in body["stitches"]:
            for side in stitch:
                side["panel"] = names.get(side["panel"], side["panel"])
    return read_pattern(document, name)
