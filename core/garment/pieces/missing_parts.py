"""List what a wearable garment needs beside its net panels."""

from __future__ import annotations

from collections.abc import Collection

from ..parts.hoods import HOOD_LABEL
from .doubled import is_folded_double
from .piece import EdgeUse, Material, Piece


def list_missing(
    pieces: Collection[Piece], finished: Collection[EdgeUse] = (), turned: bool = False
) -> tuple[str, ...]:
    """Return what is missing for a wearable garment, one line each.

    Args:
        pieces: Of the garment.
        finished: Uses of the edges for which there are ribs, facings or bindings.
        turned: True where it has a collar or lapels that turn over, and so show their other side.
    """
    doubled = [piece for piece in pieces if is_folded_double(place.panel for place in piece.places)]
    uses = {edge.use for piece in pieces if piece not in doubled for edge in piece.edges} - {*finished}
    elastic = any("elastic" in piece.net.label for piece in pieces)
    is_at_waist = EdgeUse.WAIST in uses or any("band" in piece.net.label for piece in pieces if piece not in doubled)
    lines = []
    if turned:
        lines.append("turn of the cloth: trim the under side of what turns over by 2 to 3 mm; facing of the back neck")
    elif EdgeUse.NECK in uses and any(piece.net.label == HOOD_LABEL for piece in pieces):
        lines.append("tape over the hood's neck seam")
    elif EdgeUse.NECK in uses:
        lines.append("finish of the neck: rib, binding or facing")
    if EdgeUse.ARMHOLE in uses:
        lines.append("finish of the armholes: binding or facing")
    if EdgeUse.FRONT in uses:
        lines.append("facings of the front edges, and their interfacing")
    if EdgeUse.BUTTONS in uses:
        lines.append("facings and interfacing of the button stands")
    if EdgeUse.WRAP in uses:
        lines.append("hem of the inner front's lower edge, or its place in the waist seam; ties at both fronts' ends")
    if EdgeUse.VENT in uses:
        lines.append("stay at the upper end of each vent; lining or binding of its lap")
    if EdgeUse.PLACKET in uses:
        lines.append("binding, or placket, of each sleeve's slit")
    if is_at_waist and not elastic:
        lines.append("closure at the waist: zip and button, or elastic")
    if EdgeUse.OPEN in uses:
        lines.append("finish of unnamed open edges: hem, binding or facing")
    if any(piece.material is not Material.RIB for piece in doubled):
        lines.append("inner layer of curved ribs: each is drawn as worn")
    lines += ["pockets, lining of the body, labels", "true size name: the size is given by girths"]
    return tuple(lines)
