"""Find pieces that are worn double, and unfold those that are cut in one with their inner half."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from ...geometry.geometry import unit
from ..curves import edge_points, mirror_edge, reverse_edge
from ..pattern import Panel, Pattern
from .piece import SEWN_EDGE_USES, EdgeUse, PieceEdge

FOLDED_PANEL_WORDS = ("rib", "turtleneck")
"""Words of the names of panels that are drawn as worn, and worn folded at their free edge."""

LINED_PANEL_WORDS = ("cuff", "band", "wb", "collar")
"""Parts of labels and names of panels that have an inner half of the same shape, sewn to their free edges."""

MAX_FOLD_BEND = 1e-3
"""Largest distance of a free edge from the line between its ends at which a strip is folded along it [m]: the accuracy
of cutting; a curve cannot be folded."""


def is_folded_double(panels: Iterable[str]) -> bool:
    """Check whether a piece of some panels is worn folded in two, as a knitted rib is."""
    words = {word for name in panels for word in re.split(r"[\W_]+", name.lower())}
    return any(word in words for word in FOLDED_PANEL_WORDS)


def is_lined(pattern: Pattern, panels: Iterable[str]) -> bool:
    """Check whether a piece of some panels has an inner half: a cuff, a waistband or a collar, but no rib."""
    names = tuple(panels)
    text = " ".join((*names, *(pattern.panel(name).label for name in names))).lower()
    return not is_folded_double(names) and any(word in text for word in LINED_PANEL_WORDS)


@dataclass(frozen=True)
class Unfolded:
    """Describe a piece with its inner half: its outline, its edges, of each the edge of the piece as worn that it is
    or mirrors, whether it is the mirrored one, and the line between both halves [m], shape [2, 2]."""

    net: Panel
    edges: tuple[PieceEdge, ...]
    origins: tuple[tuple[int, bool], ...]
    fold: np.ndarray


def unfold_double(net: Panel, edges: tuple[PieceEdge, ...]) -> Unfolded | None:
    """Return a piece with its mirror image at its free edge; None where it has none that is one straight line.

    Args:
        net: The piece as it is worn.
        edges: What each of its edges is.
    """
    count = len(edges)
    is_free = [edge.use not in (*SEWN_EDGE_USES, EdgeUse.DART) for edge in edges]
    starts = [i for i in range(count) if is_free[i] and not is_free[i - 1]]
    if len(starts) != 1:
        return None
    free = [(starts[0] + k) % count for k in range(sum(is_free))]
    kept = [(free[-1] + 1 + k) % count for k in range(count - len(free))]
    first, last = net.points[free[0]], net.points[(free[-1] + 1) % count]
    along = unit(last - first)
    across = np.array([-along[1], along[0]])
    bend = max(float(np.abs((edge_points(net, i, 16) - first) @ across).max()) for i in free)
    if bend > MAX_FOLD_BEND:
        return None
    outer = [*(net.points[i] for i in kept), first]
    inner = [point - 2.0 * ((point - first) @ across) * across for point in outer[-2:0:-1]]
    origins = (*((i, False) for i in kept), *((i, True) for i in kept[::-1]))
    drawn = tuple(
        replace(reverse_edge(mirror_edge(net.edges[i])), label="", contour="") if mirrored else net.edges[i]
        for i, mirrored in origins
    )
    listed = tuple(PieceEdge(edges[i].use, edges[i].width, None) if mirrored else edges[i] for i, mirrored in origins)
    return Unfolded(
        replace(net, points=np.array([*outer, *inner]), edges=drawn), listed, origins, np.array([last, first])
    )
