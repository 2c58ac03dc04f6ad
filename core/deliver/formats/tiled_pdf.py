"""Write pieces as PDF at 1:1: tiled on sheets to be pasted, or on one page of a roll."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...garment.meshing import points_in_polygon
from ...garment.pieces.piece import PieceSet
from .cover_page import cover_content, instruction_contents, legend_content
from .drawing import Layer, keep_latin
from .letters import fit_size
from .papers import Paper, find_paper
from .pdf_file import Page, pdf_bytes, show_text
from .sheet import Sheet, arrange_pieces, min_sheet_width, pack_pieces
from .text_places import SheetJoins
from .tiling import Tile, Tiling

if TYPE_CHECKING:
    from .production import Production

TILE_MARGIN_MM = 10.0
"""Width of a sheet's border that may be unprintable [mm]."""

TILE_OVERLAP_MM = 10.0
"""Width of the strip that two neighbouring sheets share [mm]."""

TILE_SAMPLE_STEP = 0.04
"""Distance between the places within a piece at which it is looked up which sheets show it [m]: less than a sheet."""

DIAMOND_HALF_DIAGONAL_MM = 6.0
"""Half diagonal of the marks by which sheets are aligned [mm]."""

ROLL_LEGEND_HEIGHT_MM = 80.0
"""Height of the strip with test squares and list on a roll [mm]."""

PENS = {
    Layer.CUT: "0.35 w [] 0 d", Layer.SEW: "0.2 w [3 1.5] 0 d", Layer.NOTCH: "0.35 w [] 0 d",
    Layer.GRAIN: "0.25 w [] 0 d", Layer.FOLD: "0.25 w [] 0 d", Layer.MARK: "0.2 w [1.5 1] 0 d",
}  # fmt: skip
"""Width of the line and dashes of each layer [mm]."""


def write(production: Production, folder: Path) -> list[Path]:
    """Write `pieces.pdf`, and return it.

    Raises:
        SheetTooSmall: where the paper has no room.
    """
    path = folder / "pieces.pdf"
    path.write_bytes(pieces_pdf(production.pieces, find_paper(production.options.paper)))
    return [path]


def pieces_pdf(pieces: PieceSet, paper: Paper) -> bytes:
    """Return the PDF file of a garment's pieces."""
    title = keep_latin(pieces.name)
    if paper.is_roll:
        sheet = arrange_pieces(pieces, (paper.width - 2 * TILE_MARGIN_MM) / 1e3)
        return pdf_bytes([roll_page(sheet, paper.width)], title, draw_sheet(sheet))
    sheet, tiling = tile_pieces(pieces, paper)
    pages = [Page(paper.width, paper.height, cover_content(sheet, tiling))]
    pages += [_page(sheet, tiling, number) for number in range(len(tiling.tiles))]
    pages += [Page(paper.width, paper.height, one) for one in instruction_contents(pieces, paper.width, paper.height)]
    return pdf_bytes(pages, title, draw_sheet(sheet))


def tile_pieces(pieces: PieceSet, paper: Paper) -> tuple[Sheet, Tiling]:
    """Arrange the pieces so that few sheets of paper show them, and return both; empty sheets are left out."""
    window = (paper.width - 2 * TILE_MARGIN_MM, paper.height - 2 * TILE_MARGIN_MM)
    step = (window[0] - TILE_OVERLAP_MM, window[1] - TILE_OVERLAP_MM)
    least = int(np.ceil((min_sheet_width(pieces) * 1e3 - TILE_OVERLAP_MM) / step[0]))
    found = []
    for columns in range(max(least, 1), max(least, 1) + 5):
        width = (columns * step[0] + TILE_OVERLAP_MM) / 1e3
        shifts, size = pack_pieces(pieces, width)
        outlines = [piece.cut.points + shift for piece, shift in zip(pieces.cut_pieces, shifts, strict=True)]
        tiles = _find_tiles(outlines, size, step)
        found.append((len(tiles), columns, width, tiles))
    _, _, width, tiles = min(found, key=lambda one: one[:2])
    joins = _find_joins(pack_pieces(pieces, width)[1], step)
    return arrange_pieces(pieces, width, joins), Tiling(paper, window, step, tiles)


