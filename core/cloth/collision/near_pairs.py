"""Find the pairs of cloth that may touch on a path; the result is valid for all positions near it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...run.kernels import kernel
from .barrier import measure_pairs
from .broad import pair_parts
from .closest import EDGE_EDGE, NODE_FACE, PARALLEL_EDGE_SHARE, closest_weights, pair_distance
from .collision_free_step import collision_free_share, max_approach_speed
from .patch_pairs import find_close_patches, remove_mean_motion
from .self_contact import PAIR_AREA_SHARE, SelfContact

NO_NODE_FILTER = np.zeros(0, np.bool_)
"""Argument of `pair_parts` for pairs of any nodes."""


class PairElements(NamedTuple):
    """Pairs as the kernels take them: `kinds`, `NODE_FACE` or `EDGE_EDGE`, shape [pair_count]; `nodes`, node and face,
    or the ends of two edges, shape [pair_count, 4]; `sizes`, weight [m2], reach [m] and limit of the mollifier [m4],
    shape [pair_count, 3]."""

    kinds: np.ndarray
    nodes: np.ndarray
    sizes: np.ndarray


NO_PAIRS = PairElements(np.zeros(0, np.int64), np.zeros((0, 4), np.int64), np.zeros((0, 3)))
"""Empty `PairElements`."""


class Candidates(NamedTuple):
    """Pairs of one kind whose boxes overlap: the kind, nodes, shape [pair_count, 4], and a unique key of each pair."""

    kind: int
    nodes: np.ndarray
    keys: np.ndarray


@dataclass(frozen=True)
class NearPairs:
    """Describe the pairs that may touch while cloth moves on a straight path, or stays near it.

    Attributes:
        pairs: Node-face pairs first, then edge pairs.
        keys: A number for each pair that no other pair of the cloth has, shape [pair_count].
        start: Start of the path [m], shape [node_count, 3]; of nodes that stayed within the margin since their pairs
            were found, their position then.
        step: The displacement [m], shape [node_count, 3].
        margin: Distance from the path up to which the pairs are complete [m].
        frozen: Treat the pairs as complete everywhere.
    """

    pairs: PairElements
    keys: np.ndarray
    start: np.ndarray
    step: np.ndarray
    margin: float
    frozen: bool = False

    def within(self, nodes: np.ndarray, slack: float) -> PairElements:
        """Return the pairs whose distance at nodes [m], shape [node_count, 3], is within reach and a slack [m]."""
        if not len(self.pairs.kinds):
            return self.pairs
        kept = measure_pairs(nodes, self.pairs)[0] < self.pairs.sizes[:, 1] + slack
        return PairElements(*(part[kept] for part in self.pairs))

    def free_share(self, nodes: np.ndarray, step: np.ndarray, least: float = 0.0) -> float:
        """Return the largest share, 0 to 1, of a step [m] from nodes [m], both [node_count, 3], without contact. The
        pairs must be complete along the step. No pair comes nearer than `least` times its reach."""
        return float(collision_free_share(nodes, step, self.pairs, least)) if len(self.pairs.kinds) else 1.0

    def covers(self, nodes: np.ndarray) -> bool:
        """Return whether nodes [m], shape [node_count, 3], are near one point of the path, where pairs are complete."""
        return bool(_stay_near(np.ascontiguousarray(nodes), self.start, self.step, self.margin))

    def left(self, path: np.ndarray) -> np.ndarray:
        """Return which nodes leave the margin on a path [m], [place_count, node_count, 3]."""
        if self.step.any():
            return np.full(path.shape[1], not all(self.covers(place) for place in path))
        return np.asarray(_find_nodes_beyond(path, self.start, self.margin))

    def renewed(self, found: NearPairs, moved: np.ndarray) -> NearPairs:
        """Return these pairs with those of the nodes that moved, [node_count], replaced by the pairs found now."""
        kept = ~moved[self.pairs.nodes].any(axis=1)
        keys = np.concatenate([self.keys[kept], found.keys])
        order = np.argsort(keys)
        parts = (np.concatenate([old[kept], new])[order] for old, new in zip(self.pairs, found.pairs, strict=True))
        start = np.where(moved[:, None], found.start, self.start)
        return replace(found, pairs=PairElements(*parts), keys=keys[order], start=start)


def find_near_pairs(cloth: SelfContact, start: np.ndarray, end: np.ndarray | None = None) -> NearPairs:
    """Find all pairs that come within reach of each other on the straight path from `start` to `end`, or near it. A
    pair is a node and a face or two edges that share no node. Pairs with overlapping boxes are found first, in patches
    that may come near each other; of these, pairs stay whose distance at the start less how far they can approach is
    within reach and margin.

    Args:
        cloth: The mesh and its reach.
        start: Positions [m], shape [node_count, 3].
        end: Positions at the end of the path; `start` where None.
    """
    start = np.ascontiguousarray(start, dtype=np.float64)
    step = np.zeros_like(start) if end is None else end - start
    slack = 2.0 * cloth.margin
    found = find_candidates(cloth, start[None] if end is None else np.stack([start, end]), slack)
    kept = [_find_kept_pairs(start, step, each.nodes, each.kind, cloth.reach, slack) for each in found]
    return collect_near_pairs(cloth, found, kept, start, step)


def find_candidates(
    cloth: SelfContact, path: np.ndarray, slack: float, moved: np.ndarray | None = None
) -> list[Candidates]:
    """Find all pairs that may come within reach and slack of each other on a path, by patches, then by boxes. The order
    is that of the search; `collect_near_pairs` sorts the few that are near.

    Args:
        cloth: The mesh and its reach.
        path: Positions between which the cloth moves straight [m], shape [place_count, node_count, 3].
        slack: Distance beyond reach [m].
        moved: Nodes of which every pair has one or more, shape [node_count]; all where None.
    """
    need, patches = float(cloth.reach.max()) + slack, cloth.patches
    path, spans = remove_mean_motion(np.ascontiguousarray(path))
    close = find_close_patches(patches, path, spans, need, moved)
    if not len(close):
        return [Candidates(kind, NO_PAIRS.nodes, NO_PAIRS.kinds) for kind in (NODE_FACE, EDGE_EDGE)]
    singles, sheets, sides = np.arange(len(cloth.areas))[:, None], cloth.faces, cloth.edges
    single, sheet, side = cloth.open_parts
    among = NO_NODE_FILTER if moved is None else moved
    faced = pair_parts(spans, close, (patches.nodes, patches.faces), (singles, sheets), (single, sheet, among), need)
    edged = pair_parts(spans, close, (patches.edges, patches.edges), (sides, sides), (side, side, among), need)
    first, second = np.minimum(edged[:, 0], edged[:, 1]), np.maximum(edged[:, 0], edged[:, 1])
    face_nodes = np.column_stack([faced[:, 0], sheets[faced[:, 1]]])
    edge_nodes = np.column_stack([sides[first], sides[second]])
    edge_keys = len(singles) * len(sheets) + first * len(sides) + second
    return [
        Candidates(NODE_FACE, face_nodes, faced[:, 0] * len(sheets) + faced[:, 1]),
        Candidates(EDGE_EDGE, edge_nodes, edge_keys),
    ]


def collect_near_pairs(
    cloth: SelfContact, found: list[Candidates], kept: list[np.ndarray], start: np.ndarray, step: np.ndarray
) -> NearPairs:
    """Return the kept candidates, shape [pair_count] each, as the pairs near a path [m]; see `NearPairs`. Their order
    does not depend on the search, so that sums over pairs are reproducible to the last digit."""
    chosen = [np.flatnonzero(mask) for mask in kept]
    if not any(mask.size for mask in chosen):
        return NearPairs(NO_PAIRS, found[0].keys[:0], start, step, cloth.margin)
    chosen = [mask[np.argsort(each.keys[mask])] for each, mask in zip(found, chosen, strict=True)]
    nodes = [each.nodes[mask] for each, mask in zip(found, chosen, strict=True)]
    keys = np.concatenate([each.keys[mask] for each, mask in zip(found, chosen, strict=True)])
    kinds = np.repeat(np.array([each.kind for each in found]), [len(each) for each in nodes])
    return NearPairs(PairElements(kinds, *_measure_pair_sizes(cloth, nodes)), keys, start, step, cloth.margin)


def _measure_pair_sizes(cloth: SelfContact, kept: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes of pairs and their sizes; see `PairElements`."""
    nodes = np.concatenate(kept)
    weights = PAIR_AREA_SHARE * cloth.areas[nodes].mean(1)
    reach = cloth.reach[nodes].min(1)
    lengths = cloth.lengths
    limits = np.zeros(len(nodes))
    edged = kept[1]
    # |e|^2 from both ends' mean edge lengths: the mollifier changes no pair that is not in contact
    limits[len(kept[0]) :] = PARALLEL_EDGE_SHARE * lengths[edged[:, :2]].prod(1) * lengths[edged[:, 2:]].prod(1)
    return nodes, np.column_stack([weights, reach, limits])


