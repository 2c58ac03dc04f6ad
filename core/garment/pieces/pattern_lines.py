"""The lines of a pattern that a tailor names: each seam, and each open edge of the sewn garment, with its side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from ..curves import edge_length
from ..garment import Garment
from ..pattern import EdgeRef, Pattern
from .seam_names import is_dart, name_seam

OPEN_LINE_NAMES: Mapping[str, str] = MappingProxyType({
    "neck": "neckline", "waist": "waist", "hem": "hem", "front": "front edge", "cuff": "sleeve hem",
    "armhole": "armhole edge", "leg": "leg hem", "placket": "sleeve slit", "wrap": "wrap edge",
})  # fmt: skip
"""Names of open edges by the first word of the sewn garment's contour that they are on."""


@dataclass(frozen=True)
class PatternLine:
    """Describe a seam, or an open edge of the sewn garment.

    Attributes:
        name: As a tailor says it: `armhole seam`, `hem`.
        side: `left` or `right` of the wearer; an empty text where it has none.
        edges: Of an open edge all; of a seam those of its first side.
        others: Of a seam those of its second side, in the same order; of an open edge none.
    """

    name: str
    side: str
    edges: tuple[EdgeRef, ...]
    others: tuple[EdgeRef, ...] = ()

    @property
    def is_open(self) -> bool:
        """Return whether it is an open edge."""
        return not self.others

    def find_contour(self, pattern: Pattern) -> str:
        """Return the name of the contour that an open edge is on; an empty text for a seam."""
        first = self.edges[0]
        return pattern.panel(first.panel).edges[first.edge].contour

    def measure_length(self, pattern: Pattern) -> float:
        """Return its length on the flat cloth [m]; of a seam the mean of both sides."""
        sides = [side for side in (self.edges, self.others) if side]
        return sum(edge_length(pattern.panel(ref.panel), ref.edge) for side in sides for ref in side) / len(sides)

    def find_nodes(self, garment: Garment) -> np.ndarray:
        """Return the nodes on it of the pattern's mesh, int64, shape [n]."""
        return np.unique(np.concatenate([garment.uv_node[garment.edge_uv[ref]] for ref in self.edges]))

    def sample(self, garment: Garment, spacing: float = 0.002) -> np.ndarray:
        """Return points along it on a garment's mesh [m], shape [n, 3], at most `spacing` apart."""
        found = []
        for ref in self.edges:
            path = garment.nodes[garment.uv_node[garment.edge_uv[ref]]]
            for start, end in pairwise(path):
                count = int(np.ceil(np.linalg.norm(end - start) / spacing)) + 1
                found.append(start + np.linspace(0.0, 1.0, count)[:, None] * (end - start))
        return np.concatenate(found)


def list_lines(pattern: Pattern) -> tuple[PatternLine, ...]:
    """Return the lines of a pattern: its seams but darts and those without a name, then its open edges. Seams of one
    name and side are one line, and so are the edges of one contour."""
    seams: dict[tuple[str, str], list[tuple[EdgeRef, EdgeRef]]] = {}
    for seam in pattern.seams:
        named = name_seam(pattern, seam)
        if named.name and not is_dart(pattern, seam):
            seams.setdefault((named.name, named.side), []).append((seam.a, seam.b))
    contours: dict[str, list[EdgeRef]] = {}
    for panel in pattern.panels:
        for i, edge in enumerate(panel.edges):
            if edge.contour:
                contours.setdefault(edge.contour, []).append(EdgeRef(panel.name, i))
    found = []
    for (name, side), pairs in seams.items():
        firsts, seconds = zip(*pairs, strict=True)
        found.append(PatternLine(name, side, firsts, seconds))
    for contour, refs in contours.items():
        word, _, side = contour.partition(".")
        found.append(PatternLine(OPEN_LINE_NAMES.get(word, word), side, tuple(refs)))
    return tuple(found)
