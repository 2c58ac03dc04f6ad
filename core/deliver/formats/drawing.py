"""Draw pieces as lines and texts on layers, for the writers of PDF and SVG."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import pairwise

import numpy as np

from ...garment.meshing import points_in_polygon
from ...garment.pieces.flatten import flatten_edge, flatten_outline
from ...garment.pieces.piece import Material, Piece, PieceSet

ARROW_HEAD_LENGTH = 0.006
"""Length of an arrow's head [m]."""

FOLD_INSET = 0.012
"""Distance of the arrow of a fold from the fold [m]."""

LETTER_WIDTH_FRACTION = 0.52
"""Mean width of a letter of Helvetica, as a fraction of the size of the text."""

MAX_PIECE_TEXT_SIZE, MIN_PIECE_TEXT_SIZE = 0.009, 0.005
"""Largest and smallest size of the text on a piece [m]: 9 mm where there is room, at least 5 mm."""


GRAIN_UNKNOWN_TEXT = "GRAIN UNKNOWN"
"""Text across a piece whose warp neither file nor place shows."""


STRETCH_TEXT = "most stretch across the grain"
"""Text on pieces of a knit: courses run across the grain and stretch more than wales."""


LINE_TEXT_SIZE = 0.005
"""Size of the name of a marked line [m]."""

LINE_NAME_SHARE = 0.12
"""Fraction of a marked line at which its name is written."""


class Layer(StrEnum):
    """List the layers of lines and texts."""

    CUT = "cut"
    SEW = "sew"
    NOTCH = "notch"
    GRAIN = "grain"
    FOLD = "fold"
    MARK = "mark"
    TEXT = "text"


@dataclass(frozen=True)
class Line:
    """Describe one polygon line: its layer, points [m], shape [n, 2], and whether it is closed."""

    layer: Layer
    points: np.ndarray
    closed: bool = False


@dataclass(frozen=True)
class Text:
    """Describe one line of text: the middle of its base line [m], shape [2], and its size, the letters' body
    height [m]. The name of a piece is bold."""

    text: str
    centre: np.ndarray
    size: float
    is_bold: bool = False

    @property
    def width(self) -> float:
        """Return its width [m], estimated generously."""
        return self.size * LETTER_WIDTH_FRACTION * len(self.text) * (1.1 if self.is_bold else 1.0)


def draw_lines(piece: Piece) -> list[Line]:
    """Return the lines of a piece in its own axes."""
    lines = [Line(Layer.CUT, piece.cut.points, True)]
    if any(edge.width for edge in piece.edges):
        lines.append(Line(Layer.SEW, flatten_outline(piece.net)[0], True))
    lines += [Line(Layer.NOTCH, np.array([n.point, n.point + n.depth * n.inward])) for n in piece.notches]
    lines += [Line(Layer.MARK, dart) for dart in piece.darts]
    lines += [Line(Layer.MARK, line.points) for line in piece.lines]
    cross = np.array([[-0.003, 0.0], [0.003, 0.0]])
    for drill in piece.drills:
        lines += [Line(Layer.MARK, drill + cross), Line(Layer.MARK, drill + cross[:, ::-1])]
    if piece.fold is None and piece.is_grain_known:
        lines += [Line(Layer.GRAIN, part) for part in _arrow(*piece.grain)]
    elif piece.fold is not None:
        ends = flatten_edge(piece.net, piece.fold)[[0, -1]] + [FOLD_INSET, 0.0]
        span = ends[1] - ends[0]
        inner = np.array([ends[0] + 0.1 * span, ends[0] + 0.9 * span])
        lines += [Line(Layer.FOLD, part) for part in _arrow(*inner)]
        lines += [Line(Layer.FOLD, np.array([end, end - [FOLD_INSET, 0.0]])) for end in inner]
    return lines


def _arrow(start: np.ndarray, end: np.ndarray) -> list[np.ndarray]:
    """Return a line with a head at both ends."""
    along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
    side = 0.4 * np.array([-along[1], along[0]])
    heads = [
        np.array([tip + ARROW_HEAD_LENGTH * (back + side), tip, tip + ARROW_HEAD_LENGTH * (back - side)])
        for tip, back in ((start, along), (end, -along))
    ]
    return [np.array([start, end]), *heads]


def describe_cutting(piece: Piece) -> str:
    """Return how often a piece is cut, and out of what where that is not the cloth."""
    if piece.fold is not None:
        text = f"CUT {piece.quantity} ON FOLD"
    else:
        text = f"CUT {piece.quantity}" + (f" ({piece.quantity // 2} PAIR)" if piece.pair else "")
    text += "" if piece.material is Material.CLOTH else f" OF {piece.material.upper()}"
    return text + (f" + {piece.interfaced} OF INTERFACING" if piece.interfaced else "")


def describe_allowance(piece: Piece) -> str:
    """Return the allowances of a piece in millimetres by use."""
    widths = {edge.use: edge.width for edge in piece.edges if edge.width}
    if not widths:
        return "no seam allowance"
    return "allowance " + ", ".join(f"{use} {1e3 * widths[use]:g}" for use in sorted(widths)) + " mm"