def _find_joins(size: np.ndarray, step: tuple[float, float]) -> SheetJoins:
    """Return where sheets are pasted together on a sheet of a size [m], which they cover from its upper left corner in
    steps [mm]."""
    across, down = (
        1e-3 * length * np.arange(1, int(1e3 * whole / length) + 1)[:, None] + [0.0, 1e-3 * TILE_OVERLAP_MM]
        for whole, length in zip(size, step, strict=True)
    )
    return SheetJoins(across, size[1] - down[:, ::-1])


def _find_tiles(outlines: list[np.ndarray], size: np.ndarray, step: tuple[float, float]) -> tuple[Tile, ...]:
    """Return the tiles that are needed to show all pieces, row by row from the top. What lies on the strip that two
    sheets share is shown by either: a piece that reaches into it by millimetres needs no sheet of its own."""
    counts = np.maximum(np.ceil((size * 1e3 - TILE_OVERLAP_MM) / step).astype(int), 1)
    needed = np.zeros((counts[1], counts[0]), dtype=bool)
    shared: list[tuple[tuple[int, ...], tuple[int, ...]]] = []
    for outline in outlines:
        dense = _sample_piece(outline)
        columns = _list_shown(1e3 * dense[:, 0], step[0], int(counts[0]))
        rows = _list_shown(1e3 * (size[1] - dense[:, 1]), step[1], int(counts[1]))
        for row, column in {*zip(rows, columns, strict=True)}:
            if len(row) == len(column) == 1:
                needed[row[0], column[0]] = True
            else:
                shared.append((row, column))
    for row, column in sorted(shared):
        if not needed[np.ix_(row, column)].any():
            needed[row[0], column[0]] = True
    return tuple(Tile(int(row), int(column)) for row, column in np.argwhere(needed))


def _list_shown(places: np.ndarray, step: float, count: int) -> list[tuple[int, ...]]:
    """Return the sheets that show each of some places across them [mm]: one, or two on the strip that they share."""
    last = np.clip((places / step).astype(int), 0, count - 1)
    is_shared = (places - last * step <= TILE_OVERLAP_MM) & (last > 0)
    return [(int(k) - 1, int(k)) if both else (int(k),) for k, both in zip(last, is_shared, strict=True)]


def _sample_piece(outline: np.ndarray) -> np.ndarray:
    """Return points of an outline and within it, no square of `TILE_SAMPLE_STEP` without one [m], shape [n, 2]."""
    ends = np.roll(outline, -1, axis=0)
    parts = int(np.ceil(np.linalg.norm(ends - outline, axis=1).max() / 2e-3))
    share = np.arange(parts)[:, None, None] / parts
    low, high = outline.min(axis=0), outline.max(axis=0)
    axes = [np.arange(low[k], high[k], TILE_SAMPLE_STEP) for k in (0, 1)]
    grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    return np.concatenate([(outline + share * (ends - outline)).reshape(-1, 2), grid[points_in_polygon(outline, grid)]])


def draw_sheet(sheet: Sheet) -> str:
    """Return the operators that draw a whole sheet [mm]."""
    parts = ["0 G 0 g 1 J 1 j\n"]
    for lines, texts in zip(sheet.lines, sheet.texts, strict=True):
        for line in lines:
            parts.append(f"{PENS[line.layer]} {_path(1e3 * line.points, line.closed)}\n")
        for text in texts:
            x, y = 1e3 * text.centre
            parts.append(show_text(x - 5e2 * text.width, y, 1e3 * text.size, text.text, text.is_bold))
    return "".join(parts)


def _path(points: np.ndarray, closed: bool) -> str:
    pairs = [f"{x:.3f} {y:.3f}" for x, y in points]
    return f"{pairs[0]} m " + " ".join(f"{pair} l" for pair in pairs[1:]) + (" s" if closed else " S")


def roll_page(sheet: Sheet, width: float) -> Page:
    """Return one page that shows a whole sheet above its legend, on a roll of a width [mm]."""
    content = f"q 1 0 0 1 {TILE_MARGIN_MM:.3f} {TILE_MARGIN_MM + ROLL_LEGEND_HEIGHT_MM:.3f} cm /Drawing Do Q\n"
    height = float(sheet.size[1]) * 1e3 + 2 * TILE_MARGIN_MM + ROLL_LEGEND_HEIGHT_MM
    return Page(
        width, height, content + legend_content(sheet, TILE_MARGIN_MM, TILE_MARGIN_MM, width - 2 * TILE_MARGIN_MM)
    )


