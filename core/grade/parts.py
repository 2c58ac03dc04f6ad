"""Which panels of a pattern belong together: seams counted as the eye counts them."""

from __future__ import annotations

from collections import Counter

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ..pattern import Panel, Pattern, edge_length
from .flattening import SHORT


def count_seams(pattern: Pattern) -> Counter[tuple[str, str]]:
    """Count the seams between each two panels, by their names in order.

    Edges that are sewn to the same other panel, and between which only darts or edges shorter than `SHORT` lie, are one
    seam: programs cut a waist seam into as many edges as there are darts in it.
    """
    partner = {}
    for seam in pattern.seams:
        partner[seam.a.panel, seam.a.edge] = seam.b.panel
        partner[seam.b.panel, seam.b.edge] = seam.a.panel
    sides: dict[tuple[str, str], list[int]] = {}
    for panel in pattern.panels:
        for other, count in _count_around(panel, partner).items():
            first, second = sorted((panel.name, other))
            sides.setdefault((first, second), []).append(count)
    return Counter({pair: min(counts) for pair, counts in sides.items()})


def find_parts(pattern: Pattern) -> np.ndarray:
    """Tell which panels are graded as one, as a number for each panel, shape [panel_count].

    Panels that are sewn to each other along two seams or more, as a front and its back, share girth and height.
    """
    at = {panel.name: i for i, panel in enumerate(pattern.panels)}
    pairs = [(at[a], at[b]) for (a, b), count in count_seams(pattern).items() if count >= 2]
    rows = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    link = sp.csr_matrix((np.ones(len(rows)), (rows[:, 0], rows[:, 1])), (len(at), len(at)))
    return np.asarray(connected_components(link, directed=False)[1])


def _count_around(panel: Panel, partner: dict[tuple[str, int], str]) -> Counter[str]:
    """Count the edges of a panel that are sewn to each other panel, those joined across darts or short edges as one."""
    sewn = [(i, partner.get((panel.name, i))) for i in range(len(panel.edges)) if edge_length(panel, i) >= SHORT]
    sewn = [(i, name) for i, name in sewn if name != panel.name]
    count: Counter[str] = Counter()
    for n, (i, name) in enumerate(sewn):
        before, last = sewn[n - 1]
        bridged = last == name and (i - before) % len(panel.edges) != 1
        if name is not None:
            count[name] += 0 if bridged else 1
    return Counter({name: max(number, 1) for name, number in count.items()})
