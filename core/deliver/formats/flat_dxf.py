"""Write pieces as one flat drawing in DXF (R12) for lasers and drawing programs: no blocks, a layer for each tool."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ...garment.pieces.piece import PieceSet
from .drawing import Layer, Line, keep_ascii
from .sheet import Sheet, arrange_pieces

FLAT_SHEET_WIDTH = 1.4
"""Width of the drawing [m]: that of usual cloth."""

TOOL_COLOURS: Mapping[str, int] = MappingProxyType({"CUT": 1, "SEW": 5, "MARK": 3, "TEXT": 7})
"""Layers by what is done there, each with its colour of AutoCAD's index: red is cut, blue is not, green is engraved."""


def flat_text(sizes: list[tuple[str, PieceSet]]) -> str:
    """Return the DXF file of some sizes' pieces in millimetres, y up. Lines that are cut are on the layer `CUT`, sew
    lines on `SEW`, notches, grainlines, darts and folds on `MARK`, texts on `TEXT`; of several sizes the layers end in
    `_SIZE`, and the pieces of all lie upon each other at the places of the first.

    Args:
        sizes: Name and pieces of each size; an empty name for a single one.
    """
    base = arrange_pieces(sizes[0][1], FLAT_SHEET_WIDTH)
    drawn = [(name, base if n == 0 else _lay_on(pieces, base)) for n, (name, pieces) in enumerate(sizes)]
    layers = [(_name_layer(tool, name), colour) for name, _ in drawn for tool, colour in TOOL_COLOURS.items()]
    out = _groups((0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1009"), (0, "ENDSEC"))
    out += _groups((0, "SECTION"), (2, "TABLES"), (0, "TABLE"), (2, "LAYER"), (70, len(layers)))
    for layer, colour in layers:
        out += _groups((0, "LAYER"), (2, layer), (70, 0), (62, colour), (6, "CONTINUOUS"))
    out += _groups((0, "ENDTAB"), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"))
    for name, sheet in drawn:
        out += _draw(sheet, name)
    return "".join(out + _groups((0, "ENDSEC"), (0, "EOF")))


def _lay_on(pieces: PieceSet, base: Sheet) -> Sheet:
    """Return another size's pieces at the places of the base's."""
    sheet = arrange_pieces(pieces, FLAT_SHEET_WIDTH)
    moves = base.shifts - sheet.shifts
    lines = tuple(
        tuple(Line(line.layer, line.points + move, line.closed) for line in drawn)
        for drawn, move in zip(sheet.lines, moves, strict=True)
    )
    return Sheet(pieces, base.shifts, base.size, lines, tuple(() for _ in lines))


def _name_layer(tool: str, size: str) -> str:
    return f"{tool}_{size}" if size else tool


def _draw(sheet: Sheet, size: str) -> list[str]:
    out: list[str] = []
    for lines, texts in zip(sheet.lines, sheet.texts, strict=True):
        for line in lines:
            tool = {Layer.CUT: "CUT", Layer.SEW: "SEW"}.get(line.layer, "MARK")
            out += _polyline(_name_layer(tool, size), line.points, line.closed)
        for text in texts:
            layer = _name_layer("TEXT", size)
            x, y = text.centre[0] - text.width / 2.0, text.centre[1]
            out += _groups((0, "TEXT"), (8, layer), (10, _number(x)), (20, _number(y)), (40, _number(text.size)))
            out += _groups((1, keep_ascii(text.text)))
    return out


def _polyline(layer: str, points: np.ndarray, is_closed: bool) -> list[str]:
    out = _groups((0, "POLYLINE"), (8, layer), (66, 1), (70, int(is_closed)))
    for x, y in points:
        out += _groups((0, "VERTEX"), (8, layer), (10, _number(x)), (20, _number(y)))
    return out + _groups((0, "SEQEND"), (8, layer))


def _number(metres: float) -> str:
    value = f"{1e3 * metres:.3f}"
    return value.removeprefix("-") if float(value) == 0.0 else value


def _groups(*pairs: tuple[int, object]) -> list[str]:
    return [f"{code:>3}\r\n{value}\r\n" for code, value in pairs]
