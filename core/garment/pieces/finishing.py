"""Draft the pieces that finish a garment's openings and are no panels of its pattern: ribs, facings, bindings,
linings of hoods.

A cloth that stretches gets ribs, shorter than their edges, and a casing at its hood; any other gets facings at neck and
front, bias bindings at armholes, and a hood's lining (H. Joseph-Armstrong, Patternmaking for Fashion Design, facings
and knits)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...run.errors import BadInput
from ..curves import edge_length
from ..parts.hoods import HOOD_LABEL
from ..pattern import Panel
from .allowance import Allowances
from .doubled import is_folded_double
from .facings import draft_facing
from .grain_line import draw_grain
from .linings import HOOD_LINING_SEAM, line_hood
from .naming import extend_name, number_name
from .notches import place_notches
from .offset import offset_outline
from .piece import EdgeUse, Material, Piece, PieceEdge, PieceSide, SeamWalk
from .strips import HOOD_CASING_WIDTH, Strip, draw_strip, plan_binding, plan_rib

NECK_FACING_DEPTH = 0.05
"""Width of a neck's facing [m]: 5 cm, so that it does not turn out."""

FRONT_FACING_DEPTH = 0.06
"""Width of the facing of a front edge [m]: twice a button's stand and a seam."""

FRONT_EDGE_USES = (EdgeUse.FRONT, EdgeUse.BUTTONS)
"""Uses of edges at the centre front that are faced."""

Sides = tuple[PieceSide, ...]


@dataclass(frozen=True)
class Finishes:
    """Describe the drafted pieces of a garment, the seams that sew them on, and the uses of edges that they finish."""

    pieces: tuple[Piece, ...] = ()
    seams: tuple[SeamWalk, ...] = ()
    uses: frozenset[EdgeUse] = frozenset()


@dataclass(frozen=True)
class Drafted:
    """Describe a drafted piece with the seam that sews it on: the seam's name, the garment's edges and its own."""

    piece: Piece
    seam: str
    garment: Sides
    own: tuple[int, ...]
    uses: frozenset[EdgeUse]


def draft_finishes(pieces: tuple[Piece, ...], step_count: int, allowances: Allowances, has_ribs: bool) -> Finishes:
    """Return the pieces that finish the openings of a garment's pieces. Where none can be drafted the opening stays as
    it is.

    Args:
        pieces: Of the garment's panels.
        step_count: Number of steps in which these are sewn.
        allowances: Of seams.
        has_ribs: Whether necks and armholes are finished by ribs, for cloth that stretches.
    """
    drafted: list[Drafted] = []
    seam = allowances.widths[EdgeUse.SEAM]
    for strip, sides in _plan_strips(pieces, seam, has_ribs):
        drafted.append(_cut_strip(pieces, strip, sides))
    faced = FRONT_EDGE_USES if has_ribs else (EdgeUse.NECK, *FRONT_EDGE_USES)
    for number in range(len(pieces)):
        drafted += _face(pieces, number, faced)
    if not has_ribs:
        drafted += [
            Drafted(lining, HOOD_LINING_SEAM, face, own, frozenset((EdgeUse.NECK,)))
            for lining, face, own in line_hood(pieces)
        ]
    drafted = _number_names(drafted, [piece.name for piece in pieces])
    names = list(dict.fromkeys(one.seam for one in drafted))
    seams = []
    for k, one in enumerate(drafted):
        walked = _split_by_copy(pieces, one)
        for garment, is_mirrored in walked:
            copies = (is_mirrored,) if one.piece.fold is None else (False, True)
            own = tuple(PieceSide(len(pieces) + k, edge, copy) for copy in copies for edge in one.own)
            lengths = _length(pieces, garment), sum(edge_length(one.piece.net, side.edge) for side in own)
            step = step_count + 1 + names.index(one.seam)
            seams.append(SeamWalk(one.seam, step, (garment, own), lengths, False, len(walked) > 1))
    return Finishes(
        tuple(one.piece for one in drafted),
        tuple(seams),
        frozenset(use for one in drafted for use in one.uses),
    )


def _split_by_copy(pieces: tuple[Piece, ...], one: Drafted) -> list[tuple[Sides, bool]]:
    """Return the garment's edges of each copy of a drafted piece: left and right apart where it is cut as a pair."""
    if not one.piece.pair:
        return [(one.garment, False)] if one.garment else []
    halves = [
        tuple(side for side in one.garment if _is_of_right(pieces, side) == is_right) for is_right in (False, True)
    ]
    return [(half, is_right) for half, is_right in zip(halves, (False, True), strict=True) if half]


def _number_names(drafted: list[Drafted], taken: list[str]) -> list[Drafted]:
    """Return drafted pieces, each with a name that no other piece has."""
    found = []
    for one in drafted:
        name = number_name(one.piece.name, taken)
        taken = [*taken, name]
        found.append(replace(one, piece=replace(one.piece, name=name, net=replace(one.piece.net, name=name))))
    return found


def _is_of_right(pieces: tuple[Piece, ...], side: PieceSide) -> bool:
    """Check whether an edge is on the wearer's right, by the side of its contour; a mirrored copy is where its piece is
    not."""
    words = pieces[side.piece].net.edges[side.edge].contour.split(".")
    return ("right" in words) != side.mirrored


def _length(pieces: tuple[Piece, ...], sides: Sides) -> float:
    return sum(edge_length(pieces[side.piece].net, side.edge) for side in sides)


def find_open_sides(pieces: tuple[Piece, ...], use: EdgeUse) -> Sides:
    """Return the edges of one use of pieces, those of mirrored copies and halves too; ribs and hoods have none here."""
    found = []
    for number, piece in enumerate(pieces):
        if is_folded_double(place.panel for place in piece.places) or piece.net.label == HOOD_LABEL:
            continue
        for i, edge in enumerate(piece.edges):
            if edge.use is use:
                found.append(PieceSide(number, i, False))
                if edge.mirror is not None:
                    found.append(PieceSide(number, i, True))
    return tuple(found)


