"""Name the contours of a worn garment of which the pattern is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...body.body import Body
from ...garment.garment import Garment
from ...garment.outline import PLACKET_CONTOUR
from ...garment.parts.wraps import WRAP_LABEL
from ...scan.contours.contours import arc_length, name_contours
from ...scan.contours.loop import find_loops
from ...scan.contours.target import Contour


def name_worn_contours(garment: Garment, nodes: np.ndarray, body: Body) -> tuple[Contour, ...]:
    """Return the open contours of a garment whose nodes are at positions [m], shape [node_count, 3], named on a body.

    The neckline of a wrap is the open curve of both front edges and the back neck. What lies below the outer front
    belongs to the same border, and is left out; it is not trusted, since a scan shows the front edges only to where
    they cross.
    """
    contours, _ = name_contours(nodes, garment.faces, body)
    covered = _find_edge_nodes(garment, WRAP_LABEL)
    return tuple(_leave_out(contour, covered, nodes) for contour in contours) if len(covered) else contours


def count_borders(garment: Garment) -> int:
    """Count the borders that surround a part of a wearer's body: all but those of slits above buttoned cuffs."""
    slit = _find_edge_nodes(garment, PLACKET_CONTOUR)
    return sum(not np.isin(loop, slit).all() for loop in find_loops(garment.faces))


def _find_edge_nodes(garment: Garment, contour: str) -> np.ndarray:
    """Return the nodes on the edges of contours whose name begins so, ascending."""
    lines = [
        garment.uv_node[line]
        for ref, line in garment.edge_uv.items()
        if garment.pattern.panel(ref.panel).edges[ref.edge].contour.startswith(contour)
    ]
    found: np.ndarray = np.unique(np.concatenate([np.zeros(0, np.int64), *lines]))
    return found


def _leave_out(contour: Contour, covered: np.ndarray, nodes: np.ndarray) -> Contour:
    """Return a closed contour without its one stretch of covered nodes but the ends, as an open curve."""
    loop = contour.vertices
    is_covered = np.isin(loop, covered)
    if not is_covered.any() or is_covered.all() or not contour.is_closed:
        return contour
    last = int(np.flatnonzero(is_covered & ~np.roll(is_covered, -1))[0])
    loop, is_covered = np.roll(loop, -last), np.roll(is_covered, -last)
    kept = np.concatenate([loop[:1], loop[~is_covered], loop[np.flatnonzero(~is_covered)[-1] + 1 :][:1]])
    return replace(contour, vertices=kept, length=arc_length(nodes[kept]), trusted=False, is_closed=False)
