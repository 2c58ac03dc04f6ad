"""Find the named points of a bodice that grade rules move: shoulders, underarm points, neckline, hem.

They are found by how panels meet, so that patterns of any program have them: an armhole is what is sewn to a sleeve or
open around an arm, a shoulder what continues it above, a neckline what continues that to the middle.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..memo import memoise
from ..orientation import place_points
from ..panel_parts import MIDDLE_REACH, Side, find_arm_panels, find_part, find_side
from ..pattern import EdgeRef, Panel, Pattern
from ..seams import find_sewn_partners

PointRef = tuple[str, int]
"""A panel's name, and the number of one of its control points."""

NO_TRUNK_PARTS = ("collar", "hood", "band", "wb", "leg", "pant", "skirt", "cuff")
"""Parts of a garment that are no bodice, though they may hang on one."""

HEM_CONTOUR = "hem"
"""Beginning of the names of contours at the lower end of a bodice or a skirt."""

HANGING_PARTS = ("collar", "hood", "band", "wb", "cuff")
"""Parts of a garment that are sewn to the edges of others."""

LEG_CONTOUR = "leg"
"""Beginning of the names of contours at the lower end of a leg."""

MAX_HEM_RISE = 0.06
"""Largest height of a hem's sides over its lowest point [m]: a shirt's tails are curved by as much."""

HEM_LEVEL_TOLERANCE = 0.01
"""Height above the lowest point of a face up to which others belong to its hem, where no contour says it [m]."""

MAX_WALKED_EDGE_COUNT = 12
"""Largest number of edges from a shoulder's tip to the middle of a neckline, princess seams and yokes counted."""

LEFT_SIGN, RIGHT_SIGN = 1, -1
"""Signs of x on the wearer's left and right [1]."""


@dataclass(frozen=True)
class FacePoints:
    """Describe the named points of the front or the back of a bodice; dictionaries are by the sign of the side.

    Attributes:
        face: Front or back.
        tips: Ends of the shoulders, where the armholes begin.
        underarms: Lower ends of the armholes.
        necks: Side neck points; none where no shoulder seam leads to one.
        throat: The point of the neckline in the middle; two where the face has an opening there.
        neckline: Edges from the side neck points to the middle.
        hems: Points of the lower edge.
    """

    face: Side
    tips: dict[int, PointRef] = field(default_factory=dict)
    underarms: dict[int, PointRef] = field(default_factory=dict)
    necks: dict[int, PointRef] = field(default_factory=dict)
    throat: tuple[PointRef, ...] = ()
    neckline: tuple[EdgeRef, ...] = ()
    hems: tuple[PointRef, ...] = ()


@memoise
def find_bodice_points(pattern: Pattern) -> tuple[FacePoints, ...]:
    """Find the named points of front and back; empty where the pattern has no armholes."""
    ends: dict[tuple[Side, int], list[tuple[float, PointRef, int]]] = {}
    middle = find_middle(pattern)
    for name in find_trunk_panels(pattern):
        panel = pattern.panel(name)
        placed = place_points(panel, panel.points)
        for first, last in _list_armhole_runs(pattern, name):
            count = len(panel.points)
            inner = [k % count for k in range(first, first + (last - first) % count + 1)]
            sign = LEFT_SIGN if placed[inner, 0].mean() > middle else RIGHT_SIGN
            found = ends.setdefault((find_side(panel), sign), [])
            found += [(float(placed[first, 1]), (name, first), -1), (float(placed[last, 1]), (name, last), 1)]
    faces = []
    for face in (Side.FRONT, Side.BACK):
        tips, underarms, necks, throat = {}, {}, {}, {}
        neckline: list[EdgeRef] = []
        for sign in (LEFT_SIGN, RIGHT_SIGN):
            own = ends.get((face, sign), [])
            if len({ref for _, ref, _ in own}) < 2:
                continue
            _, tips[sign], step = max(own)
            underarms[sign] = min(own)[1]
            walk = _walk_to_middle(pattern, tips[sign], step, middle)
            if walk is not None:
                necks[sign], throat[sign], edges = walk
                neckline += edges
        if tips:
            centre = tuple(dict.fromkeys(ref for ref in throat.values() if ref is not None))
            faces.append(FacePoints(face, tips, underarms, necks, centre, tuple(neckline), find_hems(pattern, face)))
    return tuple(faces)


def find_middle(pattern: Pattern) -> float:
    """Return the x of the wearer's middle [m]: halfway across the placed panels."""
    x = np.concatenate([place_points(panel, panel.points)[:, 0] for panel in pattern.panels])
    return float(x.min() + x.max()) / 2.0


