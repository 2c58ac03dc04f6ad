"""Draw the sizes of pieces upon each other, a layer for each size, its name on each of its lines."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from ...garment.pieces.flatten import flatten_outline
from ...garment.pieces.piece import Piece, PieceSet
from .drawing import draw_lines, keep_latin, list_texts
from .pdf_file import show_text
from .text_places import label_piece

SIZE_TEXT_HEIGHT_MM = 3.0
"""Height of a size's name on its line [mm]."""

FIRST_NAME_SHARE, NAME_SHARE_STEP = 0.06, 0.035
"""Fractions of a cut line's length at which the first size has its name, and from one size's to the next's: the names
of nested lines lie beside each other."""

NAMES_PER_LINE = 3
"""Number of a size's names on one cut line, so that one is on most sheets of a tiled print."""


def name_layer(size: str) -> str:
    """Return the name of a size's layer."""
    return f"size {size}"


def draw_size_layers(names: Sequence[str], pieces: list[PieceSet], shifts: np.ndarray, pens: Sequence[str]) -> str:
    """Return the operators of all sizes' cut and sew lines for a PDF page, each size in the layer of its number.

    Args:
        names: Of the sizes.
        pieces: Of each size, alike in number.
        shifts: Translation of each piece to the page [mm], shape [n, 2].
        pens: Operators of width and dashes of each size.
    """
    parts = []
    for k, (name, one) in enumerate(zip(names, pieces, strict=True)):
        parts.append(f"/OC /S{k} BDC\n")
        for piece, shift in zip(one.cut_pieces, shifts, strict=True):
            parts.append(f"{pens[k]} {_pdf_path(1e3 * piece.cut.points + shift)}\n")
            if any(edge.width for edge in piece.edges):
                sew = 1e3 * flatten_outline(piece.net)[0] + shift
                parts.append(f"0.5 G 0.15 w [1 1] 0 d {_pdf_path(sew)}\n0 G\n")
            for x, y in _place_names(piece, k):
                parts.append(show_text(1e3 * x + shift[0] + 0.8, 1e3 * y + shift[1] + 0.8, SIZE_TEXT_HEIGHT_MM, name))
        parts.append("EMC\n")
    return "".join(parts)


def _pdf_path(points: np.ndarray) -> str:
    pairs = [f"{x:.3f} {y:.3f}" for x, y in points]
    return f"{pairs[0]} m " + " ".join(f"{pair} l" for pair in pairs[1:]) + " s"


def _place_names(piece: Piece, number: int) -> np.ndarray:
    """Return the places of a size's name on a piece's cut line [m], shape [n, 2]."""
    points = np.concatenate([piece.cut.points, piece.cut.points[:1]])
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    shares = (FIRST_NAME_SHARE + NAME_SHARE_STEP * number + np.arange(NAMES_PER_LINE) / NAMES_PER_LINE) % 1.0
    return np.stack([np.interp(shares * lengths[-1], lengths, points[:, axis]) for axis in (0, 1)], axis=1)


def nest_svg(names: Sequence[str], pieces: list[PieceSet], base: int, shifts: np.ndarray, size: np.ndarray) -> str:
    """Return the SVG text of all sizes' pieces at 1:1, 1 user unit is 1 mm: a layer for each size with cut line, sew
    line and name, and one with the base's notches, grainlines and texts.

    Args:
        names: Of the sizes.
        pieces: Of each size, alike in number.
        base: Index of the base size.
        shifts: Translation of each piece to the sheet [m], shape [n, 2].
        size: Width and height of the sheet [m], shape [2].
    """
    width, height = (1e3 * float(value) for value in size)

    def path(kind: str, points: np.ndarray, closed: bool) -> str:
        pairs = " L ".join(f"{1e3 * x:.4f} {height - 1e3 * y:.4f}" for x, y in points)
        return f'<path class="{kind}" d="M {pairs}{" Z" if closed else ""}"/>'

    def text(x: float, y: float, size: float, words: str) -> str:
        return f'<text x="{1e3 * x:.2f}" y="{height - 1e3 * y:.2f}" font-size="{size:g}">{escape(words)}</text>'

    layers = []
    for k, (name, one) in enumerate(zip(names, pieces, strict=True)):
        parts = []
        for piece, shift in zip(one.cut_pieces, shifts, strict=True):
            parts.append(path("cut", piece.cut.points + shift, True))
            parts.append(path("sew", flatten_outline(piece.net)[0] + shift, True))
            parts += [text(x, y, SIZE_TEXT_HEIGHT_MM, name) for x, y in _place_names(piece, k) + shift]
        layers.append(_svg_layer(name_layer(name), parts))
    marks = []
    for n, (piece, shift) in enumerate(zip(pieces[base].cut_pieces, shifts, strict=True)):
        lines = [line for line in draw_lines(piece) if line.layer not in ("cut", "sew")]
        marks += [path("mark", line.points + shift, line.closed) for line in lines]
        for one_text in label_piece(piece, list_texts(pieces[base], n)):
            x, y = one_text.centre + shift - [one_text.width / 2.0, 0.0]
            marks.append(text(x, y, 1e3 * one_text.size, one_text.text))
    layers.append(_svg_layer("marks", marks))
    style = "path { fill: none; stroke: #000; stroke-width: 0.3; } .sew { stroke: #1f5fa8; stroke-dasharray: 3 1.5; } "
    style += "text { font-family: sans-serif; }"
    spaces = 'xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
    box = f'width="{width:.3f}mm" height="{height:.3f}mm" viewBox="0 0 {width:.3f} {height:.3f}"'
    title = escape(keep_latin(pieces[base].name))
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<svg {spaces} {box}>\n<title>{title}: sizes</title>\n'
        f"<style>{style}</style>\n" + "\n".join(layers) + "\n</svg>\n"
    )


def _svg_layer(name: str, parts: list[str]) -> str:
    ident = escape(name.replace(" ", "-"), quote=True)
    return (
        f'<g id="{ident}" inkscape:groupmode="layer" inkscape:label="{escape(name, quote=True)}">\n'
        + "\n".join(parts)
        + "\n</g>"
    )
