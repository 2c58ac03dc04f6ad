"""The pairs of cloth that may touch on a way: found once, good for all that stays near it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from .advance import approach, free_share
from .barrier import measure_pairs
from .broad import Boxes, choose_cells, fill_cells, find_overlaps, wrap_boxes
from .closest import EDGE_EDGE, NODE_FACE, PARALLEL, span, weigh
from .self_contact import SHARE, SelfContact


class PairElements(NamedTuple):
    """Pairs as the kernels take them.

    Attributes:
        kinds: `NODE_FACE` or `EDGE_EDGE`, shape [pair_count].
        nodes: Node and face, or the ends of two edges, shape [pair_count, 4].
        sizes: Weight [m2], reach [m] and limit of the mollifier [m4], shape [pair_count, 3].
    """

    kinds: np.ndarray
    nodes: np.ndarray
    sizes: np.ndarray


@dataclass(frozen=True)
class Near:
    """Hold the pairs that may touch while cloth goes from one place to another, or stays near that way.

    Attributes:
        pairs: Those of a node and a face first, then those of edges.
        start: Where the way begins [m], shape [node_count, 3].
        step: The way [m], shape [node_count, 3].
        margin: Distance from it up to which the pairs are complete [m].
    """

    pairs: PairElements
    start: np.ndarray
    step: np.ndarray
    margin: float

    def within(self, nodes: np.ndarray, slack: float) -> PairElements:
        """Return the pairs whose distance at nodes [m], shape [node_count, 3], is within reach and a slack [m]."""
        if not len(self.pairs.kinds):
            return self.pairs
        kept = measure_pairs(nodes, self.pairs)[0] < self.pairs.sizes[:, 1] + slack
        return PairElements(*(part[kept] for part in self.pairs))

    def free_share(self, nodes: np.ndarray, step: np.ndarray) -> float:
        """Return the largest share, 0 to 1, of a step [m] from nodes [m], both [node_count, 3], without a touch.

        The pairs are to be complete along the step.
        """
        return float(free_share(nodes, step, self.pairs)) if len(self.pairs.kinds) else 1.0

    def covers(self, nodes: np.ndarray) -> bool:
        """Return whether nodes [m], shape [node_count, 3], lie near one point of the way."""
        moved = nodes - self.start
        length = float((self.step**2).sum())
        if length > 0.0:
            moved -= min(1.0, max(0.0, float((moved * self.step).sum()) / length)) * self.step
        return float((moved**2).sum(1).max()) <= self.margin**2


def find_near(cloth: SelfContact, start: np.ndarray, end: np.ndarray | None = None) -> Near:
    """Find all pairs that come within reach of each other on the straight way from `start` to `end`, or stay there.

    A pair is a node and a face or two edges that share no node. Boxes that overlap on a uniform grid are found first;
    of these, pairs stay whose distance at the start less how far they may approach is within reach and margin.

    Args:
        cloth: The mesh and its reach.
        start: Positions [m], shape [node_count, 3].
        end: Positions at the end of the way; `start` where None.
    """
    start = np.ascontiguousarray(start, dtype=np.float64)
    end = start if end is None else np.ascontiguousarray(end, dtype=np.float64)
    margin, step = cloth.margin, end - start
    inflation = 0.5 * float(cloth.reach.max()) + margin
    along = end - step.mean(axis=0)  # how the whole moves brings nothing nearer to anything
    singles, sheets, sides = (
        Boxes(low, high, each)
        for each in (cloth.singles, cloth.sheets, cloth.sides)
        for low, high in [wrap_boxes(start, along, each, inflation)]
    )
    grid = choose_cells(sheets, 1.5 * float((sheets.high - sheets.low).mean()))
    faced = find_overlaps(singles, sheets, fill_cells(sheets, grid), grid, False)
    edged = find_overlaps(sides, sides, fill_cells(sides, grid), grid, True)
    kept = [
        nodes[_keep(start, step, nodes, kind, cloth.reach, 2.0 * margin)]
        for kind, nodes in ((NODE_FACE, faced), (EDGE_EDGE, edged))
    ]
    kinds = np.repeat(np.array([NODE_FACE, EDGE_EDGE]), [len(nodes) for nodes in kept])
    return Near(PairElements(kinds, *_size(cloth, kept)), start, step, margin)


def _size(cloth: SelfContact, kept: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes of pairs and their sizes; see `PairElements`."""
    nodes = np.concatenate(kept)
    weights = SHARE * cloth.areas[nodes].mean(1)
    reach = cloth.reach[nodes].min(1) if len(nodes) else np.zeros(0)
    lengths = cloth.lengths
    limits = np.zeros(len(nodes))
    edged = kept[1]
    # the mean squared length of the edges around a node stands for an edge's own: it changes the law of no pair apart
    limits[len(kept[0]) :] = PARALLEL * lengths[edged[:, :2]].prod(1) * lengths[edged[:, 2:]].prod(1)
    return nodes, np.column_stack([weights, reach, limits])


@njit(cache=True)
def _keep(start, step, nodes, kind, reach, slack):  # type: ignore[no-untyped-def]
    """Return which pairs may come within reach and slack [m], shape [pair_count]."""
    kept = np.zeros(len(nodes), np.bool_)
    weights, rates, vector, motion = np.zeros(4), np.zeros((2, 4)), np.zeros(3), np.zeros((4, 3))
    for n in range(len(nodes)):
        i, j, k, m = nodes[n, 0], nodes[n, 1], nodes[n, 2], nodes[n, 3]
        far = min(min(reach[i], reach[j]), min(reach[k], reach[m])) + slack
        for d in range(3):
            mean = 0.25 * (step[i, d] + step[j, d] + step[k, d] + step[m, d])
            for c in range(4):
                motion[c, d] = step[nodes[n, c], d] - mean
        weigh(start, nodes[n], kind, weights, rates)
        kept[n] = span(start, nodes[n], weights, vector) < far + approach(motion, kind)
    return kept