def find_trunk_panels(pattern: Pattern) -> tuple[str, ...]:
    """Return the names of the panels of a bodice, and of the skirt or the legs that are cut in one with it: they have
    an armhole, or reach below one; what lies above is a collar."""
    arms = find_arm_panels(pattern)
    own = [panel for panel in pattern.panels if panel.name not in arms and find_part(panel) not in NO_TRUNK_PARTS]
    level, beside = -np.inf, set()
    for panel in own:
        height = place_points(panel, panel.points)[:, 1]
        sides = [i for i in range(len(height)) if is_armhole(pattern, EdgeRef(panel.name, i))]
        if sides:
            beside.add(panel.name)
            level = max(level, float(min(height[sides].min(), np.roll(height, -1)[sides].min())))
    reaching = {panel.name for panel in own if place_points(panel, panel.points)[:, 1].min() < level}
    return tuple(panel.name for panel in own if panel.name in beside | reaching)


def is_armhole(pattern: Pattern, ref: EdgeRef) -> bool:
    """Check whether an edge of the trunk is sewn to a sleeve, or open around an arm."""
    partner = find_sewn_partners(pattern).get(ref)
    if partner is not None:
        return partner.panel in find_arm_panels(pattern)
    return pattern.panel(ref.panel).edges[ref.edge].contour.startswith("armhole")


def find_hems(pattern: Pattern, face: Side) -> tuple[PointRef, ...]:
    """Return the points of the lower edge of a face: those of open edges that are called so, else the lowest ones; none
    of legs, nor of a hem that is not level, as a circle skirt's, whose sides are beside the wearer."""
    own = find_face_panels(pattern, face)
    if any(edge.contour.startswith(LEG_CONTOUR) for panel in own for edge in panel.edges):
        return ()
    named = {
        (panel.name, end)
        for panel in own
        for i, edge in enumerate(panel.edges)
        if edge.contour.startswith(HEM_CONTOUR)
        for end in (i, (i + 1) % len(panel.points))
    }
    heights = {(p.name, i): float(y) for p in own for i, y in enumerate(place_points(p, p.points)[:, 1])}
    low = min(heights.values(), default=0.0)
    found = sorted(named) or sorted(ref for ref, y in heights.items() if y < low + HEM_LEVEL_TOLERANCE)
    return tuple(found) if all(heights[ref] < low + MAX_HEM_RISE for ref in found) else ()


def find_face_panels(pattern: Pattern, face: Side) -> list[Panel]:
    """Return the panels of trunk, skirt and legs on a face of the wearer."""
    hidden = {*find_arm_panels(pattern)}
    return [
        panel
        for panel in pattern.panels
        if panel.name not in hidden and find_part(panel) not in HANGING_PARTS and find_side(panel) is face
    ]


def _list_armhole_runs(pattern: Pattern, name: str) -> list[tuple[int, int]]:
    """Return the first and the last control point of each run of armhole edges of a panel."""
    count = len(pattern.panel(name).points)
    own = [is_armhole(pattern, EdgeRef(name, i)) for i in range(count)]
    starts = [i for i in range(count) if own[i] and not own[i - 1]]
    runs = []
    for start in starts:
        end = start
        while own[end % count] and end - start < count:
            end += 1
        runs.append((start, end % count))
    return runs


def _walk_to_middle(
    pattern: Pattern, tip: PointRef, step: int, middle: float
) -> tuple[PointRef, PointRef | None, list[EdgeRef]] | None:
    """Walk along the outlines from a shoulder's tip, away from the armhole: over the shoulder seam, then the neckline.

    Args:
        pattern: The pattern.
        tip: Where to begin.
        step: 1 to follow the outline, -1 to go against it.
        middle: x of the wearer's middle [m].

    Returns:
        The side neck point, the neckline's point in the middle or None, and the edges between them; None where no
        shoulder seam begins there.
    """
    trunk, partners = set(find_trunk_panels(pattern)), find_sewn_partners(pattern)
    (name, at), face = tip, find_side(pattern.panel(tip[0]))
    neck: PointRef | None = None
    neckline: list[EdgeRef] = []
    for _ in range(MAX_WALKED_EDGE_COUNT):
        panel = pattern.panel(name)
        count = len(panel.points)
        edge = at if step > 0 else (at - 1) % count
        partner = partners.get(EdgeRef(name, edge))
        in_trunk = partner is not None and partner.panel in trunk
        if in_trunk and partner is not None and find_side(pattern.panel(partner.panel)) is face and (name, at) != tip:
            if partner.panel == name:
                break
            name, other = partner.panel, len(pattern.panel(partner.panel).points)
            at = (partner.edge + 1) % other if step > 0 else partner.edge
            continue
        if neck is None and not in_trunk:
            if (name, at) == tip:
                return None
            neck = (name, at)
        if neck is not None and abs(_place(pattern, (name, at))[0] - middle) < MIDDLE_REACH:
            return neck, (name, at), neckline
        if neck is not None:
            neckline.append(EdgeRef(name, edge))
        at = (at + step) % count
    return None if neck is None else (neck, None, neckline)


def _place(pattern: Pattern, ref: PointRef) -> np.ndarray:
    """Return a control point as it is placed [m], shape [3]."""
    panel = pattern.panel(ref[0])
    placed: np.ndarray = place_points(panel, panel.points[ref[1]])
    return placed
