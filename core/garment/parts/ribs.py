"""Draft ribs: knitted bands around a hem, a sleeve's end or a neck. A rib is a straight strip, shorter than the edge to
which it is sewn, and stretched as it is sewn (H. Joseph-Armstrong, Patternmaking for Fashion Design, knits). Each is
drawn as it is worn, and cut twice as wide, folded at its free edge."""

from __future__ import annotations

from dataclasses import replace

from ..curves import edge_length
from ..outline import Outline, Stroke, place_panel
from ..pattern import EdgeRef, Panel
from .cut import Cut
from .fronts import cut_front

RIB_RATIO = 0.85
"""Ratio of the length of a rib to that of the edge it is sewn to: ribs are cut at 80 to 85 % of it."""

HEM_RIB_WIDTH = 0.06
"""Width of a rib around the hem of a top, as worn [m]: that of a sweatshirt or a bomber jacket, 5 to 7 cm."""


def sew_hem_rib(cut: Cut, panels: list[Panel], height: float) -> list[Panel]:
    """Return the panels of a top with its hem sewn to a rib, and the front and back of that; the front is cut at the
    centre as the top's.

    Args:
        cut: The garment's.
        panels: Of the top; its hems are level, each one edge.
        height: Of the draft's origin [m].
    """
    hems = {
        panel.name: EdgeRef(panel.name, i)
        for panel in panels
        for i, edge in enumerate(panel.edges)
        if edge.contour == "hem"
    }
    sewn = [_sew(panel, hems[panel.name].edge) if panel.name in hems else panel for panel in panels]
    for face in ("front", "back"):
        uppers = sorted((panel for panel in panels if panel.name in hems and face in panel.name), key=_rank)
        name, outline = f"hem_rib_{face}", _draw_hem_rib(uppers, hems)
        pieces = cut_front(cut, name, outline) if face == "front" else [(name, outline)]
        sewn += [place_panel(part, drawn, height, label="band") for part, drawn in pieces]
    return sewn


def _rank(panel: Panel) -> int:
    """Return the rank of a panel in its face, from the wearer's left to the right."""
    return {"left": 0, "right": 2}.get(panel.name.split("_")[-1], 1)


def _label(panel: Panel) -> str:
    """Return the label of the seam between a panel and the rib below it."""
    return ".".join(("hemrib", *panel.name.split("_")))


def _sew(panel: Panel, hem: int) -> Panel:
    edges = list(panel.edges)
    edges[hem] = replace(edges[hem], label=_label(panel), contour="")
    return replace(panel, edges=tuple(edges))


def _draw_hem_rib(uppers: list[Panel], hems: dict[str, EdgeRef]) -> Outline:
    """Draw front or back of a hem's rib, symmetric about the middle, its upper edge divided as the hem."""
    lengths = [RIB_RATIO * edge_length(panel, hems[panel.name].edge) for panel in uppers]
    half = sum(lengths) / 2
    high = float(uppers[0].points[hems[uppers[0].name].edge][1])
    low = high - HEM_RIB_WIDTH
    strokes, x = [Stroke((half, high), label="hemribside.left")], half
    for panel, length in zip(uppers, lengths, strict=True):
        x -= length
        strokes.append(Stroke((x, high), label=_label(panel)))
    strokes[-1] = replace(strokes[-1], end=(-half, high))
    strokes += [Stroke((-half, low), label="hemribside.right"), Stroke((half, low), contour="hem")]
    return Outline((half, low), tuple(strokes))
