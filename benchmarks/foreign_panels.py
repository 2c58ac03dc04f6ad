"""Compare the panels of two patterns by where they stand, halves joined along a straight seam in the middle."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from garmentq.core.measure.matching import is_wide
from garmentq.core.measure.outlines import fit_outline
from garmentq.core.pattern import Panel, Pattern, edge_points, place_points, polygon_area

SEGMENTS = 24
"""Segments of each curve: the chord error on a 50 cm curve is 0.1 mm."""

STRAIGHT = 0.003
"""How far a seam may leave its chord to be straight [m]: a drawn line does not, and a shaped back leaves it by more."""

TWINS = 0.01
"""By how much the areas and the seams of two halves may differ, relative."""

MIDDLE = 0.04
"""How far from the middle plane the mean of an outline may lie on a panel that reaches across it [m]."""


@dataclass(frozen=True)
class Piece:
    """Describe a panel, or two halves of one.

    Attributes:
        name: Of the panel, or of both halves.
        outline: Counter-clockwise from outside [m], shape [n, 2].
        middle: Mean of the outlines where they stand for the first drape [m], shape [3].
    """

    name: str
    outline: np.ndarray
    middle: np.ndarray

    @property
    def area(self) -> float:
        """Return the area [m2]."""
        return abs(polygon_area(self.outline))

    @property
    def place(self) -> tuple[bool, int]:
        """Return whether the piece is in front, and its side: -1, 0 or 1."""
        across = float(self.middle[0])
        return bool(self.middle[2] > 0.0), 0 if abs(across) < MIDDLE else int(np.sign(across))


@dataclass(frozen=True)
class PieceDifference:
    """Describe how one piece differs from the true one: in area, relative, and by its outline, RMS [m]."""

    name: str
    area: float
    outline: float


def join_halves(pattern: Pattern) -> tuple[Piece, ...]:
    """Return a pattern's panels as pieces, mirror halves joined where one straight seam joins them."""
    sewn: dict[tuple[str, str], list[tuple[int, int]]] = defaultdict(list)
    for seam in pattern.seams:
        (a, i), (b, j) = sorted(((seam.a.panel, seam.a.edge), (seam.b.panel, seam.b.edge)))
        sewn[a, b].append((i, j))
    pieces, joined = [], set()
    for (a, b), edges in sewn.items():
        if a == b or joined & {a, b}:
            continue
        one, other = pattern.panel(a), pattern.panel(b)
        whole = _join(one, [i for i, _ in edges]), _join(other, [j for _, j in edges])
        middles = _middle(one), _middle(other)
        apart = np.abs(middles[0] * (-1.0, 1.0, 1.0) - middles[1])  # of the one's mirror image from the other
        if whole[0] is None or whole[1] is None or apart.max() > MIDDLE:
            continue
        areas = [polygon_area(outline) for outline in whole]
        if abs(areas[0] - areas[1]) < TWINS * areas[0]:
            joined |= {a, b}
            pieces.append(Piece(f"{a}+{b}", whole[0], 0.5 * (middles[0] + middles[1])))
    single = [panel for panel in pattern.panels if panel.name not in joined]
    return (*pieces, *(Piece(panel.name, _outline(panel), _middle(panel)) for panel in single))


def compare_pieces(ours: Iterable[Piece], truth: Iterable[Piece]) -> tuple[PieceDifference, ...]:
    """Compare wide pieces place by place, the upper before the lower; nothing where one has more at a place."""
    places = [_by_place(pieces) for pieces in (ours, truth)]
    if {place: len(found) for place, found in places[0].items()} != {
        place: len(found) for place, found in places[1].items()
    }:
        return ()
    return tuple(
        PieceDifference(true.name, own.area / true.area - 1.0, fit_outline(own.outline, true.outline).rms)
        for place, found in places[1].items()
        for own, true in zip(places[0][place], found, strict=True)
    )


def _by_place(pieces: Iterable[Piece]) -> dict[tuple[bool, int], list[Piece]]:
    """Return the wide pieces by place, the uppermost first."""
    found: dict[tuple[bool, int], list[Piece]] = defaultdict(list)
    for piece in sorted(pieces, key=lambda piece: -piece.middle[1]):
        if is_wide(piece.outline):
            found[piece.place].append(piece)
    return found


def _join(panel: Panel, edges: list[int]) -> np.ndarray | None:
    """Return a panel and its mirror image across some of its edges, counter-clockwise; None where they are no line."""
    count = len(panel.edges)
    starts = [i for i in edges if (i - 1) % count not in edges]
    if len(starts) != 1 or len(edges) == count:
        return None
    lines = [edge_points(panel, (starts[0] + k) % count, SEGMENTS) for k in range(count)]
    seam, rest = np.concatenate(lines[: len(edges)]), np.concatenate([line[:-1] for line in lines[len(edges) :]])
    start, end = seam[0], seam[-1]
    along = (end - start) / np.linalg.norm(end - start)
    across = np.array([-along[1], along[0]])
    if np.abs((seam - start) @ across).max() > STRAIGHT:
        return None
    own = np.append(rest, start[None], axis=0)  # from the seam's end round to its start
    mirrored = own - 2.0 * np.outer((own - start) @ across, across)
    return np.concatenate([own, mirrored[::-1][1:-1]])


def _outline(panel: Panel) -> np.ndarray:
    return np.concatenate([edge_points(panel, i, SEGMENTS)[:-1] for i in range(len(panel.edges))])


def _middle(panel: Panel) -> np.ndarray:
    return np.asarray(place_points(panel, _outline(panel)).mean(axis=0))
