"""Find where a line of a garment crosses a seam and has to be smooth: necklines, armholes, caps, waists, hems."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..creases import is_crease
from ..curves import edge_length
from ..fairness import MAX_SMOOTH_CORNER_ANGLE, MIN_DIRECTED_EDGE_LENGTH, SmoothJoin, boundary_edges, interior_angles
from ..outline import is_slit_side
from ..panel_parts import find_arm_panels, find_part
from ..pattern import EdgeRef, Pattern
from ..seams import find_sewn_partners
from .pairing import find_twins
from .piece import EdgeUse

LEVEL_CONTOURS = (EdgeUse.HEM, EdgeUse.LEG, EdgeUse.WAIST, EdgeUse.CUFF)
"""Open contours without a point at the middle of the wearer; a neckline may be a V there."""


def find_crossed_joins(pattern: Pattern) -> tuple[SmoothJoin, ...]:
    """Find the joins of a pattern at which a line continues smoothly across the end of a seam, or of a dart's mouth.

    The two edges beside a seam's end are one line where they are

    - open, of one contour, and no sides of a vent or a slit;
    - sewn to one panel whose corner between is wider than theirs (a yoke above a princess seam, a sleeve in one piece
      at the shoulder); that panel's corner is a join too;
    - of one part of the garment and sewn to another part (a cap at the underarm, a waist at a side seam);
    - sewn to their mirror images (the crotch at an inseam).

    Where four panels of one part meet, nothing tells which line is straight. A neckline may have a point at the middle.
    """
    sewn, twins, found = find_sewn_partners(pattern), find_twins(pattern), []
    for join in _list_seam_ends(pattern):
        first, last = boundary_edges(pattern, join)
        if any(edge_length(pattern.panel(ref.panel), ref.edge) < MIN_DIRECTED_EDGE_LENGTH for ref in (first, last)):
            continue
        if first not in sewn and last not in sewn:
            is_at_middle = twins.get(first) == last and join.seam[0].panel != join.seam[1].panel
            if _is_one_contour(pattern, first, last, is_at_middle) and not _is_slit(pattern, join):
                found.append(join)
        elif first in sewn and last in sewn and sewn[first] != last and not is_crease(pattern, first):
            other = sewn[first], sewn[last]
            opposite = _corner_between(pattern, *other)
            if opposite is not None:
                if _is_widest(pattern, opposite, join):
                    found += [join, SmoothJoin((opposite,))]
            elif _separates_parts(pattern, join, other) or (twins.get(first), twins.get(last)) == other:
                found.append(join)
    return tuple(dict.fromkeys(found))


def _list_seam_ends(pattern: Pattern) -> Iterator[SmoothJoin]:
    """Yield both ends of each flat seam; gathers and creases have no corner that could be laid together."""
    for seam in pattern.seams:
        if seam.gathered or is_crease(pattern, seam.a):
            continue
        (a0, a1), (b0, b1) = (
            ((ref.panel, ref.edge), (ref.panel, (ref.edge + 1) % len(pattern.panel(ref.panel).points)))
            for ref in (seam.a, seam.b)
        )
        for corners in ((a0, b1), (a1, b0)) if seam.reversed else ((a0, b0), (a1, b1)):
            if corners[0] != corners[1]:
                yield SmoothJoin(corners, (seam.a, seam.b))


def _is_one_contour(pattern: Pattern, first: EdgeRef, last: EdgeRef, is_at_middle: bool) -> bool:
    """Check whether two open edges are one line."""
    one, other = (pattern.panel(ref.panel).edges[ref.edge] for ref in (first, last))
    if one.contour != other.contour or is_slit_side(one) or is_slit_side(other):
        return False
    return not is_at_middle or one.contour.split(".")[0] in LEVEL_CONTOURS


def _is_slit(pattern: Pattern, join: SmoothJoin) -> bool:
    """Check whether both lines beside a seam's end go on along it: the seam is open from there on."""
    angles = [float(interior_angles(pattern.panel(name))[index]) for name, index in join.corners]
    return all(abs(angle - np.pi) < MAX_SMOOTH_CORNER_ANGLE for angle in angles)


def _corner_between(pattern: Pattern, first: EdgeRef, last: EdgeRef) -> tuple[str, int] | None:
    """Return the control point at which two edges of one panel meet; None where they do not."""
    count = len(pattern.panel(first.panel).points)
    if first.panel == last.panel:
        for one, other in ((first, last), (last, first)):
            if (one.edge + 1) % count == other.edge:
                return first.panel, other.edge
    return None


def _is_widest(pattern: Pattern, opposite: tuple[str, int], join: SmoothJoin) -> bool:
    """Check whether a panel's corner is wider than those of a join."""
    own, *others = (float(interior_angles(pattern.panel(name))[index]) for name, index in (opposite, *join.corners))
    return bool(own > np.nanmax(others)) if np.isfinite(others).any() else False


def _separates_parts(pattern: Pattern, join: SmoothJoin, others: tuple[EdgeRef, EdgeRef]) -> bool:
    """Check whether a join is within one part of the garment, and its line sewn to another part."""
    own = {_find_part(pattern, name) for name, _ in join.corners}
    other = {_find_part(pattern, ref.panel) for ref in others}
    return len(own) == len(other) == 1 and own != other


def _find_part(pattern: Pattern, name: str) -> str:
    """Return the part of a garment that a panel belongs to, by words or as it lies on an arm."""
    return find_part(pattern.panel(name)) or ("sleeve" if name in find_arm_panels(pattern) else "")
