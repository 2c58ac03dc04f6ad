"""List what a wearable garment needs beside its net panels."""

from __future__ import annotations

from collections.abc import Collection

from ..parts.hoods import HOOD_LABEL
from .piece import EdgeUse, Piece

DOUBLED_PANEL_WORDS = ("rib", "turtleneck")
"""Words of the names of panels that are drawn as worn, and worn folded at their free edge."""


def is_doubled(piece: Piece) -> bool:
    """Check whether a piece is worn folded in two, and drawn once."""
    words = {word for place in piece.places for word in place.panel.split("_")}
    return any(word in words for word in DOUBLED_PANEL_WORDS)


def list_missing(pieces: Collection[Piece], turned: bool = False) -> tuple[str, ...]:
    """Return what is missing for a wearable garment, one line each. The free edge of a doubled piece is folded.

    Args:
        pieces: Of the garment.
        turned: True where it has a collar or lapels that turn over, and so show their other side.
    """
    uses = {edge.use for piece in pieces if not is_doubled(piece) for edge in piece.edges}
    bands = [piece.net.label for piece in pieces if _is_sewn_to_a_waist(piece)]
    banded = any("band" in label for label in bands)
    elastic = any("elastic" in label for label in bands)
    lines = []
    if turned:
        lines.append(
            "upper side of what turns over: upper collar, facings with lapels; interfacing of both and of a stand"
        )
    elif EdgeUse.NECK in uses and any(piece.net.label == HOOD_LABEL for piece in pieces):
        lines.append("facing or casing of the hood's face edge, drawstring, and tape over the neck seam")
    elif EdgeUse.NECK in uses:
        lines.append("finish of the neck: rib, binding or facing")
    if EdgeUse.ARMHOLE in uses:
        lines.append("finish of the armholes: binding or facing")
    if EdgeUse.FRONT in uses:
        lines.append("facings of the front edges, and their interfacing")
    if EdgeUse.ZIP in uses:
        lines.append("zip at the centre front, as long as the seam there")
    if EdgeUse.BUTTONS in uses:
        lines.append("buttons and buttonholes, facings and interfacing of the button stands")
    if EdgeUse.WRAP in uses:
        lines.append("hem of the inner front's lower edge, or its place in the waist seam; ties at both fronts' ends")
    if EdgeUse.VENT in uses:
        lines.append("stay at the upper end of each vent; lining or binding of its lap")
    if EdgeUse.PLACKET in uses:
        lines.append("binding, or placket, of each sleeve's slit")
    if EdgeUse.WAIST in uses and banded:
        inner = "elastic" if elastic else "interfacing"
        lines.append(f"facing or inner half of the waistband, and its {inner}")
    if EdgeUse.WAIST in uses and not elastic:
        lines.append("closure at the waist: zip and button, or elastic")
    if EdgeUse.OPEN in uses:
        lines.append("finish of unnamed open edges: hem, binding or facing")
    if any(map(is_doubled, pieces)):
        lines.append("inner layer of ribs: each is drawn as worn; cut it twice as wide, and fold it at its free edge")
    lines += ["closures elsewhere, pockets, linings, labels", "true size name: the size is given by girths"]
    return tuple(lines)


def _is_sewn_to_a_waist(piece: Piece) -> bool:
    """Check whether a piece has a waist's free edge and seams, gathered ones too."""
    uses = {edge.use for edge in piece.edges}
    return EdgeUse.WAIST in uses and bool(uses & {EdgeUse.SEAM, EdgeUse.GATHERED})
