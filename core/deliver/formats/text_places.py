"""Find places for the texts of a piece: within it, clear of its marks, and not across two sheets of paper."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from ...garment.meshing import points_in_polygon
from ...garment.pieces.flatten import flatten_edge, flatten_outline
from ...garment.pieces.piece import MarkedLine, Piece
from .drawing import FOLD_INSET, Text
from .letters import break_line

PIECE_TEXT_SIZES = (0.009, 0.007, 0.005)
"""Sizes of the text on a piece, the largest that fits is taken [m]."""

LINE_WIDTHS = (20.0, 11.0)
"""Largest widths of a line of text on a piece, the first that fits is taken [sizes of its letters]: 10 cm of the
smallest, and 5.5 cm within a facing."""

TEXT_GAP = 0.003
"""Free space around the texts of a piece [m]."""

LINE_TEXT_SIZE = 0.005
"""Size of the name of a marked line [m]."""

LINE_NAME_SHARES = (0.12, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.88)
"""Fractions of a marked line at which its name may be written, the best first [1]."""

LINE_SAMPLE_STEP = 0.004
"""Largest distance of the points of a line that texts are clear of [m]: less than the smallest text is high."""

TEXT_GRID_COUNT, TRIED_PLACE_COUNT = 21, 60
"""Number of places along each side of a piece at which its texts may be, and number of those that are tried."""

NEEDED_TEXT_COUNT = 2
"""Number of texts without which a piece cannot be cut: its name, and how often it is cut."""


def _no_strips() -> np.ndarray:
    return np.zeros((0, 2))


@dataclass(frozen=True)
class SheetJoins:
    """Describe where sheets of paper are pasted together: strips upright across x, and level across y, from and to
    [m], shape [n, 2] each. A text on one would be cut in two."""

    upright: np.ndarray = field(default_factory=_no_strips)
    level: np.ndarray = field(default_factory=_no_strips)

    def shift(self, move: np.ndarray) -> SheetJoins:
        """Return the same strips in axes whose origin is moved [m], shape [2]."""
        return SheetJoins(self.upright - move[0], self.level - move[1])

    def find_clear(self, centres: np.ndarray, half: np.ndarray) -> np.ndarray:
        """Find which boxes of half a size [m] are clear of all strips, shape [n]."""
        clear = np.ones(len(centres), dtype=bool)
        for axis, strips in enumerate((self.upright, self.level)):
            at = centres[:, axis, None]
            clear &= ~((at + half[axis] > strips[:, 0]) & (at - half[axis] < strips[:, 1])).any(axis=1)
        return clear


def label_piece(piece: Piece, texts: list[str], joins: SheetJoins | None = None) -> list[Text]:
    """Return the texts of a piece and the names of its marked lines.

    Args:
        piece: The piece.
        texts: The most important first.
        joins: Where sheets of paper meet, in the piece's axes.
    """
    joins = joins or SheetJoins()
    names = name_lines(piece, joins)
    return [*place_texts(piece, texts, names, joins), *names]


def name_lines(piece: Piece, joins: SheetJoins) -> list[Text]:
    """Return the names of a piece's marked lines, each beside its line and within the piece."""
    outline = flatten_outline(piece.net, 2e-4)[0]
    found = []
    for name in dict.fromkeys(line.name for line in piece.lines):
        line = max((line for line in piece.lines if line.name == name), key=lambda one: float(np.ptp(one.points)))
        places = list(_list_name_places(line, outline.mean(axis=0)))
        inside = [text for text in places if points_in_polygon(outline, _corners(text)).all()]
        clear = [text for text in inside if joins.find_clear(*_box(text)).all()]
        found.append((clear or inside or places)[0])
    return found


def _list_name_places(line: MarkedLine, middle: np.ndarray) -> Iterator[Text]:
    """Yield the name of a line at places beside it, above a level one, first on the side of a piece's middle [m]."""
    start, end = line.points[0], line.points[-1]
    text = Text(line.name, np.zeros(2), LINE_TEXT_SIZE)
    is_upright = line.name in ("CF", "CB")
    across = np.array([0.5 * text.width + 0.002, 0.0]) if is_upright else np.array([0.0, 0.0015])
    for share in LINE_NAME_SHARES:
        place = start + share * (end - start)
        side = np.where(middle[0] >= place[0] - 1e-6, 1.0, -1.0)
        yield from (replace(text, centre=place + across * [one, 1.0]) for one in (side, -side)[: 1 + is_upright])


def _box(text: Text) -> tuple[np.ndarray, np.ndarray]:
    """Return the middle of a line of text, shape [1, 2], and half its size, shape [2] [m]."""
    return (text.centre + [0.0, 0.5 * text.size])[None], np.array([text.width, text.size]) / 2.0


