"""Compare the panels of two patterns by where they stand, halves joined along a straight seam in the middle.

Outlines run across the mouths of darts, which are no part that a scan shows; areas are those of the cloth.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from garmentq.cli.bench.pattern_match import is_wide
from garmentq.core.garment.curves import edge_points, panel_area, panel_outline
from garmentq.core.garment.editing.darts import find_darts
from garmentq.core.garment.orientation import place_points
from garmentq.core.garment.pattern import Panel, Pattern
from garmentq.core.judge.outlines import fit_outline

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
        outline: Counter-clockwise from outside, darts left out [m], shape [n, 2].
        area: Of the cloth, darts cut out [m2].
        middle: Mean of the outlines where they stand for the first drape [m], shape [3].
    """

    name: str
    outline: np.ndarray
    area: float
    middle: np.ndarray

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
    pieces, joined, darts = [], set(), _mark_darts(pattern)
    for (a, b), edges in sewn.items():
        if a == b or joined & {a, b}:
            continue
        one, other = pattern.panel(a), pattern.panel(b)
        sides = [i for i, _ in edges], [j for _, j in edges]
        whole = _join(one, sides[0], darts), _join(other, sides[1], darts)
        middles = _middle(one), _middle(other)
        apart = np.abs(middles[0] * (-1.0, 1.0, 1.0) - middles[1])  # of the one's mirror image from the other
        if whole[0] is None or whole[1] is None or apart.max() > MIDDLE:
            continue
        areas = panel_area(one), panel_area(other)
        if abs(areas[0] - areas[1]) < TWINS * areas[0]:
            joined |= {a, b}
            pieces.append(Piece(f"{a}+{b}", whole[0], sum(areas), 0.5 * (middles[0] + middles[1])))
    single = [panel for panel in pattern.panels if panel.name not in joined]
    alone = [Piece(panel.name, _outline(panel, darts), panel_area(panel), _middle(panel)) for panel in single]
    return (*pieces, *alone)


def compare_pieces(ours: Iterable[Piece], truth: Iterable[Piece]) -> tuple[PieceDifference, ...]:
    """Compare wide pieces place by place, the upper before the lower; nothing where one has more at a place, bands too.

    What a waistband takes of a skirt's height cannot be told from the skirt where only one of both has the band.
    """
    (ours_by, our_bands), (true_by, true_bands) = (_by_place(pieces) for pieces in (ours, truth))
    counts = [{place: len(found) for place, found in places.items()} for places in (ours_by, true_by)]
    if counts[0] != counts[1] or our_bands != true_bands:
        return ()
    return tuple(
        PieceDifference(true.name, own.area / true.area - 1.0, fit_outline(own.outline, true.outline).rms)
        for place, found in true_by.items()
        for own, true in zip(ours_by[place], found, strict=True)
    )


def _by_place(pieces: Iterable[Piece]) -> tuple[dict[tuple[bool, int], list[Piece]], int]:
    """Return the wide pieces by place, the uppermost first, and the number of bands."""
    found: dict[tuple[bool, int], list[Piece]] = defaultdict(list)
    bands = 0
    for piece in sorted(pieces, key=lambda piece: -piece.middle[1]):
        if is_wide(piece.outline):
            found[piece.place].append(piece)
        else:
            bands += 1
    return found, bands


def _mark_darts(pattern: Pattern) -> dict[tuple[str, int], int]:
    """Return, by panel and edge, how many of its points a side of a dart leaves in an outline: 1 and 0.

    The first side begins at the mouth, the second at the dart's tip.
    """
    found: dict[tuple[str, int], int] = {}
    for dart in find_darts(pattern):
        second = (dart.first + 1) % len(pattern.panel(dart.panel).edges)
        found |= {(dart.panel, dart.first): 1, (dart.panel, second): 0}
    return found


def _join(panel: Panel, edges: list[int], darts: Mapping[tuple[str, int], int]) -> np.ndarray | None:
    """Return a panel and its mirror image across some of its edges, counter-clockwise; None where they are no line."""
    count = len(panel.edges)
    starts = [i for i in edges if (i - 1) % count not in edges]
    if len(starts) != 1 or len(edges) == count:
        return None
    order = [(starts[0] + k) % count for k in range(count)]
    seam = np.concatenate([edge_points(panel, i, SEGMENTS) for i in order[: len(edges)]])
    rest = _trace(panel, order[len(edges) :], darts)
    start, end = seam[0], seam[-1]
    along = (end - start) / np.linalg.norm(end - start)
    across = np.array([-along[1], along[0]])
    if np.abs((seam - start) @ across).max() > STRAIGHT:
        return None
    own = np.append(rest, start[None], axis=0)  # from the seam's end round to its start
    mirrored = own - 2.0 * np.outer((own - start) @ across, across)
    return np.concatenate([own, mirrored[::-1][1:-1]])


def _trace(panel: Panel, edges: Iterable[int], darts: Mapping[tuple[str, int], int]) -> np.ndarray:
    """Return the points of edges that follow each other, without the last, across the mouths of darts."""
    return np.concatenate([edge_points(panel, i, SEGMENTS)[: darts.get((panel.name, i), -1)] for i in edges])


def _outline(panel: Panel, darts: Mapping[tuple[str, int], int]) -> np.ndarray:
    return _trace(panel, range(len(panel.edges)), darts)


def _middle(panel: Panel) -> np.ndarray:
    return np.asarray(place_points(panel, panel_outline(panel, SEGMENTS)).mean(axis=0))
