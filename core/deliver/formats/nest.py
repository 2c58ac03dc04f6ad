"""Write the sizes of a garment: a pattern each, a nest of their pieces, and rules that move the base size to each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...garment.garmentcode_writer import save_pattern
from ...garment.pieces.make import make_pieces
from ...garment.pieces.piece import Piece, PieceSet
from ...garment.pieces.shelf_packing import pack_on_shelves
from ...garment.pieces.trueing import true_pattern
from .dialects import DIALECTS_BY_NAME
from .drawing import draw_lines, keep_latin, list_texts
from .dxf import Block, Rules, dxf_text, rule_text, write_archive
from .flat_dxf import flat_text
from .grade_table import write_grade_table
from .grading import Size, grade_sizes
from .papers import PLOTTER_ROLL_WIDTH_MM, find_paper
from .pdf_file import Page, pdf_bytes, show_text
from .size_layers import draw_size_layers, name_layer, nest_svg
from .text_places import label_piece

if TYPE_CHECKING:
    from .production import Production

SIZE_NEST_GAP = 0.02
"""Free space between nests [m]."""

NEST_PAGE_MARGIN_MM = 10.0
"""Width of the border of the page, and height of a line of its legend [mm]."""

DASHES = ("[]", "[6 2]", "[3 1.5]", "[1.5 1]", "[8 2 1 2]", "[4 1 1 1 1 1]", "[2 2]")
"""Dashes of the sizes [mm], in turn; the base is drawn whole and thick."""

SPREAD_SIZES_NOTE = "no shipped template: what no rule grades is spread between named points"
"""Note on sizes without a draft."""


def write(production: Production, folder: Path) -> list[Path]:
    """Write `pattern_SIZE.json`, `nest.pdf`, `nest.svg`, the grade table, `nest_DIALECT.dxf`, and the base with its
    rules; return the files.

    Raises:
        SizesBad: where sizes are not valid.
        SizesUnclear: where a size of a table is far from the wearer's.
        PieceBad: where a piece of a size cannot be cut.
    """
    sizes = grade_worn(production)
    pieces = [
        make_pieces(
            size.pattern,
            production.options.piece_settings,
            replace(production.style, size=size.name),
            production.point_std,
        )
        for size in sizes
    ]
    pieces = _keep_common(pieces)
    files = [save_pattern(size.pattern, folder / f"pattern_{size.name}.json") for size in sizes]
    paper = find_paper(production.options.paper)
    nest = folder / "nest.pdf"
    width = paper.width if paper.is_roll else PLOTTER_ROLL_WIDTH_MM
    nest.write_bytes(nest_pdf(sizes, pieces, width))
    layered = folder / "nest.svg"
    layered.write_text(draw_nest(sizes, pieces, width), encoding="utf-8", newline="\n")
    table = write_grade_table(sizes, pieces[0].name, production.options.unit or "cm", paper, folder)
    dialect = DIALECTS_BY_NAME[production.options.dialect]
    base = next(n for n, size in enumerate(sizes) if size.is_base)
    blocks = [
        Block(piece, f"{piece.name}_{size.name}", size.name)
        for size, one in zip(sizes, pieces, strict=True)
        for piece in one.cut_pieces
    ]
    if dialect.is_flat:
        flat = folder / f"nest_{dialect.name}.dxf"
        ordered = [base, *(k for k in range(len(sizes)) if k != base)]
        flat.write_bytes(flat_text([(sizes[k].name, pieces[k]) for k in ordered]).encode("ascii"))
        return [*files, nest, layered, *table, flat]
    moves, rules = find_rules(pieces, base)
    base_blocks = [Block(piece, piece.name, sizes[base].name) for piece in pieces[base].cut_pieces]
    names = tuple(size.name for size in sizes)
    texts = {
        f"nest_{dialect.name}.dxf": dxf_text(pieces[base], blocks, dialect),
        f"graded_{dialect.name}.dxf": dxf_text(pieces[base], base_blocks, dialect, rules),
        f"graded_{dialect.name}.rul": rule_text(dialect, names, moves, sizes[base].name),
    }
    return [*files, nest, layered, *table, *write_archive(texts, dialect, folder, f"sizes_{dialect.name}.zip")]


def grade_worn(production: Production) -> list[Size]:
    """Return the sizes of a garment, graded from its trued pattern: growing from smooth lines they stay smooth, and the
    cut pieces have the figures of the grade table.

    Raises:
        SizesBad: where sizes are not valid.
        SizesUnclear: where a size of a table is far from the wearer's.
        CapUnfit: where no sleeve fits a size's armhole.
    """
    trued = true_pattern(production.pattern, production.point_std).pattern
    return grade_sizes(trued, production.worn.template, production.measures, production.height, production.options)


def find_rules(pieces: list[PieceSet], base: int) -> tuple[list[np.ndarray], Rules]:
    """Find the rules that move turn points and notches of the base to every size.

    A piece with other turn points in some size (a mitre cut off in one of them) has no rules, but is in the nest.

    Args:
        pieces: The pieces of each size.
        base: Index of the base.

    Returns:
        Movements of each rule [m], shape [size_count, 2], and the points of each base piece with their rules' numbers.
    """
    moves: list[np.ndarray] = []
    numbers: dict[bytes, int] = {}
    rules: Rules = {}
    for n, piece in enumerate(pieces[base].cut_pieces):
        turns = [find_turn_points(one.cut_pieces[n]) for one in pieces]
        if any(len(points) != len(turns[base]) for points in turns):
            continue
        found = []
        for k, point in enumerate(turns[base]):
            moved = np.array([points[k] - point for points in turns])
            key = np.round(moved, 7).tobytes()
            if key not in numbers:
                moves.append(moved)
                numbers[key] = len(moves)
            found.append((point, numbers[key]))
        rules[piece.name] = found
    return moves, rules


def find_turn_points(piece: Piece) -> np.ndarray:
    """Return the points that rules move: corners of the cut line, notches, control points of the net [m], [n, 2]."""
    notches = np.array([notch.point for notch in piece.notches]).reshape(-1, 2)
    return np.concatenate([piece.cut.points[piece.cut.corner], notches, piece.net.points])


def nest_pdf(sizes: list[Size], pieces: list[PieceSet], width: float) -> bytes:
    """Return a roll's page of a width [mm] with all sizes of each piece upon each other, in different dashes."""
    base = next(n for n, size in enumerate(sizes) if size.is_base)
    places, room, tall = _place_nest(pieces, width)
    legend = NEST_PAGE_MARGIN_MM * (len(sizes) + 3)
    shifts = 1e3 * places + [NEST_PAGE_MARGIN_MM, NEST_PAGE_MARGIN_MM + legend]
    names = [size.name for size in sizes]
    parts = ["0 G 0 g 1 J 1 j\n"]
    parts.append(draw_size_layers(names, pieces, shifts, [_pen(k, base) for k in range(len(sizes))]))
    for n, piece in enumerate(pieces[base].cut_pieces):
        for line in draw_lines(piece):
            if line.layer not in ("cut", "sew"):
                dashes = "[1.5 1]" if line.layer == "mark" else "[]"
                parts.append(f"0.25 w {dashes} 0 d {_path(1e3 * line.points + shifts[n], False)}\n")
        for text in label_piece(piece, list_texts(pieces[base], n)):
            x, y = 1e3 * text.centre + shifts[n]
            parts.append(show_text(x - 5e2 * text.width, y, 1e3 * text.size, text.text, text.is_bold))
    parts.append(show_text(NEST_PAGE_MARGIN_MM, legend, 6.0, f"{keep_latin(pieces[base].name)}: sizes", True))
    if not all(size.is_drafted for size in sizes):
        parts.append(show_text(NEST_PAGE_MARGIN_MM + 90.0, legend, 4.0, SPREAD_SIZES_NOTE))
    for k, size in enumerate(sizes):
        y = legend - NEST_PAGE_MARGIN_MM * (k + 1)
        measures = size.measures
        girths = f"bust {100 * measures.bust:.0f} waist {100 * measures.waist:.0f} hip {100 * measures.hip:.0f}"
        parts.append(
            f"{_pen(k, base)} {NEST_PAGE_MARGIN_MM:.1f} {y + 1.2:.1f} m "
            f"{NEST_PAGE_MARGIN_MM + 30:.1f} {y + 1.2:.1f} l S\n"
        )
        parts.append(
            show_text(NEST_PAGE_MARGIN_MM + 34.0, y, 4.0, f"{size.name}   {girths}{'   base' if size.is_base else ''}")
        )
    height = 1e3 * tall + 2.0 * NEST_PAGE_MARGIN_MM + legend
    page = Page(1e3 * room, height, "".join(parts))
    return pdf_bytes([page], f"{pieces[base].name} sizes", "", [name_layer(name) for name in names])


