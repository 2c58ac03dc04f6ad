"""Draft vents: slits of a hem at the side seams or at the centre back (W. Aldrich, Metric Pattern Cutting for Women's
Wear, vents). The hem's border goes up one edge of a vent and down the other. Both edges meet where they are drawn; what
laps under is added to the cut pieces, as a button stand is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..curves import edge_length, place_on_chord, split_edge
from ..outline import VENT_LABEL, Outline, Stroke, halve, mirror
from ..pattern import Edge, Panel
from .cut import Cut, HemBand, Legs, PartsConflict, Skirt, Vent

SKIRT_VENT_LENGTH = 0.18
"""Length of a vent of a skirt or a dress [m]: 18 to 20 cm in a skirt to the knee, for a free step (Aldrich)."""

TOP_VENT_LENGTHS = {Vent.SIDES: 0.08, Vent.BACK: 0.12}
"""Length of a vent of a top [m]: of a shirt's side slits, 5 to 10 cm, and of a jacket's back, to below the waist."""

VENTED_SKIRTS = (Skirt.STRAIGHT, Skirt.PENCIL, Skirt.A_LINE)
"""Skirts that vents are cut into; others have room for a step without."""

BACK_SEAM = "centre.back"
"""Beginning of the label of the seam above a centre back vent."""


def check_vent(cut: Cut) -> None:
    """Check that a cut has a hem that a vent can open.

    Raises:
        PartsConflict: where it has none.
    """
    if cut.vent is Vent.NONE:
        return
    if cut.legs is not Legs.NONE:
        raise PartsConflict("a vent is in the hem of a skirt or a top; choose vent=none for legs.")
    if cut.hem_band is not HemBand.NONE:
        raise PartsConflict("a band closes the hem that a vent would open; choose hem_band=none, or vent=none.")
    if cut.skirt is not Skirt.NONE and cut.skirt not in VENTED_SKIRTS:
        raise PartsConflict(f"a {cut.skirt} skirt needs no vent; choose skirt=straight, pencil or a-line.")


def cut_back(cut: Cut, name: str, outline: Outline) -> list[tuple[str, Outline]]:
    """Return a back that ends at the hem, in two halves where a vent is at its centre.

    Args:
        cut: The garment's.
        name: The piece's.
        outline: Symmetric about the centre.
    """
    if cut.vent is not Vent.BACK:
        return [(name, outline)]
    left = halve(outline, Stroke((0.0, 0.0), label=f"{BACK_SEAM}.{name}"))
    return [(f"{name}_left", left), (f"{name}_right", mirror(left))]


def open_vents(cut: Cut, panels: list[Panel]) -> list[Panel]:
    """Return panels whose side seams or centre back seam are open above the hem for the length of a vent."""
    if cut.vent is Vent.NONE:
        return panels
    length = SKIRT_VENT_LENGTH if cut.skirt is not Skirt.NONE else TOP_VENT_LENGTHS[cut.vent]
    seam = "side." if cut.vent is Vent.SIDES else BACK_SEAM
    return [_open(panel, seam, length) for panel in panels]


def _open(panel: Panel, seam: str, length: float) -> Panel:
    """Return a panel whose edges of a seam, by the beginning of their labels, are open for a length [m] from the
    hem."""
    points: list[np.ndarray] = []
    edges: list[Edge] = []
    notches: list[tuple[int, float]] = []
    count = len(panel.edges)
    for i, edge in enumerate(panel.edges):
        start, end = panel.points[i], panel.points[(i + 1) % count]
        rises, falls = (panel.edges[k % count].contour == "hem" for k in (i - 1, i + 1))
        first, share = 0.0, 1.0  # the sewn part
        if edge.label.startswith(seam) and (rises or falls):
            open_share = length / edge_length(panel, i)
            first, share = (open_share if rises else 0.0), 1.0 - open_share
            cut, lower, upper = split_edge(edge, open_share if rises else share)
            slit = replace(lower if rises else upper, label=f"{VENT_LABEL}.{edge.label}", contour="hem")
            sewn = upper if rises else lower
            points += [start, place_on_chord(cut[None], start, end)[0]]
            edges += [slit, sewn] if rises else [sewn, slit]
        else:
            points.append(start)
            edges.append(edge)
        number = len(edges) - (2 if falls and share < 1.0 else 1)
        places = [(at - first) / share for k, at in panel.notches if k == i]
        notches += [(number, at) for at in places if 0.0 < at < 1.0]
    return replace(panel, points=np.array(points), edges=tuple(edges), notches=tuple(notches))