def _corners(text: Text) -> np.ndarray:
    centre, half = _box(text)
    return np.asarray(centre + half * [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def place_texts(piece: Piece, texts: list[str], names: list[Text], joins: SheetJoins) -> list[Text]:
    """Return as many of the texts as fit within the sew line, clear of grainline, notches and line names, as large as
    they fit. The block is as far from the outline as a grid of places allows. On a narrow piece it lies across its
    lines; where it fits on no sheet of paper, across two; a piece too small for a text has none."""
    outline = flatten_outline(piece.net, 2e-4)[0]
    low, high = outline.min(axis=0), outline.max(axis=0)
    grid = np.stack(
        np.meshgrid(*(np.linspace(low[k], high[k], TEXT_GRID_COUNT + 2)[1:-1] for k in (0, 1))), axis=-1
    ).reshape(-1, 2)
    grid = grid[points_in_polygon(outline, grid)]
    if not len(grid):
        return []
    grid = grid[np.argsort(-_clearance(outline, grid), kind="stable")]
    ends, lines = _list_ends(piece, outline), _list_lines(piece, names)
    everything = np.concatenate([ends, lines])
    for width in LINE_WIDTHS:
        block = [
            Text(part, np.zeros(2), 1.0, n == 0)
            for n, text in enumerate(texts)
            for part in break_line(text, 1.0, width)
        ]
        needed = sum(len(break_line(text, 1.0, width)) for text in texts[:NEEDED_TEXT_COUNT])
        for taken in (everything, ends):
            found = _place_block(outline, grid, taken, block, joins)
            if len(found) >= needed:
                return found
    return _place_block(outline, grid, ends, block, SheetJoins())


def _place_block(
    outline: np.ndarray, grid: np.ndarray, taken: np.ndarray, texts: list[Text], joins: SheetJoins
) -> list[Text]:
    """Return the first texts as lines below each other at one of some places; none where no place is free."""
    for count in range(len(texts), 0, -1):
        for size in PIECE_TEXT_SIZES:
            block = [replace(text, size=size) for text in texts[:count]]
            half = np.array([max(text.width for text in block) / 2, 0.75 * size * count])
            for centre in grid[joins.find_clear(grid, half)][:TRIED_PLACE_COUNT]:
                if _is_free(outline, taken, centre, half + TEXT_GAP):
                    tops = centre[1] + half[1] - size * (1.1 + 1.5 * np.arange(count))
                    return [replace(text, centre=np.array([centre[0], y])) for text, y in zip(block, tops, strict=True)]
    return []


def _clearance(outline: np.ndarray, points: np.ndarray) -> np.ndarray:
    step = np.roll(outline, -1, axis=0) - outline
    offset = points[:, None] - outline
    part = np.clip((offset * step).sum(axis=-1) / np.maximum((step**2).sum(axis=-1), 1e-18), 0.0, 1.0)
    return np.asarray(np.linalg.norm(offset - part[..., None] * step, axis=-1).min(axis=1))


def _is_free(outline: np.ndarray, taken: np.ndarray, centre: np.ndarray, half: np.ndarray) -> bool:
    """Check that a box is within an outline and contains no place that is taken."""
    turns = np.linspace(-1.0, 1.0, 9)
    rim = np.concatenate([[(x, y) for x in turns for y in (-1.0, 1.0)], [(x, y) for y in turns for x in (-1.0, 1.0)]])
    if (np.abs(taken - centre) < half).all(axis=1).any():
        return False
    return bool(points_in_polygon(outline, centre + rim * half).all())


def _list_ends(piece: Piece, outline: np.ndarray) -> np.ndarray:
    """Return points of a piece's outline, drills and notches [m], shape [n, 2]: no text may hide one."""
    notches = [notch.point + notch.depth * notch.inward for notch in piece.notches]
    return np.concatenate([np.reshape(mark, (-1, 2)) for mark in (outline, piece.drills, *notches)])


def _list_lines(piece: Piece, names: list[Text]) -> np.ndarray:
    """Return points of a piece's grainline, fold arrow, darts and marked lines, and of these lines' names [m], shape
    [n, 2]: a text may cross one where a piece is too narrow otherwise."""
    marks = [
        _sample(piece.grain),
        *(_sample(line) for line in piece.darts),
        *(_sample(line.points) for line in piece.lines),
        *(np.concatenate([_corners(text), *_box(text)[:1]]) for text in names),
    ]
    if piece.fold is not None:
        marks.append(_sample(flatten_edge(piece.net, piece.fold)[[0, -1]] + [FOLD_INSET, 0.0]))
    return np.concatenate(marks)


def _sample(points: np.ndarray) -> np.ndarray:
    """Return points along a line, close enough that no text lies between two [m], shape [n, 2]."""
    parts = [max(int(np.linalg.norm(end - start) / LINE_SAMPLE_STEP), 1) for start, end in pairwise(points)]
    return np.concatenate([np.linspace(*ends, n + 1) for ends, n in zip(pairwise(points), parts, strict=True)])