def draw_nest(sizes: list[Size], pieces: list[PieceSet], width: float) -> str:
    """Return the SVG text of a nest on a sheet of a width [mm], a layer for each size."""
    base = next(n for n, size in enumerate(sizes) if size.is_base)
    places, room, tall = _place_nest(pieces, width)
    border = NEST_PAGE_MARGIN_MM / 1e3
    return nest_svg([size.name for size in sizes], pieces, base, places + border, np.array([room, tall + 2.0 * border]))


def _place_nest(pieces: list[PieceSet], width: float) -> tuple[np.ndarray, float, float]:
    """Return the translation of each piece's nest on a page of a width [mm] without its border [m], shape [n, 2], the
    width of the page, and the height of all nests [m]."""
    points = [np.concatenate([one.cut.points for one in all_sizes]) for all_sizes in _list_nested(pieces)]
    low, high = (np.array([extreme(one, axis=0) for one in points]) for extreme in (np.min, np.max))
    room = max(width / 1e3, float((high - low)[:, 0].max()) + 2.0 * NEST_PAGE_MARGIN_MM / 1e3)
    corners = pack_on_shelves(high - low, SIZE_NEST_GAP, room - 2.0 * NEST_PAGE_MARGIN_MM / 1e3, stacked=True)
    return corners - low, room, float((corners + high - low)[:, 1].max())


def _list_nested(pieces: list[PieceSet]) -> Iterator[tuple[Piece, ...]]:
    """Yield each piece in all sizes."""
    return zip(*(one.cut_pieces for one in pieces), strict=True)


def _keep_common(pieces: list[PieceSet]) -> list[PieceSet]:
    """Return the pieces of all sizes, without those that finish edges where some size has others."""
    names = [[piece.name for piece in one.drafted] for one in pieces]
    if all(one == names[0] for one in names):
        return pieces
    return [replace(one, drafted=(), finishes=()) for one in pieces]


def _pen(number: int, base: int) -> str:
    if number == base:
        return "0.5 w [] 0 d"
    return f"0.25 w {DASHES[1 + number % (len(DASHES) - 1)]} 0 d"


def _path(points: np.ndarray, closed: bool) -> str:
    pairs = [f"{x:.3f} {y:.3f}" for x, y in points]
    return f"{pairs[0]} m " + " ".join(f"{pair} l" for pair in pairs[1:]) + (" s" if closed else " S")
