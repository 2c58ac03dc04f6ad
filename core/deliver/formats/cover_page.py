"""The first page of tiled sheets, and the legend of a roll: test squares, pieces, map of sheets, sewing order."""

from __future__ import annotations

import numpy as np

from ...garment.meshing import points_in_polygon
from ...garment.pieces.bill import list_materials
from ...garment.pieces.finished_points import list_finished
from ...garment.pieces.instructions import list_sewing_steps
from ...garment.pieces.layout import lay_on_cloth
from ...garment.pieces.naming import say_name
from ...garment.pieces.piece import PieceSet
from ...garment.pieces.trueing import describe_trueing
from .drawing import STRETCH_TEXT, describe_cutting, keep_latin
from .letters import break_line, fit_size
from .pdf_file import show_text
from .sheet import Sheet
from .tiling import Tile, Tiling

TEST_SQUARES = ((50.0, "50 mm"), (50.8, "2 in"))
"""Sides of the test squares [mm], each with its label in its own unit."""

COVER_LINE_HEIGHT_MM = 4.4
"""Height of a line of text [mm]."""

COVER_TEXT_SIZE_MM = 3.2
"""Size of the text [mm]."""


COVER_MARGIN_MM = 12.0
"""Width of the border of a page with texts [mm]: printers leave out up to 10."""

COVER_HEADINGS = ("Pieces", "Sewing order", "Bill of material", "Not in this pattern", "Trueing", "How sure")
"""Lines that are bold."""


def cover_content(sheet: Sheet, tiling: Tiling) -> str:
    """Return the operators of the cover of a tiling: title, test squares, map of the sheets, list of pieces."""
    paper, pieces = tiling.paper, sheet.pieces
    left, top = COVER_MARGIN_MM, paper.height - 18.0
    width = paper.width - 2 * left
    parts = ["0 G 0 g\n", _show_title(left, top, 7.0, keep_latin(pieces.name), width)]
    sheets = f"{len(tiling.tiles)} sheets of {paper.name.upper()}; print at 100 %, then measure:"
    lines = _break_lines([*heading_lines(pieces), sheets], width)
    parts.append(_column(left, top - 6.0, lines, len(lines)))
    y = top - 10.0 - COVER_LINE_HEIGHT_MM * len(lines) - TEST_SQUARES[1][0]
    parts.append(_squares(left, y))
    y -= 8.0
    listed = _break_lines(_list_pieces(pieces, _name_tiles(sheet, tiling)), width)
    room = y - COVER_MARGIN_MM - COVER_LINE_HEIGHT_MM * len(listed)
    height = max(min(room, 110.0), 40.0)
    parts.append(_map(sheet, tiling, (left, y - height), (width, height)))
    y -= height + 8.0
    parts.append(_column(left, y, listed, int((y - COVER_MARGIN_MM) / COVER_LINE_HEIGHT_MM)))
    return "".join(parts)


def instruction_contents(pieces: PieceSet, width: float, height: float) -> list[str]:
    """Return the operators of the pages of instructions: sewing order, bill of material, notes.

    Args:
        pieces: The pieces.
        width: Of a page [mm].
        height: Of a page [mm].
    """
    left, top = COVER_MARGIN_MM, height - 18.0
    lines = [*list_steps(pieces), "", *list_bill(pieces), "", *list_notes(pieces)]
    wrapped = _break_lines(lines, width - 2 * left)
    most = int((top - 6.0 - COVER_MARGIN_MM) / COVER_LINE_HEIGHT_MM)
    pages = []
    for n in range(0, len(wrapped), most):
        head = _show_title(left, top + 4.0, 4.0, keep_latin(pieces.name), width - 2 * left)
        pages.append("0 G 0 g\n" + head + _column(left, top - 6.0, wrapped[n : n + most], most))
    return pages


def list_bill(pieces: PieceSet) -> list[str]:
    """Return the bill of material, a line each."""
    return ["Bill of material", *(line.describe() for line in list_materials(pieces))]


