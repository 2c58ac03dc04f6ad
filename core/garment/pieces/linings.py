"""Line what is worn double: sew the inner layer of cuffs, waistbands and collars, and draft the lining of a hood.

Cuffs, bands and collars are cut twice of one drawing, one layer with interfacing. The inner layer is joined as the
outer, sewn to it along its free edges, and turned (H. Joseph-Armstrong, Patternmaking for Fashion Design, cuffs,
waistbands and collars). The hood of a cloth that frays is lined with its own shape; a knit's has a casing."""

from __future__ import annotations

from dataclasses import replace

from ..curves import edge_length
from ..parts.hoods import HOOD_LABEL
from ..pattern import Pattern
from .doubled import is_lined
from .naming import extend_name, say_name
from .piece import CLOSURE_EDGE_USES, EdgeUse, Piece, PieceSide, SeamWalk

HOOD_LINING_SEAM = "hood lining seam"
"""Name of the seam along a hood's face, by which its lining is sewn on."""

LINING_WORD = "LINING"
"""Last word of the names of linings."""

WAISTBAND_LABEL = "band"
"""Word of the label of a waistband's panels."""

Seams = tuple[SeamWalk, ...]
Sides = tuple[PieceSide, ...]


def line_hood(pieces: tuple[Piece, ...]) -> tuple[tuple[Piece, Sides, tuple[int, ...]], ...]:
    """Return the pieces of a hood's lining, each with the hood's edges along the face and its own. A piece of a hood is
    symmetric or has a mirrored copy, so that its lining has the same drawing."""
    found = []
    for number, piece in enumerate(pieces):
        if piece.net.label != HOOD_LABEL:
            continue
        name = extend_name(piece.name, LINING_WORD)
        edges = tuple(replace(edge, source=None, mirror=None) for edge in piece.edges)
        lining = replace(piece, name=name, net=replace(piece.net, name=name), edges=edges, places=())
        own = tuple(i for i, edge in enumerate(piece.edges) if edge.use is EdgeUse.NECK)
        face = tuple(
            PieceSide(number, i, mirrored)
            for mirrored in (False, True)
            for i in own
            if not mirrored or piece.edges[i].mirror is not None
        )
        found.append((lining, face, own))
    return tuple(found)


def sew_inner_layers(pattern: Pattern, pieces: tuple[Piece, ...], seams: Seams, step_count: int) -> Seams:
    """Return the seams that sew the inner layers of cuffs, bands and collars to the outer ones along their free and
    closed edges. Pieces that are sewn to each other, the stand and the fall of a collar, have one step.

    Args:
        pattern: The pattern.
        pieces: Its pieces.
        seams: Its seams.
        step_count: Number of steps before.
    """
    lined = [n for n, piece in enumerate(pieces) if is_lined(pattern, (place.panel for place in piece.places))]
    walks: list[SeamWalk] = []
    for group in _group_joined(lined, seams):
        halves = [_list_turned_sides(pieces, group, copies) for copies in _list_outer_copies(pieces, group)]
        halves = [sides for sides in halves if sides]
        if halves:
            step_count += 1
        for sides in halves:
            length = sum(edge_length(pieces[side.piece].net, side.edge) for side in sides)
            walks.append(
                SeamWalk(
                    _name_inner_seam(pieces[group[0]]),
                    step_count,
                    (sides, sides),
                    (length, length),
                    False,
                    len(halves) > 1,
                )
            )
    return tuple(walks)


def _name_inner_seam(piece: Piece) -> str:
    """Return the name of the seam of a piece's inner layer: `inner cuff seam`."""
    name = "waistband" if WAISTBAND_LABEL in piece.net.label.split() else say_name(piece.name).lower()
    return f"inner {name} seam"


def _group_joined(lined: list[int], seams: Seams) -> list[list[int]]:
    """Return the lined pieces in groups of those that are sewn to each other."""
    group = {number: number for number in lined}
    for seam in seams:
        joined = {group[side.piece] for sides in seam.sides for side in sides if side.piece in group}
        group = {number: min(joined) if root in joined else root for number, root in group.items()}
    return [[n for n in lined if group[n] == root] for root in sorted(set(group.values()))]


def _list_outer_copies(pieces: tuple[Piece, ...], group: list[int]) -> tuple[tuple[bool, ...], ...]:
    """Return the copies of each outer layer of a group: left and right apart, both halves of a fold as one."""
    piece = pieces[group[0]]
    if piece.fold is not None:
        return ((False, True),)
    return tuple((k == 1,) for k in range(piece.quantity // 2))


def _list_turned_sides(pieces: tuple[Piece, ...], group: list[int], copies: tuple[bool, ...]) -> Sides:
    """Return the edges of a group along which both layers are sewn together and turned."""
    return tuple(
        PieceSide(number, i, mirrored)
        for number in group
        for mirrored in copies
        for i, edge in enumerate(pieces[number].edges)
        if edge.use in (EdgeUse.FACED, *CLOSURE_EDGE_USES) and (not mirrored or edge.mirror is not None)
    )