@kernel()
def _find_kept_pairs(start, step, nodes, kind, reach, slack):  # type: ignore[no-untyped-def]
    """Return which pairs may come within reach and slack [m], shape [pair_count]."""
    kept = np.zeros(len(nodes), np.bool_)
    weights, rates, vector, motion = np.zeros(4), np.zeros((2, 4)), np.zeros(3), np.zeros((4, 3))
    for n in range(len(nodes)):
        i, j, k, m = nodes[n, 0], nodes[n, 1], nodes[n, 2], nodes[n, 3]
        limit = min(min(reach[i], reach[j]), min(reach[k], reach[m])) + slack
        for d in range(3):
            mean = 0.25 * (step[i, d] + step[j, d] + step[k, d] + step[m, d])
            for c in range(4):
                motion[c, d] = step[nodes[n, c], d] - mean
        closest_weights(start, nodes[n], kind, weights, rates)
        kept[n] = pair_distance(start, nodes[n], weights, vector) < limit + max_approach_speed(motion, kind)
    return kept


@kernel()
def _stay_near(nodes, start, step, margin):  # type: ignore[no-untyped-def]
    """Return whether all nodes are within a margin [m] of one point of a path from their start by a step [m]."""
    length, along = 0.0, 0.0
    for v in range(len(nodes)):
        for d in range(3):
            length += step[v, d] * step[v, d]
            along += (nodes[v, d] - start[v, d]) * step[v, d]
    share = min(1.0, max(0.0, along / length)) if length > 0.0 else 0.0
    for v in range(len(nodes)):
        square = 0.0
        for d in range(3):
            square += (nodes[v, d] - start[v, d] - share * step[v, d]) ** 2
        if square > margin * margin:
            return False
    return True


@kernel()
def _find_nodes_beyond(path, start, margin):  # type: ignore[no-untyped-def]
    """Return which nodes are further than a margin [m] from their start at some place of a path, shape [node_count]."""
    left = np.zeros(len(start), np.bool_)
    for v in range(len(start)):
        for p in range(len(path)):
            square = 0.0
            for d in range(3):
                square += (path[p, v, d] - start[v, d]) ** 2
            if square > margin * margin:
                left[v] = True
                break
    return left
