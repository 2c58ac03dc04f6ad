"""Make production pieces from a pattern."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..creases import find_turned_panels, is_crease
from ..grain import list_unknown_grains
from ..orientation import place_points
from ..outline import PLACKET_CONTOUR, is_vent_side
from ..panel_parts import find_arm_panels
from ..pattern import EdgeRef, Pattern
from .allowance import Allowances
from .closure import find_closure
from .darts import dart_lines, find_darts, find_slits, fold_mouth
from .doubled import is_folded_double, is_lined, unfold_double
from .finished_measures import measure_finished
from .finishing import Finishes, draft_finishes
from .flatten import flatten_edge
from .folding import find_fold_axis, fold_piece
from .grain_line import draw_grain
from .joining import Group, join_halves, turn_group
from .linings import sew_inner_layers
from .marked_lines import PanelLevel, mark_lines
from .marks import Mark, collect_marks, find_gathered_runs, turn_marks
from .missing_parts import list_missing
from .naming import name_pieces
from .notches import place_notches
from .offset import offset_outline
from .pairing import MirroredGroup, find_twins, pair_groups
from .piece import EdgeUse, Material, Piece, PieceEdge, PieceSet
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
    empty texts; whether that cloth stretches as a knit does; further lines of the title, label and value; the
    levels of the wearer's body on the panels; and how sure the pattern's lines are, a text each."""

    name: str = ""
    size: str = ""
    fabric: str = ""
    is_stretchy: bool = False
    details: tuple[tuple[str, str], ...] = ()
    levels: tuple[PanelLevel, ...] = ()
    margins: tuple[str, ...] = ()


@dataclass(frozen=True)
class PieceSettings:
    """Describe how pieces are made: seam allowances, whether symmetric pieces are drawn as a half on the fold,
    whether lines are trued where they cross seams, and whether pieces that finish openings are drafted."""

    allowances: Allowances = field(default_factory=Allowances)
    fold: bool = False
    is_trued: bool = True
    is_finished: bool = True


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
        _make_piece(pattern, one, name, settings, (marks, style.levels))
        for one, name in zip(drawn, name_pieces(pattern, members), strict=True)
    )
    seams = order_seams(pattern, pieces, find_twins(pattern))
    finishes, is_turned = Finishes(), bool(find_turned_panels(pattern))
    if settings.is_finished:
        last = max((seam.step for seam in seams), default=0)
        has_ribs = style.is_stretchy and not is_turned
        finishes = draft_finishes(pieces, last, settings.allowances, has_ribs)
        last = max((seam.step for seam in finishes.seams), default=last)
        inner = sew_inner_layers(pattern, pieces, seams, last)
        finishes = replace(finishes, seams=(*finishes.seams, *inner))
    return PieceSet(
        style.name or pattern.name,
        style.size,
        style.fabric,
        pieces,
        seams,
        list_missing(pieces, finishes.uses, is_turned),
        trueing.lines,
        style.is_stretchy,
        finishes.pieces,
        finishes.seams,
        style.details,
        measure_finished(pattern),
        style.margins,
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
    marked: tuple[dict[EdgeRef, tuple[Mark, ...]], tuple[PanelLevel, ...]],
) -> Piece:
    group, (marks, levels) = _group(drawn), marked
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
    net, along, passed = group.net, [_edge_marks(marks, edge) for edge in edges], _find_passed(pattern, group)
    names = [place.panel for place in group.places]
    double = unfold_double(net, edges) if is_folded_double(names) and not wedges else None
    if double is not None:
        net, edges, passed = double.net, double.edges, []
        along = [turn_marks(along[i]) if mirrored else along[i] for i, mirrored in double.origins]
    offset = offset_outline(net, edges, mouths)
    cut, notches = place_notches(net, edges, along, offset, wedges, passed)
    lines, tips = dart_lines(net, wedges, [flatten_edge(net, i) for i in range(len(edges))])
    lined = is_lined(pattern, names)
    quantity, is_whole = (2 if pair else 1), isinstance(drawn, MirroredGroup) and drawn.is_symmetric
    piece = Piece(
        name=name,
        net=replace(net, name=name, notches=()),
        edges=edges,
        places=group.places + (drawn.places if isinstance(drawn, MirroredGroup) else ()),
        quantity=2 * quantity if lined else quantity,
        pair=pair or (lined and not is_whole),
        fold=None,
        cut=cut,
        notches=notches,
        darts=(*lines, *_crease_lines(pattern, group), *(() if double is None else (double.fold,))),
        drills=tips,
        grain=draw_grain(net),
        is_grain_known=list_unknown_grains(pattern).isdisjoint(names),
        material=Material.RIB if double is not None else Material.CLOTH,
        interfaced=quantity if lined and "elastic" not in net.label else 0,
    )
    axis = find_fold_axis(drawn) if isinstance(drawn, MirroredGroup) and drawn.is_symmetric else None
    piece = mark_lines(pattern, piece, axis, levels)
    if settings.fold and double is None and isinstance(drawn, MirroredGroup) and drawn.is_symmetric:
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
        use = EdgeUse.FACED if is_lined(pattern, (ref.panel,)) else use
    return PieceEdge(use, settings.allowances.widths[use], ref, mirror=mirror)


def _edge_marks(marks: dict[EdgeRef, tuple[Mark, ...]], edge: PieceEdge) -> tuple[Mark, ...]:
    """Return the marks of an edge and of its mirrored copy, which differ where only one side has a mark."""
    marks_of_edge = marks.get(edge.source, ()) if edge.source else ()
    other = turn_marks(marks.get(edge.mirror, ())) if edge.mirror else ()
    more = tuple(mark for mark in other if all(abs(mark.at - known.at) > 1e-6 for known in marks_of_edge))
    return tuple(sorted((*marks_of_edge, *more), key=lambda mark: mark.at))
