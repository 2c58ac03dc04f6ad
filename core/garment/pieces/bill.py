"""The bill of material of a garment: cloth by width, ribs, interfacing, closures, thread."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..curves import edge_length
from ..parts.hoods import HOOD_LABEL
from .layout import lay_on_cloth
from .piece import EdgeUse, Material, Piece, PieceSet, SeamWalk

CLOTH_WIDTHS = (0.9, 1.15, 1.4, 1.5)
"""Usual usable widths of cloth [m]: 36, 45, 55 and 60 in."""

RIB_CLOTH_WIDTH, INTERFACING_WIDTH = 1.0, 0.9
"""Usual widths of rib, a tube cut open, and of interfacing [m]."""

BUTTON_SPACING = 0.085
"""Distance between the buttons of a front [m]: 8 to 9 cm on shirts."""

BUTTON_INSET = 0.015
"""Distance of the first and the last button from the ends of their edge [m]: a button's width."""

ELASTIC_OVERLAP, CORD_EXCESS = 0.02, 0.5
"""Length by which elastic overlaps, and by which a hood's cord is longer than its casing [m]."""

LOCKSTITCH_THREAD_RATIO, OVERLOCK_THREAD_RATIO = 2.5, 14.0
"""Ratio of thread to seam of stitch types 301 and 504 of ISO 4915 (Coats, thread consumption guide)."""

THREAD_WASTE_FACTOR = 1.15
"""Factor for thread that is cut off at ends (Coats: 10 to 15 %)."""


@dataclass(frozen=True)
class BillLine:
    """Describe one line of a bill of material.

    Attributes:
        item: What is needed, `cloth 140 cm wide`.
        amount: How much.
        unit: `m`, or an empty text for a number of things.
    """

    item: str
    amount: float
    unit: str

    def describe(self) -> str:
        """Return the line as text."""
        return f"{self.item}: {self.amount:.2f} m" if self.unit else f"{self.item}: {self.amount:.0f}"


def list_materials(pieces: PieceSet) -> tuple[BillLine, ...]:
    """Return the bill of material of a garment. Cloth, rib and interfacing are lengths of a simple layout, an upper
    bound; where a piece is wider than cloth of a width, that width is left out."""
    cut = pieces.cut_pieces
    lines = []
    for width in CLOTH_WIDTHS:
        lines += _measure_length(f"cloth {100 * width:.0f} cm wide", cut, width)
    ribs = tuple(replace(piece, material=Material.CLOTH) for piece in cut if piece.material is Material.RIB)
    lines += _measure_length(f"rib {100 * RIB_CLOTH_WIDTH:.0f} cm wide", ribs, RIB_CLOTH_WIDTH)
    inner = tuple(replace(piece, quantity=piece.interfaced) for piece in cut if piece.interfaced)
    lines += _measure_length(f"interfacing {100 * INTERFACING_WIDTH:.0f} cm wide", inner, INTERFACING_WIDTH)
    return (*lines, *_list_closures(pieces), *_list_threads(pieces))


def _measure_length(item: str, pieces: tuple[Piece, ...], width: float) -> list[BillLine]:
    length = lay_on_cloth(pieces, width).length if pieces else float("inf")
    return [BillLine(item, length, "m")] if np.isfinite(length) else []


def _list_closures(pieces: PieceSet) -> list[BillLine]:
    lines = []
    for use in (EdgeUse.ZIP, EdgeUse.BUTTONS):
        for name, seams in _group(pieces.seams, pieces, use).items():
            count = 2 if seams[0].is_paired else 1
            length = sum(seam.lengths[0] for seam in seams) / count
            if use is EdgeUse.ZIP:
                lines.append(BillLine(name, length, "m"))
            else:
                each = int(np.ceil(max(length - 2.0 * BUTTON_INSET, 0.0) / BUTTON_SPACING)) + 1
                lines.append(BillLine(name, float(count * each), ""))
    waist = sum(
        edge_length(piece.net, i) * (1 if edge.mirror is None else 2)
        for piece in pieces.pieces
        for i, edge in enumerate(piece.edges)
        if edge.use is EdgeUse.WAIST or (edge.use is EdgeUse.FACED and "elastic" in piece.net.label)
    )
    if waist:
        lines.append(BillLine("elastic for the waist", waist + ELASTIC_OVERLAP, "m"))
    casing = sum(seam.lengths[1] for seam in pieces.finishes if _is_of_hood(pieces, seam))
    if casing:
        lines.append(BillLine("cord for the hood", casing + CORD_EXCESS, "m"))
    return lines


def _is_of_hood(pieces: PieceSet, seam: SeamWalk) -> bool:
    return all(pieces.cut_pieces[side.piece].net.label == HOOD_LABEL for side in seam.sides[0])


def _group(seams: tuple[SeamWalk, ...], pieces: PieceSet, use: EdgeUse) -> dict[str, list[SeamWalk]]:
    """Return the seams with an edge of some use by their names."""
    found: dict[str, list[SeamWalk]] = {}
    for seam in seams:
        if pieces.pieces[seam.sides[0][0].piece].edges[seam.sides[0][0].edge].use is use:
            found.setdefault(seam.name, []).append(seam)
    return found


def _list_threads(pieces: PieceSet) -> list[BillLine]:
    """Return the thread of all seams and hems: a lockstitch, and an overlock of both allowances; of a knit, which is
    overlocked together, one overlock, and a lockstitch at its hems."""
    seams = sum(max(seam.lengths) for seam in (*pieces.seams, *pieces.finishes))
    hems = sum(
        edge_length(piece.net, i) * (1 if edge.mirror is None else 2)
        for piece in pieces.pieces
        for i, edge in enumerate(piece.edges)
        if edge.use in (EdgeUse.HEM, EdgeUse.CUFF, EdgeUse.LEG, EdgeUse.WAIST)
    )
    plain, overlocked = (hems, seams + hems) if pieces.is_stretchy else (seams + hems, 2.0 * seams + hems)
    return [
        BillLine("thread, lockstitch", THREAD_WASTE_FACTOR * LOCKSTITCH_THREAD_RATIO * plain, "m"),
        BillLine("thread, overlock", THREAD_WASTE_FACTOR * OVERLOCK_THREAD_RATIO * overlocked, "m"),
    ]
