"""Join parts of one piece: half sleeves at the top of the sleeve, halves of a band at a side, both sides of creases."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...geometry.rigid import plane_rotation
from ..creases import is_crease
from ..errors import PanelCrossing, PanelDegenerate
from ..orientation import place_points
from ..panel_parts import find_arm_panels
from ..pattern import EdgeRef, Panel, Pattern, Seam
from ..seams import find_sewn_partners
from ..validity import check_outline
from .closure import find_closure
from .piece import PanelPlace

HALF_PANEL_WORDS = ("sleeve", "cuff", "band", "wb", "collar")
"""Parts of names and labels of panels that are halves of one piece, in the library and in published datasets. A body's
front and back share straight seams too, and are never one piece; panels on an arm are halves by any name."""

HALF_JOIN_TOLERANCE = 1e-4
"""Largest difference between the lengths of a seam's sides along which halves are joined [m]: the accuracy of
scissors."""

MAX_JOINED_GRAIN_ANGLE = np.deg2rad(45.0)
"""Largest angle between the grainlines of two joined halves [rad]. A half sleeve's is along the arm, its top seam at up
to 20 degrees to that; the joined sleeve has its grainline in the middle, as usual."""


@dataclass(frozen=True, eq=False)
class Group:
    """Describe panels of a pattern that are cut as one: the common outline, the pattern's edge for each of its edges,
    and the placement of each panel in it."""

    net: Panel
    sources: tuple[EdgeRef, ...]
    places: tuple[PanelPlace, ...]


def join_halves(pattern: Pattern) -> tuple[Group, ...]:
    """Return the panels of a pattern, those joined that are halves of one piece, each in the axes of its first panel.
    Halves are joined at a seam of two straight edges of one length, not gathered, where the outline stays simple and
    the grainlines agree within `MAX_JOINED_GRAIN_ANGLE`. Of several such seams the highest on the wearer is taken: the
    top of a sleeve, not below it. So are the two sides of a straight crease: a lapel and its front, a fall and its
    stand. Where joining closes another such seam over its length, it is no seam of the piece either. Halves that part
    again beyond the seam, as those of a flared sleeve do, are not joined: a wedge would be cut out between them."""
    groups = {panel.name: _single_panel_group(panel) for panel in pattern.panels}
    for seam in sorted(pattern.seams, key=lambda one: -_height(pattern, one.a)):
        if seam.gathered or not seam.reversed or find_closure(pattern, seam.a) is not None:
            continue
        first, second = groups[seam.a.panel], groups[seam.b.panel]
        if first is second or not _is_within_piece(pattern, seam):
            continue
        joined = _join(first, first.sources.index(seam.a), second, second.sources.index(seam.b))
        joined = None if joined is None else _close_seams(pattern, joined)
        if joined is not None and not _has_gap(pattern, joined):
            groups.update((place.panel, joined) for place in joined.places)
    return tuple(dict.fromkeys(groups.values()))


def _single_panel_group(panel: Panel) -> Group:
    sources = tuple(EdgeRef(panel.name, i) for i in range(len(panel.edges)))
    return Group(panel, sources, (PanelPlace(panel.name, np.eye(2), np.zeros(2)),))


def _is_within_piece(pattern: Pattern, seam: Seam) -> bool:
    """Check whether a seam joins two straight edges of halves of one piece, or of the two sides of a crease."""
    sides = (seam.a, seam.b)
    if any(pattern.panel(ref.panel).edges[ref.edge].kind != "line" for ref in sides):
        return False
    return all(is_crease(pattern, ref) for ref in sides) or all(_is_half(pattern, ref) for ref in sides)


def _is_half(pattern: Pattern, ref: EdgeRef) -> bool:
    panel = pattern.panel(ref.panel)
    if panel.name in find_arm_panels(pattern):
        return True
    words = f"{panel.name} {panel.label}".lower()
    return any(word in words for word in HALF_PANEL_WORDS)


def _close_seams(pattern: Pattern, group: Group) -> Group:
    """Return a group without pairs of neighbouring edges that are sewn to each other and coincide."""
    sewn = {seam.a: seam for seam in pattern.seams} | {seam.b: seam for seam in pattern.seams}
    n = 0
    while n < len(group.sources):
        net, count = group.net, len(group.sources)
        first, second = group.sources[n], group.sources[(n + 1) % count]
        seam = sewn.get(first)
        start, end = net.points[n], net.points[(n + 2) % count]
        if (
            seam is None
            or {seam.a, seam.b} != {first, second}
            or not _is_within_piece(pattern, seam)
            or np.linalg.norm(end - start) > HALF_JOIN_TOLERANCE
        ):
            n += 1
            continue
        keep = [(n + 2 + k) % count for k in range(count - 2)]
        closed = replace(net, points=net.points[keep], edges=tuple(net.edges[k] for k in keep))
        group, n = replace(group, net=closed, sources=tuple(group.sources[k] for k in keep)), 0
    return group


def _has_gap(pattern: Pattern, group: Group) -> bool:
    """Check whether two neighbouring edges of different panels of a group are sewn to each other: beyond the seam at
    which they are joined the panels do not lie side by side."""
    sewn, around = find_sewn_partners(pattern), zip(group.sources, (*group.sources[1:], group.sources[0]), strict=True)
    return any(one.panel != other.panel and sewn.get(one) == other for one, other in around)


def _height(pattern: Pattern, ref: EdgeRef) -> float:
    panel = pattern.panel(ref.panel)
    ends = panel.points[[ref.edge, (ref.edge + 1) % len(panel.points)]]
    return round(float(place_points(panel, ends)[:, 1].mean()), 4)


def _join(first: Group, i: int, second: Group, j: int) -> Group | None:
    """Return two groups joined at edge i of the first and edge j of the second; None where they do not fit."""
    a, b = first.net, second.net
    na, nb = len(a.points), len(b.points)
    start, end = a.points[i], a.points[(i + 1) % na]
    own_start, own_end = b.points[(j + 1) % nb], b.points[j]
    along, other = end - start, own_end - own_start
    if abs(np.linalg.norm(along) - np.linalg.norm(other)) > HALF_JOIN_TOLERANCE:
        return None
    angle = np.arctan2(along[1], along[0]) - np.arctan2(other[1], other[0])
    turn = plane_rotation(angle)
    apart = (a.grainline - b.grainline - angle + np.pi / 2) % np.pi - np.pi / 2
    if abs(apart) > MAX_JOINED_GRAIN_ANGLE:
        return None
    move = (start + end) / 2 - turn @ ((own_start + own_end) / 2)
    keep, others = [(i + 1 + k) % na for k in range(na)], [(j + 2 + k) % nb for k in range(nb - 2)]
    edges, more = keep[:-1], [(j + 1 + k) % nb for k in range(nb - 1)]
    net = replace(
        a,
        points=np.concatenate([a.points[keep], b.points[others] @ turn.T + move]),
        edges=tuple(a.edges[k] for k in edges) + tuple(b.edges[k] for k in more),
        grainline=a.grainline - apart / 2.0,
        notches=(),
    )
    try:
        check_outline(net)
    except (PanelCrossing, PanelDegenerate):
        return None
    sources = tuple(first.sources[k] for k in edges) + tuple(second.sources[k] for k in more)
    moved = tuple(PanelPlace(p.panel, turn @ p.rotation, turn @ p.translation + move) for p in second.places)
    return Group(net, sources, first.places + moved)


def turn_group(group: Group) -> Group:
    """Return a group with its grainline along +y."""
    angle = -group.net.grainline
    turn = plane_rotation(angle)
    places = tuple(PanelPlace(p.panel, turn @ p.rotation, turn @ p.translation) for p in group.places)
    return Group(replace(group.net, points=group.net.points @ turn.T, grainline=0.0), group.sources, places)