def _page(sheet: Sheet, tiling: Tiling, number: int) -> Page:
    """Return one sheet of paper: its part of the drawing, alignment marks at its neighbours, and its label."""
    tile = tiling.tiles[number]
    (wide, tall), (across, down) = tiling.window, tiling.step
    left, top = tile.column * across, float(sheet.size[1]) * 1e3 - tile.row * down
    parts = [
        f"q {TILE_MARGIN_MM:.3f} {TILE_MARGIN_MM:.3f} {wide:.3f} {tall:.3f} re W n\n",
        f"q 1 0 0 1 {TILE_MARGIN_MM - left:.3f} {TILE_MARGIN_MM + tall - top:.3f} cm /Drawing Do Q\n",
        _draw_overlaps(tiling, tile),
        "Q\n",
        f"0.6 G 0.15 w [] 0 d {TILE_MARGIN_MM:.3f} {TILE_MARGIN_MM:.3f} {wide:.3f} {tall:.3f} re S 0 G\n",
        f"0.4 g\n{_label_sheet(sheet, tiling, number)}0 g\n",
    ]
    return Page(tiling.paper.width, tiling.paper.height, "".join(parts))


def _label_sheet(sheet: Sheet, tiling: Tiling, number: int) -> str:
    """Return the operators of a sheet's name and number, and of the garment's name, clear of the strips that are cut or
    pasted: many printers leave out the paper's edge."""
    tile, inset = tiling.tiles[number], TILE_MARGIN_MM + TILE_OVERLAP_MM + 2.0
    y = tiling.paper.height - inset - 3.0
    name = f"{tile.name}   sheet {number + 1} of {len(tiling.tiles)}"
    title = f"{keep_latin(sheet.pieces.name)}, print at 100 %, no fit to page"
    size = fit_size(title, 3.0, tiling.paper.width - 2.0 * inset - 45.0)
    return show_text(inset, y, 3.5, name, True) + show_text(inset + 45.0, y, size, title)


def _draw_overlaps(tiling: Tiling, tile: Tile) -> str:
    """Return the strips shared with neighbours as light lines, and the halves of diamonds that meet on them."""
    (wide, tall), (across, down) = tiling.window, tiling.step
    parts = []
    for dr, dc in ((0, -1), (0, 1), (-1, 0), (1, 0)):
        other = Tile(tile.row + dr, tile.column + dc)
        if other not in tiling.tiles:
            continue
        if dc:
            x = TILE_MARGIN_MM + (across if dc > 0 else 0.0)
            y = TILE_MARGIN_MM + tall - down / 2
            ends = (x, TILE_MARGIN_MM, x, TILE_MARGIN_MM + tall)
        else:
            x = TILE_MARGIN_MM + across / 2
            y = TILE_MARGIN_MM + tall - (down if dr > 0 else 0.0)
            ends = (TILE_MARGIN_MM, y, TILE_MARGIN_MM + wide, y)
        label = Tile(min(tile.row, other.row), min(tile.column, other.column)).name.lower()
        diamond = np.array(
            [
                [x - DIAMOND_HALF_DIAGONAL_MM, y],
                [x, y + DIAMOND_HALF_DIAGONAL_MM],
                [x + DIAMOND_HALF_DIAGONAL_MM, y],
                [x, y - DIAMOND_HALF_DIAGONAL_MM],
            ]
        )
        parts.append("0.7 G 0.15 w [2 2] 0 d {:.3f} {:.3f} m {:.3f} {:.3f} l S\n".format(*ends))
        parts.append(f"0.3 G 0.2 w [] 0 d {_path(diamond, True)}\n")
        for dx, dy in ((-1, 0), (1, 0)) if dc else ((0, 1), (0, -1)):
            parts.append(show_text(x + dx * 3.0 - 1.4, y + dy * 2.5 - 0.8, 2.2, label))
    return "".join(parts)