def legend_content(sheet: Sheet, x: float, y: float, width: float) -> str:
    """Return the operators of the strip below the pieces of a roll, its lower left corner at (x, y) [mm]."""
    pieces = sheet.pieces
    lines = [*heading_lines(pieces), *_list_pieces(pieces, {}), *list_notes(pieces)]
    title = _show_title(x + 125.0, y + 68.0, 6.0, keep_latin(pieces.name), width - 125.0)
    parts = ["0 G 0 g\n", _squares(x, y + 8.0), title]
    most, column = int(60.0 / COVER_LINE_HEIGHT_MM), 110.0
    lines = _break_lines(lines, column - COVER_LINE_HEIGHT_MM)
    room = max(1, int((width - 125.0) / column))
    for n in range(min(room, -(-len(lines) // most))):
        parts.append(_column(x + 125.0 + n * column, y + 62.0, lines[n * most : (n + 1) * most], most))
    return "".join(parts)


def heading_lines(pieces: PieceSet) -> list[str]:
    """Return the lines of a title: what is known of the garment, its size and cloth, the number of pieces."""
    details = [f"{label}: {keep_latin(value, 100)}" for label, value in pieces.details]
    lines = [f"size: {keep_latin(pieces.size)} cm" if pieces.size else "", keep_latin(pieces.fabric)]
    count = sum(piece.quantity for piece in pieces.cut_pieces)
    finished = list_finished(pieces.finished_measures)
    return [*details, *filter(None, lines), *finished, f"{count} pieces to cut" + describe_cloth(pieces)]


def describe_cloth(pieces: PieceSet) -> str:
    """Return the length of cloth of the usual width, and which way it stretches most."""
    lay = lay_on_cloth(pieces.cut_pieces)
    cloth = f"about {lay.length:.2f} m" if np.isfinite(lay.length) else "wider than the cloth"
    stretch = f"; {STRETCH_TEXT}" if pieces.is_stretchy else ""
    return f"; {cloth} at {100 * lay.width:.0f} cm{stretch}"


def _squares(left: float, bottom: float) -> str:
    parts = []
    for n, (side, name) in enumerate(TEST_SQUARES):
        x = left + 60.0 * n
        parts.append(f"0.2 w [] 0 d {x:.3f} {bottom:.3f} {side:.3f} {side:.3f} re S\n")
        parts.append(show_text(x + 16.0, bottom + side / 2, 5.0, name, True))
    return "".join(parts)


def _map(sheet: Sheet, tiling: Tiling, corner: tuple[float, float], box: tuple[float, float]) -> str:
    """Return a small picture of the sheet with the borders and names of the tiles."""
    whole = sheet.size * 1e3
    scale = min(box[0] / float(whole[0]), box[1] / float(whole[1]))
    origin = np.array([corner[0], corner[1] + box[1] - scale * float(whole[1])])
    parts = []
    for outline in sheet.outlines:
        drawn = origin + scale * 1e3 * outline
        path = " ".join(f"{x:.2f} {y:.2f} {'l' if n else 'm'}" for n, (x, y) in enumerate(drawn))
        parts.append(f"0.85 g 0.3 G 0.15 w [] 0 d {path} b\n")
    across, down = tiling.step
    for tile in tiling.tiles:
        x = origin[0] + scale * tile.column * across
        y = origin[1] + scale * (float(whole[1]) - (tile.row + 1) * down)
        parts.append(f"0.5 G {x:.2f} {y:.2f} {scale * across:.2f} {scale * down:.2f} re S\n")
        parts.append("0 g " + show_text(x + 1.0, y + 1.2, 2.8, tile.name))
    return "".join([*parts, "0 G 0 g\n"])


def _name_tiles(sheet: Sheet, tiling: Tiling) -> dict[int, list[str]]:
    """Return the names of the sheets that show each piece, by the piece's number."""
    across, down = tiling.step
    height = float(sheet.size[1]) * 1e3

    def shows(tile: Tile, outline: np.ndarray) -> bool:
        outline = _densify(outline)
        low = np.array([tile.column * across, height - (tile.row + 1) * down])
        high = low + (across, down)
        inside = (outline > low).all(axis=1) & (outline < high).all(axis=1)
        return bool(inside.any() or points_in_polygon(outline, ((low + high) / 2)[None])[0])

    return {
        number: [tile.name for tile in tiling.tiles if shows(tile, 1e3 * outline)]
        for number, outline in enumerate(sheet.outlines)
    }


def _densify(outline: np.ndarray) -> np.ndarray:
    """Return a closed line with points at least every 20 mm, shape [n, 2] [mm]."""
    ends = np.roll(outline, -1, axis=0)
    parts = max(int(np.ceil(np.linalg.norm(ends - outline, axis=1).max() / 20.0)), 1)
    share = np.arange(parts)[:, None, None] / parts
    return np.asarray((outline + share * (ends - outline)).reshape(-1, 2))


def _list_pieces(pieces: PieceSet, shown: dict[int, list[str]]) -> list[str]:
    lines = ["Pieces"]
    for n, piece in enumerate(pieces.cut_pieces):
        where = shown.get(n, [])
        sheets = f": {', '.join(where[:8])}{' ...' if len(where) > 8 else ''}" if where else ""
        lines.append(f"{n + 1} {say_name(piece.name)}, {describe_cutting(piece)}{sheets}")
    return lines


def list_notes(pieces: PieceSet) -> list[str]:
    """Return a line for the allowances of a garment, one for each missing item, for each line that was trued, and for
    each whose place and length are known within margins."""
    widths = {edge.use: edge.width for piece in pieces.cut_pieces for edge in piece.edges if edge.width}
    included = ", ".join(f"{use} {1e3 * widths[use]:g}" for use in sorted(widths))
    head = f"Allowance included [mm]: {included}" if any(widths.values()) else "No seam allowance included"
    trued = [f"- {line}" for line in describe_trueing(pieces.trued)]
    missing = [f"- {line}" for line in pieces.missing]
    sure = [f"- {keep_latin(line, 200)}" for line in pieces.margins]
    further = (("Not in this pattern", missing), ("Trueing", trued), ("How sure", sure))
    return [head, *(line for name, lines in further if lines or lines is missing for line in ("", name, *lines))]


def list_steps(pieces: PieceSet) -> list[str]:
    """Return the steps of sewing in order, a line each."""
    return ["Sewing order"] + [
        f"{number} {keep_latin(step.describe(), 200)}" for number, step in enumerate(list_sewing_steps(pieces), 1)
    ]


def _show_title(x: float, y: float, size: float, title: str, width: float) -> str:
    """Return the operators of a bold line from a point on its base line, smaller where it is too wide [mm]."""
    return show_text(x, y, fit_size(title, size, width, True), title, True)


def _break_lines(lines: list[str], width: float) -> list[str]:
    """Return lines of text broken to a width [mm]."""
    return [part for line in lines for part in break_line(line, COVER_TEXT_SIZE_MM, width, "   ")]


def _column(x: float, y: float, lines: list[str], most: int) -> str:
    if len(lines) > most > 1:
        lines = [*lines[: most - 1], f"... and {len(lines) - most + 1} more lines"]
    return "".join(
        show_text(x, y - COVER_LINE_HEIGHT_MM * n, COVER_TEXT_SIZE_MM, line, bold=line in COVER_HEADINGS)
        for n, line in enumerate(lines[:most])
    )
