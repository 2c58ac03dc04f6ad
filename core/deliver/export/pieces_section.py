"""The section of a report on the production pieces: pieces with allowance, sheets of paper, and cloth."""

from __future__ import annotations

import math
from html import escape

from ...garment.pattern import Pattern
from ...garment.pieces.layout import CLOTH_WIDTH
from ...garment.pieces.make import make_pieces
from ...garment.pieces.numbers import PieceNumbers, describe_pieces
from ...garment.pieces.trueing import describe_trueing
from ...run.errors import BadInput
from ..formats.papers import find_paper
from ..formats.tiled_pdf import tile_pieces
from .measures_section import finished_html

PAPER = "a4"
"""The paper of most printers."""


def pieces_html(pattern: Pattern) -> str:
    """Return the section, with the usual allowances, or the reason why no pieces can be cut."""
    try:
        pieces = make_pieces(pattern)
        numbers, found = describe_pieces(pieces)
        sheets = len(tile_pieces(pieces, find_paper(PAPER))[1].tiles)
    except BadInput as error:
        return f'<section><h2>Pieces to cut</h2><p class="hint">None: {escape(error.message)}</p></section>'
    rows = "".join(
        f"<tr><td>{escape(one.name)}</td><td>{_describe_cutting(one)}</td><td class=num>{1e2 * one.perimeter:.1f}</td>"
        f"<td class=num>{1e4 * one.area:.0f}</td></tr>"
        for one in numbers
    )
    length = found["pieces.cloth_length_m"] or 0.0
    cloth = (
        f"{length:.2f} m of cloth {1e2 * CLOTH_WIDTH:.0f} cm wide"
        if math.isfinite(length)
        else f"cloth wider than {1e2 * CLOTH_WIDTH:.0f} cm"
    )
    heads = ("Piece", "Cut", "Sew line [cm]", "Area with allowance [cm²]")
    head = "".join(f"<th{' class=num' if at > 1 else ''}>{text}</th>" for at, text in enumerate(heads))
    lists = (
        ("Not in this pattern:", pieces.missing),
        ("Lines where they cross seams:", describe_trueing(pieces.trued)),
    )
    notes = "".join(
        f"<p>{head}</p><ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>"
        for head, lines in lists
        if lines
    )
    return (
        '<section><h2>Pieces to cut</h2><p class="hint">With the usual seam allowances: '
        f"{cloth}, or {sheets} sheets of A4 to print, by a simple layout. <code>garmentq export JOB --as pdf</code> "
        "draws them at true scale.</p>"
        f"<table><tr>{head}</tr>{rows}</table>{notes}</section>{finished_html(pattern, pieces.finished_measures)}"
    )


def _describe_cutting(one: PieceNumbers) -> str:
    """Return how often and how a piece is cut."""
    pairs = one.quantity // 2
    pair = f" ({pairs} pair{'s' if pairs > 1 else ''})" if one.is_pair else ""
    return f"{one.quantity}{pair}{' on the fold' if one.is_folded else ''}"