def list_texts(pieces: PieceSet, number: int) -> list[str]:
    """Return the texts on a piece, the most important first."""
    piece = pieces.cut_pieces[number]
    lines = [
        piece.name,
        describe_cutting(piece),
        "" if piece.is_grain_known else GRAIN_UNKNOWN_TEXT,
        f"{number + 1}/{len(pieces.cut_pieces)} {keep_latin(pieces.name)}",
        describe_allowance(piece),
        keep_latin(pieces.size),
        keep_latin(pieces.fabric) if piece.material is Material.CLOTH else "",
        STRETCH_TEXT if pieces.is_stretchy or piece.material is Material.RIB else "",
    ]
    return [line for line in lines if line.strip()]


def name_lines(piece: Piece) -> list[Text]:
    """Return the names of a piece's marked lines, each beside its line and within the piece."""
    found, middle = [], flatten_outline(piece.net)[0].mean(axis=0)
    for name in dict.fromkeys(line.name for line in piece.lines):
        points = max((line.points for line in piece.lines if line.name == name), key=lambda one: float(np.ptp(one)))
        start, end = points[0], points[-1]
        place = start + LINE_NAME_SHARE * (end - start)
        text = Text(name, np.zeros(2), LINE_TEXT_SIZE)
        across = np.array([0.5 * text.width + 0.002, 0.0]) if name in ("CF", "CB") else np.array([0.0, 0.0015])
        side = np.where(middle[0] >= place[0] - 1e-6, 1.0, -1.0)
        found.append(replace(text, centre=place + across * [side, 1.0]))
    return found


def place_texts(piece: Piece, texts: list[str]) -> list[Text]:
    """Return as many of the texts as fit within the sew line, clear of grainline and notches, as large as they fit. The
    block is as far from the outline as a grid of places allows; a piece too small for a text has none."""
    outline = flatten_outline(piece.net, 2e-4)[0]
    low, high = outline.min(axis=0), outline.max(axis=0)
    grid = np.stack(np.meshgrid(*(np.linspace(low[k], high[k], 23)[1:-1] for k in (0, 1))), axis=-1).reshape(-1, 2)
    grid = grid[points_in_polygon(outline, grid)]
    if not len(grid):
        return []
    grid = grid[np.argsort(-_clearance(outline, grid), kind="stable")]
    for count in range(len(texts), 0, -1):
        for size in (MAX_PIECE_TEXT_SIZE, 0.007, MIN_PIECE_TEXT_SIZE):
            block = [Text(text, np.zeros(2), size, n == 0) for n, text in enumerate(texts[:count])]
            half = np.array([max(text.width for text in block) / 2, 0.75 * size * count])
            for centre in grid[:60]:
                if _is_free(piece, outline, centre, half + 0.003):
                    tops = centre[1] + half[1] - size * (1.1 + 1.5 * np.arange(count))
                    return [
                        Text(text.text, np.array([centre[0], y]), size, text.is_bold)
                        for text, y in zip(block, tops, strict=True)
                    ]
    return []


def _clearance(outline: np.ndarray, points: np.ndarray) -> np.ndarray:
    step = np.roll(outline, -1, axis=0) - outline
    offset = points[:, None] - outline
    part = np.clip((offset * step).sum(axis=-1) / np.maximum((step**2).sum(axis=-1), 1e-18), 0.0, 1.0)
    return np.asarray(np.linalg.norm(offset - part[..., None] * step, axis=-1).min(axis=1))


def _is_free(piece: Piece, outline: np.ndarray, centre: np.ndarray, half: np.ndarray) -> bool:
    """Check that a box is within an outline and contains no grainline, fold arrow, notch, dart or drill."""
    turns = np.linspace(-1.0, 1.0, 9)
    rim = np.concatenate([[(x, y) for x in turns for y in (-1.0, 1.0)], [(x, y) for y in turns for x in (-1.0, 1.0)]])
    if not points_in_polygon(outline, centre + rim * half).all():
        return False
    marks = [
        *piece.darts,
        *(_sample(line.points) for line in piece.lines),
        piece.drills,
        *(n.point + n.depth * n.inward for n in piece.notches),
    ]
    marks.append(np.linspace(piece.grain[0], piece.grain[1], 50))
    if piece.fold is not None:
        ends = flatten_edge(piece.net, piece.fold)[[0, -1]] + [FOLD_INSET, 0.0]
        marks.append(np.linspace(ends[0], ends[1], 50))
    points = np.concatenate([np.reshape(mark, (-1, 2)) for mark in (*marks, outline)])
    return not (np.abs(points - centre) < half).all(axis=1).any()


def _sample(points: np.ndarray) -> np.ndarray:
    return np.concatenate([np.linspace(start, end, 50) for start, end in pairwise(points)])


def keep_ascii(text: str) -> str:
    """Return a user's text on one line in ASCII, at most 60 letters; others become `?`."""
    return "".join(letter if " " <= letter <= "~" else "?" for letter in text)[:60]


def keep_latin(text: str, most: int = 60) -> str:
    """Return a user's text on one line in letters of Windows-1252, a PDF's, at most `most`; others become `?`."""
    plain = text.encode("cp1252", "replace").decode("cp1252", "replace")
    return "".join(letter if letter.isprintable() else "?" for letter in plain)[:most]
