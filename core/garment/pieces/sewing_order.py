"""Order in which the seams of a garment are sewn: flat as long as possible, tubes last."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..curves import edge_length
from ..orientation import place_points
from ..parts.hoods import HOOD_LABEL
from ..pattern import EdgeRef, Pattern, Seam
from .closure import find_closure
from .piece import Piece, PieceSide, SeamWalk

Key = frozenset[tuple[str, int]]
Copy = tuple[int, bool]
Sides = Mapping[EdgeRef, tuple[PieceSide, ...]]


def order_seams(pattern: Pattern, pieces: tuple[Piece, ...], mirror: Mapping[EdgeRef, EdgeRef]) -> tuple[SeamWalk, ...]:
    """Return the seams to be sewn, in order, without those inside a joined piece. Darts come first, then the seams of a
    hood, which is sewn on as a whole. Then, from the top of the garment down, seams that join pieces which are not
    connected yet: they are sewn flat. Then, from the top down, those that close the connected pieces to tubes, and last
    those with a zip or buttons. Mirrored seams are one step.

    Args:
        pattern: The pattern.
        pieces: Its pieces.
        mirror: For each edge its mirror image.
    """
    homes = find_sides(pieces)
    steps: dict[Key, list[Seam]] = {}
    for seam in pattern.seams:
        if seam.a in homes and seam.b in homes:
            steps.setdefault(_key(seam, mirror), []).append(seam)
    waiting = sorted(steps, key=lambda key: (-_height(pattern, steps[key][0]), sorted(key)))
    ordered = [key for key in waiting if _is_dart(pattern, steps[key][0])]
    ordered += [key for key in waiting if key not in ordered and _is_in_hood(pattern, steps[key][0])]
    closures = [key for key in waiting if find_closure(pattern, steps[key][0].a) is not None]
    waiting = [key for key in waiting if key not in ordered and key not in closures]
    cloth = {seam: _seam_pieces(pieces, homes, seam) for seams in steps.values() for seam in seams}
    sewn = {copy: copy for copies in cloth.values() for copy in copies}
    for key in ordered:
        sewn = _join(sewn, [cloth[seam] for seam in steps[key]])
    while waiting:
        joins = [key for key in waiting if any(len({sewn[c] for c in cloth[seam]}) > 1 for seam in steps[key])]
        chosen = (joins or waiting)[0]
        waiting.remove(chosen)
        ordered.append(chosen)
        sewn = _join(sewn, [cloth[seam] for seam in steps[chosen]])
    walks = [(seam, step) for step, key in enumerate([*ordered, *closures], 1) for seam in steps[key]]
    return tuple(_walk(pattern, pieces, homes, *walk) for walk in walks)


def _join(sewn: dict[Copy, Copy], seams: list[frozenset[Copy]]) -> dict[Copy, Copy]:
    """Return the connected pieces after some seams, each named by one of its pieces of cloth."""
    for copies in seams:
        whole = {sewn[copy] for copy in copies}
        sewn = {copy: min(whole) if now in whole else now for copy, now in sewn.items()}
    return sewn


def find_sides(pieces: tuple[Piece, ...]) -> dict[EdgeRef, tuple[PieceSide, ...]]:
    """Return the pieces' edges for each edge of the pattern: its parts in the edge's direction."""
    found: dict[EdgeRef, list[tuple[float, PieceSide]]] = {}
    for number, piece in enumerate(pieces):
        for i, edge in enumerate(piece.edges):
            if edge.source is not None:
                found.setdefault(edge.source, []).append((edge.part[0], PieceSide(number, i, False)))
            if edge.mirror is not None:
                found.setdefault(edge.mirror, []).append((1.0 - edge.part[1], PieceSide(number, i, True)))
    return {ref: tuple(side for _, side in sorted(parts, key=lambda one: one[0])) for ref, parts in found.items()}


def _key(seam: Seam, mirror: Mapping[EdgeRef, EdgeRef]) -> Key:
    sides = sorted((ref.panel, ref.edge) for ref in (seam.a, seam.b))
    other = sorted((ref.panel, ref.edge) for ref in (mirror.get(seam.a, seam.a), mirror.get(seam.b, seam.b)))
    return frozenset(min(sides, other))


def _height(pattern: Pattern, seam: Seam) -> float:
    heights = []
    for ref in (seam.a, seam.b):
        panel = pattern.panel(ref.panel)
        ends = panel.points[[ref.edge, (ref.edge + 1) % len(panel.points)]]
        heights.append(float(place_points(panel, ends)[:, 1].mean()))
    return round(float(np.mean(heights)), 4)


def _is_dart(pattern: Pattern, seam: Seam) -> bool:
    count = len(pattern.panel(seam.a.panel).edges)
    apart = (seam.a.edge - seam.b.edge) % count
    return seam.a.panel == seam.b.panel and apart in (1, count - 1)


def _is_in_hood(pattern: Pattern, seam: Seam) -> bool:
    return all(pattern.panel(ref.panel).label == HOOD_LABEL for ref in (seam.a, seam.b))


def _seam_pieces(pieces: tuple[Piece, ...], homes: Sides, seam: Seam) -> frozenset[Copy]:
    """Return the pieces of cloth on both sides of a seam: number, and whether it is the mirrored copy."""
    sides = (*homes[seam.a], *homes[seam.b])
    return frozenset((side.piece, side.mirrored and pieces[side.piece].pair) for side in sides)


def _walk(pattern: Pattern, pieces: tuple[Piece, ...], homes: Sides, seam: Seam, step: int) -> SeamWalk:
    sides = homes[seam.a], homes[seam.b][::-1] if seam.reversed else homes[seam.b]
    lengths = [sum(edge_length(pieces[side.piece].net, side.edge) for side in one) for one in sides]
    label = pattern.panel(seam.a.panel).edges[seam.a.edge].label
    names = " / ".join(pieces[one[0].piece].name for one in sides)
    return SeamWalk(label or names, step, sides, (lengths[0], lengths[1]), seam.gathered)