def _plan_strips(pieces: tuple[Piece, ...], seam: float, has_ribs: bool) -> Iterator[tuple[Strip, Sides]]:
    """Yield the strips of a garment with the edges that each finishes, those of both arms together."""
    neck = find_open_sides(pieces, EdgeUse.NECK)
    if neck and has_ribs:
        yield plan_rib("NECK_RIB", (EdgeUse.NECK,), _length(pieces, neck), seam), neck
    armholes = find_open_sides(pieces, EdgeUse.ARMHOLE)
    if armholes:
        half = _length(pieces, armholes) / 2.0
        plan, name = (plan_rib, "ARMHOLE_RIB") if has_ribs else (plan_binding, "ARMHOLE_BINDING")
        yield plan(name, (EdgeUse.ARMHOLE,), half, seam), armholes
    slits = find_open_sides(pieces, EdgeUse.PLACKET)
    if slits:
        yield plan_binding("SLIT_BINDING", (EdgeUse.PLACKET,), _length(pieces, slits) / 2.0, seam), slits
    face = tuple(
        PieceSide(number, i, mirrored)
        for number, piece in enumerate(pieces)
        if piece.net.label == HOOD_LABEL
        for i, edge in enumerate(piece.edges)
        if edge.use is EdgeUse.NECK
        for mirrored in ((False, True) if edge.mirror is not None else (False,))
    )
    if face and has_ribs:
        length = _length(pieces, face)
        yield Strip("HOOD_CASING", (), length, HOOD_CASING_WIDTH, Material.CLOTH, seam, False, False), face


def _cut_strip(pieces: tuple[Piece, ...], strip: Strip, sides: Sides) -> Drafted:
    net, edges, folds = draw_strip(strip)
    is_pair = strip.uses in ((EdgeUse.ARMHOLE,), (EdgeUse.PLACKET,))
    piece = _cut(net, edges, strip.name, quantity=2 if is_pair else 1)
    piece = replace(
        piece, pair=is_pair, darts=folds, material=strip.material, is_bias=strip.is_bias, grain=_draw_strip_grain(strip)
    )
    seam = strip.name.lower().replace("_", " ") + " seam"
    return Drafted(piece, seam, sides, (0,), frozenset(strip.uses))


def _draw_strip_grain(strip: Strip) -> np.ndarray:
    """Return the line along the warp of a strip [m], shape [2, 2]: across it, or at 45 degrees."""
    middle, half = np.array([strip.length / 4.0, strip.width / 2.0]), 0.4 * strip.width
    along = np.array([1.0, 1.0]) if strip.is_bias else np.array([0.0, 1.0])
    return np.array([middle - half * along, middle + half * along])


def _cut(net: Panel, edges: tuple[PieceEdge, ...], name: str, quantity: int) -> Piece:
    """Return a piece of an outline: its cut line at the allowances, without notches."""
    offset = offset_outline(net, edges, {})
    cut, notches = place_notches(net, edges, [()] * len(edges), offset, ())
    return Piece(
        name=name,
        net=replace(net, name=name),
        edges=edges,
        places=(),
        quantity=quantity,
        pair=False,
        fold=None,
        cut=cut,
        notches=notches,
        darts=(),
        drills=np.zeros((0, 2)),
        grain=np.zeros((2, 2)),
    )


def _face(pieces: tuple[Piece, ...], number: int, uses: tuple[EdgeUse, ...]) -> list[Drafted]:
    """Return the facings of a piece: one for each run of its edges that are faced."""
    piece = pieces[number]
    panels = [place.panel for place in piece.places]
    if is_folded_double(panels) or piece.net.label == HOOD_LABEL or piece.interfaced:
        return []
    found = []
    for run in _find_runs(piece, uses):
        kinds = frozenset(piece.edges[i].use for i in run)
        depth = FRONT_FACING_DEPTH if kinds & {*FRONT_EDGE_USES} else NECK_FACING_DEPTH
        try:
            drawn = draft_facing(piece, run, depth)
            if drawn is None:
                continue
            kind = "FRONT" if kinds & {*FRONT_EDGE_USES} else "NECK"
            tail = f"{kind}_FACING" if kind not in piece.name else "FACING"
            net, edges = drawn
            facing = _cut(net, edges, extend_name(piece.name, tail), piece.quantity)
        except BadInput:
            continue
        folds = [i for i, edge in enumerate(edges) if edge.use is EdgeUse.FOLD]
        facing = replace(
            facing,
            pair=piece.pair,
            fold=folds[0] if folds else None,
            interfaced=piece.quantity,
            is_grain_known=piece.is_grain_known,
            grain=draw_grain(facing.net),
        )
        sides = tuple(
            PieceSide(number, i, mirrored)
            for mirrored in (False, True)
            for i in run
            if not mirrored or piece.edges[i].mirror is not None
        )
        found.append(Drafted(facing, f"{kind.lower()} facing seam", sides, tuple(range(len(run))), kinds))
    return found


def _find_runs(piece: Piece, uses: tuple[EdgeUse, ...]) -> list[tuple[int, ...]]:
    """Return the runs of consecutive edges of some uses."""
    count = len(piece.edges)
    is_open = [edge.use in uses for edge in piece.edges]
    runs = []
    for i in range(count):
        if is_open[i] and not is_open[i - 1]:
            length = next((k for k in range(1, count) if not is_open[(i + k) % count]), count)
            runs.append(tuple((i + k) % count for k in range(length)))
    return runs
