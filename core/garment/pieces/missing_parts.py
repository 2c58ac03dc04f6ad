"""List what a wearable garment needs beside its net panels."""

from __future__ import annotations

from collections.abc import Collection

from .piece import EdgeUse


def list_missing(uses: Collection[EdgeUse], banded: bool) -> tuple[str, ...]:
    """Return what is missing for a wearable garment, one line each.

    Args:
        uses: Uses of the garment's edges.
        banded: True where it has a waistband of its own.
    """
    lines = []
    if EdgeUse.NECK in uses:
        lines.append("finish of the neck: rib, binding or facing")
    if EdgeUse.ARMHOLE in uses:
        lines.append("finish of the armholes: binding or facing")
    if EdgeUse.FRONT in uses:
        lines.append("facings of the front edges, and their interfacing")
    if EdgeUse.ZIP in uses:
        lines.append("zip at the centre front, as long as the seam there")
    if EdgeUse.BUTTONS in uses:
        lines.append("buttons and buttonholes at the centre front, facings and interfacing of the button stands")
    if EdgeUse.WAIST in uses and banded:
        lines.append("facing or inner half of the waistband, and its interfacing")
    if EdgeUse.WAIST in uses:
        lines.append("closure at the waist: zip and button, or elastic")
    if EdgeUse.OPEN in uses:
        lines.append("finish of unnamed open edges: hem, binding or facing")
    lines += ["closures elsewhere, pockets, linings, labels", "true size name: the size is given by girths"]
    return tuple(lines)
