"""Draw pieces as lines and texts on layers, for the writers of PDF and SVG."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ...garment.pieces.flatten import flatten_edge, flatten_outline
from ...garment.pieces.naming import say_name
from ...garment.pieces.piece import Material, Piece, PieceSet
from .letters import measure_text

ARROW_HEAD_LENGTH = 0.006
"""Length of an arrow's head [m]."""

FOLD_INSET = 0.012
"""Distance of the arrow of a fold from the fold [m]."""

GRAIN_UNKNOWN_TEXT = "GRAIN UNKNOWN"
"""Text across a piece whose warp neither file nor place shows."""


STRETCH_TEXT = "most stretch across the grain"
"""Text on pieces of a knit: courses run across the grain and stretch more than wales."""


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
        """Return its width in the letters of PDF [m]."""
        return measure_text(self.text, self.size, self.is_bold)


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
        say_name(piece.name),
        describe_cutting(piece),
        "" if piece.is_grain_known else GRAIN_UNKNOWN_TEXT,
        f"{number + 1}/{len(pieces.cut_pieces)} {keep_latin(pieces.name)}",
        describe_allowance(piece),
        keep_latin(pieces.size),
        keep_latin(pieces.fabric) if piece.material is Material.CLOTH else "",
        STRETCH_TEXT if pieces.is_stretchy or piece.material is Material.RIB else "",
    ]
    return [line for line in lines if line.strip()]


def keep_ascii(text: str) -> str:
    """Return a user's text on one line in ASCII, at most 60 letters; others become `?`."""
    return "".join(letter if " " <= letter <= "~" else "?" for letter in text)[:60]


def keep_latin(text: str, most: int = 60) -> str:
    """Return a user's text on one line in letters of Windows-1252, a PDF's, at most `most`; others become `?`."""
    plain = text.encode("cp1252", "replace").decode("cp1252", "replace")
    return "".join(letter if letter.isprintable() else "?" for letter in plain)[:most]
