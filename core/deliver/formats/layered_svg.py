"""Write pieces as SVG at 1:1, on layers of drawing programs; net lines are real curves."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...garment.pieces.piece import Piece, PieceSet
from ...garment.svg_path import edge_path
from .drawing import Layer, Line, Text, keep_latin
from .sheet import Sheet, arrange_pieces

if TYPE_CHECKING:
    from .production import Production

PIECES_SVG_SHEET_WIDTH = 1.4
"""Width of the sheet [m]."""

STYLE = """
path { fill: none; stroke: #000; stroke-width: 0.25; }
.cut { stroke-width: 0.5; }
.sew { stroke: #1f5fa8; stroke-dasharray: 3 1.5; }
.notch { stroke: #b3261e; stroke-width: 0.4; }
.mark { stroke-dasharray: 1.5 1; }
text { font-family: sans-serif; text-anchor: middle; }
.name { font-weight: bold; }
"""


def write(production: Production, folder: Path) -> list[Path]:
    """Write `pieces.svg`, and return it."""
    path = folder / "pieces.svg"
    path.write_text(pieces_svg(production.pieces), encoding="utf-8", newline="\n")
    return [path]


def pieces_svg(pieces: PieceSet) -> str:
    """Return the SVG text of a garment's pieces; 1 user unit is 1 mm, ids are LAYER.PIECE."""
    sheet = arrange_pieces(pieces, PIECES_SVG_SHEET_WIDTH)
    width, height = (1e3 * float(value) for value in sheet.size)
    layers = "\n".join(_layer(sheet, layer, height) for layer in Layer)
    size = f'width="{width:.3f}mm" height="{height:.3f}mm" viewBox="0 0 {width:.3f} {height:.3f}"'
    spaces = 'xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<svg {spaces} {size}>\n'
        f"<title>{escape(keep_latin(pieces.name))}</title>\n<style>{STYLE}</style>\n{layers}\n</svg>\n"
    )


def _layer(sheet: Sheet, layer: Layer, height: float) -> str:
    groups = []
    for n, piece in enumerate(sheet.pieces.cut_pieces):
        if layer == Layer.TEXT:
            parts = [_text(text, height) for text in sheet.texts[n]]
        elif layer == Layer.SEW:
            drawn = any(line.layer == Layer.SEW for line in sheet.lines[n])
            parts = _sew_paths(piece, sheet.shifts[n], height) if drawn else []
        else:
            parts = [_path(line, height) for line in sheet.lines[n] if line.layer == layer]
        if parts:
            parts = [f"<title>{_describe_panels(piece)}</title>", *parts] if layer == Layer.CUT else parts
            groups.append(f'<g id="{layer}.{piece.name}">\n' + "\n".join(parts) + "\n</g>")
    return f'<g id="{layer}" inkscape:groupmode="layer" inkscape:label="{layer}">\n' + "\n".join(groups) + "\n</g>"


def _describe_panels(piece: Piece) -> str:
    """Return the names of a piece's panels as their author wrote them, in any script."""
    names = ", ".join(place.panel for place in piece.places)
    return escape("".join(letter if letter.isprintable() else "?" for letter in names))


def _page(points: np.ndarray, height: float) -> np.ndarray:
    return np.asarray(1e3 * points * [1.0, -1.0] + [0.0, height])


def _path(line: Line, height: float) -> str:
    points = " L ".join(f"{x:.4f} {y:.4f}" for x, y in _page(line.points, height))
    return f'<path class="{line.layer}" d="M {points}{" Z" if line.closed else ""}"/>'


def _sew_paths(piece: Piece, shift: np.ndarray, height: float) -> list[str]:
    """Return the path of each edge of the sew line, with its use and its edge in the pattern."""
    net, paths = piece.net, []
    for i, (edge, kind) in enumerate(zip(net.edges, piece.edges, strict=True)):
        ends = net.points[[i, (i + 1) % len(net.points)]]
        along = ends[1] - ends[0]
        left = np.array([-along[1], along[0]])
        handles = ends[0] + edge.handles[:, :1] * along + edge.handles[:, 1:] * left
        drawn = _page(np.concatenate([ends[:1], handles, ends[1:]]) + shift, height)
        source = f' data-edge="{escape(f"{kind.source.panel}.{kind.source.edge}", quote=True)}"' if kind.source else ""
        source = "".join(letter if letter.isprintable() else "?" for letter in source)
        command = f"M {drawn[0][0]:.4f} {drawn[0][1]:.4f} {edge_path(edge, drawn)}"
        paths.append(f'<path class="sew" id="sew.{piece.name}.{i}" data-use="{kind.use}"{source} d="{command}"/>')
    return paths


def _text(text: Text, height: float) -> str:
    x, y = _page(text.centre, height)
    kind = ' class="name"' if text.is_bold else ""
    return f'<text{kind} x="{x:.2f}" y="{y:.2f}" font-size="{1e3 * text.size:g}">{escape(text.text)}</text>'
