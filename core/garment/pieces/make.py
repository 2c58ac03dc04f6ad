"""Make production pieces from a pattern."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..creases import find_turned_panels, is_crease
from ..grain import list_unknown_grains
from ..meshing import points_in_polygon
from ..orientation import place_points
from ..outline import PLACKET_CONTOUR, is_vent_side
from ..panel_parts import find_arm_panels
from ..pattern import EdgeRef, Panel, Pattern
from .allowance import Allowances
from .closure import find_closure
from .darts import dart_lines, find_darts, find_slits, fold_mouth
from .flatten import flatten_edge, flatten_outline
from .folding import fold_piece
from .joining import Group, join_halves, turn_group
from .marks import Mark, collect_marks, find_gathered_runs, turn_marks
from .missing_parts import list_missing
from .naming import name_pieces
from .notches import place_notches
from .offset import offset_outline
from .pairing import MirroredGroup, find_twins, pair_groups
from .piece import EdgeUse, Piece, PieceEdge, PieceSet
from .sewing_order import order_seams
from .trueing import Trueing, true_pattern

CONTOURS = {
    "neck": EdgeUse.NECK, "armhole": EdgeUse.ARMHOLE, "cuff": EdgeUse.CUFF, "hem": EdgeUse.HEM, "leg": EdgeUse.LEG,
    "waist": EdgeUse.WAIST, "front": EdgeUse.FRONT, PLACKET_CONTOUR: EdgeUse.PLACKET,
    "wrap": EdgeUse.WRAP,
}  # fmt: skip
"""Use of an open edge by its contour; others are open."""

PIECE_ORDER = ("body", "front", "back", "leg", "skirt", "sleeve", "band", "cuff", "collar")
"""Words of labels and names by which pieces are sorted; pieces without one come last."""


@dataclass(frozen=True)
class Style:
    """Describe the style that pieces are labelled with: its name, its size by girths and the name of its cloth, or
    empty texts."""

    name: str = ""
    size: str = ""
    fabric: str = ""


@dataclass(frozen=True)
class PieceSettings:
    """Describe how pieces are made: seam allowances, whether symmetric pieces are drawn as a half on the fold, and
    whether lines are trued where they cross seams."""

    allowances: Allowances = field(default_factory=Allowances)
    fold: bool = False
    is_trued: bool = True


def make_pieces(
    pattern: Pattern,
    settings: PieceSettings | None = None,
    style: Style | None = None,
    point_std: np.ndarray | None = None,
) -> PieceSet:
    """Return the production pieces of a pattern. Lines are trued (`true_pattern`), halves of a sleeve or band joined,
    mirrored pairs drawn once, grainlines turned to +y; each piece gets its cut line by `offset_outline`, and notches on
    both sides of each seam.

    Args:
        pattern: The pattern.
        settings: How pieces are made.
        style: What they are labelled with.
        point_std: Standard deviation of a recovered pattern's control points [m], shape [point_count, 2], or None.

    Raises:
        PieceBad: where a piece cannot be cut.
        PanelCrossing, PanelDegenerate: where a panel is invalid.
    """
    settings, style = settings or PieceSettings(), style or Style()
    trueing = true_pattern(pattern, point_std) if settings.is_trued else Trueing(pattern)
    drafted, groups = (tuple(map(turn_group, join_halves(one))) for one in (pattern, trueing.pattern))
    pattern = trueing.pattern
    drawn = sorted(pair_groups(pattern, groups, drafted), key=lambda one: _rank(pattern, _group(one)))
    both = [isinstance(one, MirroredGroup) and not one.is_symmetric for one in drawn]
    members = [
        (tuple(place.panel for place in _group(one).places), pair) for one, pair in zip(drawn, both, strict=True)
    ]
    marks = collect_marks(pattern)
    pieces = tuple(
        _make_piece(pattern, one, name, settings, marks)
        for one, name in zip(drawn, name_pieces(pattern, members), strict=True)
    )
    return PieceSet(
        style.name or pattern.name,
        style.size,
        style.fabric,
        pieces,
        order_seams(pattern, pieces, find_twins(pattern)),
        list_missing(pieces, bool(find_turned_panels(pattern))),
        trueing.lines,
    )


def _group(drawn: Group | MirroredGroup) -> Group:
    return drawn.group if isinstance(drawn, MirroredGroup) else drawn


def _rank(pattern: Pattern, group: Group) -> tuple[int, str]:
    names = [place.panel for place in group.places]
    arm = "sleeve" if names[0] in find_arm_panels(pattern) else ""
    words = f"{group.net.label} {' '.join(names)} {arm}".lower()
    by_label = next((i for i, word in enumerate(PIECE_ORDER) if word in words), len(PIECE_ORDER))
    sleeve = any(word in words for word in PIECE_ORDER[5:])
    return (len(PIECE_ORDER) + by_label if sleeve else by_label, " ".join(("0" if "front" in words else "1", *names)))


def _make_piece(
    pattern: Pattern,
    drawn: Group | MirroredGroup,
    name: str,
    settings: PieceSettings,
    marks: dict[EdgeRef, tuple[Mark, ...]],
) -> Piece:
    group = _group(drawn)
    pair = isinstance(drawn, MirroredGroup) and not drawn.is_symmetric
    twins: tuple[EdgeRef | None, ...] = (
        drawn.mirrors if isinstance(drawn, MirroredGroup) and pair else (None,) * len(group.sources)
    )
    sewn = _find_inner_seams(pattern, group)
    darts = find_darts(group.net, sewn)
    inner = {k % len(group.sources) for first, last in darts for k in range(first, last + 1)}
    edges = tuple(
        _describe_edge(pattern, ref, twin, i in inner, settings)
        for i, (ref, twin) in enumerate(zip(group.sources, twins, strict=True))
    )
    slits = find_slits(group.net)
    wedges = (*darts, *slits)
    mouths = {span: fold_mouth(group.net, span, _is_laid_back(pattern, group, span)) for span in darts}
    mouths |= {(first, last): group.net.points[[first, (last + 1) % len(edges)]] for first, last in slits}
    offset = offset_outline(group.net, edges, mouths)
    along = [_edge_marks(marks, edge) for edge in edges]
    cut, notches = place_notches(group.net, edges, along, offset, wedges, _find_passed(pattern, group))
    lines, tips = dart_lines(group.net, wedges, [flatten_edge(group.net, i) for i in range(len(edges))])
    piece = Piece(
        name=name,
        net=replace(group.net, name=name, notches=()),
        edges=edges,
        places=group.places + (drawn.places if isinstance(drawn, MirroredGroup) else ()),
        quantity=2 if pair else 1,
        pair=pair,
        fold=None,
        cut=cut,
        notches=notches,
        darts=(*lines, *_crease_lines(pattern, group)),
        drills=tips,
        grain=_draw_grain(group.net),
        is_grain_known=list_unknown_grains(pattern).isdisjoint(place.panel for place in group.places),
    )
    if settings.fold and isinstance(drawn, MirroredGroup) and drawn.is_symmetric:
        return fold_piece(piece, drawn) or piece
    return piece


def _is_laid_back(pattern: Pattern, group: Group, span: tuple[int, int]) -> bool:
    """Check whether a dart's intake is laid towards the edge before it. It is laid down, or to the wearer's middle,
    whichever its mouth is more along (H. Joseph-Armstrong, Patternmaking for Fashion Design)."""
    count = len(group.sources)
    before, after = group.sources[(span[0] - 1) % count], group.sources[(span[1] + 1) % count]
    ends = (before.panel, before.edge + 1), (after.panel, after.edge)
    panels = [pattern.panel(name) for name, _ in ends]
    one, other = (
        place_points(panel, panel.points[[index % len(panel.points)]])[0]
        for panel, (_, index) in zip(panels, ends, strict=True)
    )
    if abs(other[1] - one[1]) > abs(other[0] - one[0]):
        return bool(one[1] < other[1])
    return bool(abs(one[0]) < abs(other[0]))


def _crease_lines(pattern: Pattern, group: Group) -> tuple[np.ndarray, ...]:
    """Return the lines along which a piece is folded [m], shape [n, 2] each: creases between two panels of it."""
    places, lines = {place.panel: place for place in group.places}, []
    for seam in pattern.seams:
        ref = seam.a
        if ref in group.sources or not {seam.a.panel, seam.b.panel} <= set(places) or not is_crease(pattern, ref):
            continue
        place = places[ref.panel]
        lines.append(flatten_edge(pattern.panel(ref.panel), ref.edge) @ place.rotation.T + place.translation)
    return tuple(lines)


def _find_passed(pattern: Pattern, group: Group) -> list[int]:
    """Return the control points of a group at which one run of gathers goes on."""
    runs = {ref: n for n, run in enumerate(find_gathered_runs(pattern)) for seam in run for ref in (seam.a, seam.b)}
    found = [runs.get(ref, -1 - i) for i, ref in enumerate(group.sources)]
    return [i for i, run in enumerate(found) if len(found) > 1 and run == found[i - 1]]


def _find_inner_seams(pattern: Pattern, group: Group) -> dict[int, int]:
    """Return, for each edge of a group that is sewn to another one of it, that one."""
    found = {}
    for seam in pattern.seams:
        if seam.a in group.sources and seam.b in group.sources:
            i, j = group.sources.index(seam.a), group.sources.index(seam.b)
            found[i], found[j] = j, i
    return found


def _describe_edge(
    pattern: Pattern, ref: EdgeRef, mirror: EdgeRef | None, in_dart: bool, settings: PieceSettings
) -> PieceEdge:
    seams = [seam for seam in pattern.seams if ref in (seam.a, seam.b)]
    if in_dart:
        use = EdgeUse.DART
    elif seams and (closure := find_closure(pattern, ref)) is not None:
        use = closure
    elif seams:
        use = EdgeUse.GATHERED if seams[0].gathered else EdgeUse.SEAM
    else:
        edge = pattern.panel(ref.panel).edges[ref.edge]
        use = EdgeUse.VENT if is_vent_side(edge) else CONTOURS.get(edge.contour.split(".")[0], EdgeUse.OPEN)
    return PieceEdge(use, settings.allowances.widths[use], ref, mirror=mirror)


def _edge_marks(marks: dict[EdgeRef, tuple[Mark, ...]], edge: PieceEdge) -> tuple[Mark, ...]:
    """Return the marks of an edge and of its mirrored copy, which differ where only one side has a mark."""
    marks_of_edge = marks.get(edge.source, ()) if edge.source else ()
    other = turn_marks(marks.get(edge.mirror, ())) if edge.mirror else ()
    more = tuple(mark for mark in other if all(abs(mark.at - known.at) > 1e-6 for known in marks_of_edge))
    return tuple(sorted((*marks_of_edge, *more), key=lambda mark: mark.at))


def _draw_grain(net: Panel) -> np.ndarray:
    """Return the line to be drawn along the warp [m], shape [2, 2]: four fifths of an upright line, at most 0.4 m. Of
    upright lines nearly as long as the longest, the one nearest to a third of the width is taken, away from the texts
    in the middle."""
    outline = flatten_outline(net)[0]
    low, high = outline.min(axis=0), outline.max(axis=0)
    ys = np.linspace(low[1], high[1], 202)[1:-1]
    found = [(0.0, outline.mean(axis=0), outline.mean(axis=0))]
    for x in np.linspace(low[0], high[0], 21)[1:-1]:
        inside = points_in_polygon(outline, np.stack([np.full(200, x), ys], axis=1))
        edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
        found += [
            (float(ys[b - 1] - ys[a]), np.array([x, ys[a]]), np.array([x, ys[b - 1]])) for a, b in edges.reshape(-1, 2)
        ]
    longest = max(length for length, _, _ in found)
    third = low[0] + (high[0] - low[0]) / 3.0
    long = [one for one in found if one[0] >= 0.85 * longest]
    length, start, end = min(long, key=lambda one: (abs(float(one[1][0]) - third), float(one[1][1])))
    middle, half = (start + end) / 2.0, min(0.4 * length, 0.2)
    return np.array([middle - [0.0, half], middle + [0.0, half]])
