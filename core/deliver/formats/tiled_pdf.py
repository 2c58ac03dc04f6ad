"""Write pieces as PDF at 1:1: tiled on sheets to be pasted, or on one page of a roll."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...garment.meshing import points_in_polygon
from ...garment.pieces.piece import PieceSet
from .cover_page import cover_content, legend_content
from .drawing import Layer, keep_latin
from .papers import Paper, find_paper
from .pdf_file import Page, pdf_bytes, show_text
from .sheet import Sheet, arrange_pieces, min_sheet_width, pack_pieces
from .tiling import Tile, Tiling

if TYPE_CHECKING:
    from .production import Production

TILE_MARGIN_MM = 10.0
"""Width of a sheet's border that may be unprintable [mm]."""

TILE_OVERLAP_MM = 10.0
"""Width of the strip that two neighbouring sheets share [mm]."""

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
        outlines = [piece.cut.points + shift for piece, shift in zip(pieces.pieces, shifts, strict=True)]
        tiles = _find_tiles(outlines, size, step)
        found.append((len(tiles), columns, width, tiles))
    _, _, width, tiles = min(found, key=lambda one: one[:2])
    return arrange_pieces(pieces, width), Tiling(paper, window, step, tiles)


def _find_tiles(outlines: list[np.ndarray], size: np.ndarray, step: tuple[float, float]) -> tuple[Tile, ...]:
    """Return the tiles that show a part of a piece, row by row from the top."""
    counts = np.maximum(np.ceil((size * 1e3 - TILE_OVERLAP_MM) / step).astype(int), 1)
    shown = np.zeros((counts[1], counts[0]), dtype=bool)
    for outline in outlines:
        ends = np.roll(outline, -1, axis=0)
        parts = int(np.ceil(np.linalg.norm(ends - outline, axis=1).max() / 2e-3))
        share = np.arange(parts)[:, None, None] / parts
        dense = 1e3 * (outline + share * (ends - outline)).reshape(-1, 2)
        column = np.clip((dense[:, 0] / step[0]).astype(int), 0, counts[0] - 1)
        row = np.clip(((size[1] * 1e3 - dense[:, 1]) / step[1]).astype(int), 0, counts[1] - 1)
        shown[row, column] = True
        rows, columns = np.indices(shown.shape)
        middles = np.stack([(columns + 0.5) * step[0], size[1] * 1e3 - (rows + 0.5) * step[1]], axis=-1).reshape(-1, 2)
        shown |= points_in_polygon(outline, middles / 1e3).reshape(shown.shape)
    return tuple(Tile(int(row), int(column)) for row, column in np.argwhere(shown))


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
        show_text(TILE_MARGIN_MM, 4.5, 3.5, f"{tile.name}   sheet {number + 1} of {len(tiling.tiles)}", True),
        show_text(TILE_MARGIN_MM + 45.0, 4.5, 3.0, f"{keep_latin(sheet.pieces.name)}, print at 100 %, no fit to page"),
    ]
    return Page(tiling.paper.width, tiling.paper.height, "".join(parts))


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
