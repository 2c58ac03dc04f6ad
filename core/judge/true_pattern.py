"""A true pattern: panels and seams as their author drew them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class TruePanel:
    """Describe one panel of a true pattern as its author drew it: the outline [m], shape [n, 2], of either orientation,
    and a polyline [m] of each edge in the author's order, ends included; none if unknown."""

    name: str
    outline: np.ndarray
    edges: tuple[np.ndarray, ...] = ()


@dataclass(frozen=True)
class TrueSeam:
    """Describe one seam of a true pattern: the author's panel name and edge index of both sides."""

    a: tuple[str, int]
    b: tuple[str, int]


@dataclass(frozen=True)
class TruePattern:
    """Describe a true pattern: panels and seams."""

    panels: tuple[TruePanel, ...]
    seams: tuple[TrueSeam, ...] = ()
