"""Check a path after it was taken: how far no pair but the watched ones came near."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...run.kernels import kernel
from .closest import closest_weights, pair_distance
from .collision_free_step import max_approach_speed
from .near_pairs import NearPairs, collect_near_pairs, find_candidates
from .self_contact import SelfContact

MAX_MOVED_NODE_SHARE = 0.05
"""Largest share of nodes beyond their margin for which pairs are searched around these alone. Around a tenth of the
nodes the search takes as long as everywhere: the others may be off by a margin, and all patches with one of the tenth
are searched."""


def verify_pairs_on_path(cloth: SelfContact, path: np.ndarray, watched: NearPairs) -> tuple[NearPairs, int]:
    """Return the pairs near the last place of a path up to which its energies are valid, and the number of that place.

    A descent has the pairs near its start. Its steps are valid as long as no other pair came within reach, for until
    then the barrier of every other pair was zero. One search over the whole path finds that place, instead of one
    search per step. It is restricted to the nodes that left the margin of where their pairs were last searched (Verlet
    1967), where these are few: in the last runs of a drape they are a hundredth.

    Args:
        cloth: The mesh and its reach.
        path: Positions between which the cloth moved straight [m], shape [place_count, node_count, 3].
        watched: The pairs that the descent had.

    Returns:
        The pairs that come within reach on the path, or are within reach and margin of that place: a descent that
            continues there in the same way meets no other pair. And the place, 0 to place_count - 1.
    """
    path = np.ascontiguousarray(path, dtype=np.float64)
    moved = watched.left(path)
    steps = last = len(path) - 1
    if not moved.any():
        return replace(watched, frozen=False), last
    apart = watched.step.any() or np.count_nonzero(moved) > MAX_MOVED_NODE_SHARE * len(moved)
    # nodes that have not moved may be a margin away from where their pairs were found
    slack = (2.0 if apart else 3.0) * cloth.margin
    found = find_candidates(cloth, path, slack, None if apart else moved)
    traces = [_trace(path, each.nodes, each.kind, cloth.reach, slack) for each in found]
    for each, (first, _) in zip(found, traces, strict=True):
        met = first < last
        if met.any():
            last = min(last, int(first[met][~np.isin(each.keys[met], watched.keys)].min(initial=last)))
    place, chosen = path[last], []
    for each, (first, least) in zip(found, traces, strict=True):
        close = least < slack
        close[close] = _measure(place, each.nodes[close], each.kind, cloth.reach) < slack
        chosen.append(close | (first < steps))
    pairs = collect_near_pairs(cloth, found, chosen, place, np.zeros_like(place))
    return pairs if apart else watched.renewed(pairs, moved), last


@kernel()
def _trace(path, nodes, kind, reach, slack):  # type: ignore[no-untyped-def]
    """Return the first step of a path on which each pair may come within reach, and its least distance beyond it [m].

    At place j the pair's nodes are displaced by D_k = x_jk - x_0k less their mean, so that its distance is at least d_0
    - max_j (max_a |D_a| + max_b |D_b|), on the steps too. Where this bound is too low, the distance is computed at each
    place: on a step of lengths l_a, l_b it stays above (d_j + d_j+1 - l_a - l_b) / 2. The number of steps means never.
    """
    weights, rates, vector, motion = np.zeros(4), np.zeros((2, 4)), np.zeros(3), np.zeros((4, 3))
    count = len(path) - 1
    first, least = np.zeros(len(nodes), np.int64), np.zeros(len(nodes))
    for n in range(len(nodes)):
        pair = nodes[n]
        limit = min(min(reach[pair[0]], reach[pair[1]]), min(reach[pair[2]], reach[pair[3]]))
        most = 0.0
        for j in range(1, count + 1):
            _move(path[0], path[j], pair, motion)
            most = max(most, max_approach_speed(motion, kind))
        closest_weights(path[0], pair, kind, weights, rates)
        distance = pair_distance(path[0], pair, weights, vector) - limit
        first[n], least[n] = count, distance - most
        if least[n] >= slack:
            continue
        least[n] = distance
        for j in range(1, count + 1):
            before = distance
            closest_weights(path[j], pair, kind, weights, rates)
            distance = pair_distance(path[j], pair, weights, vector) - limit
            _move(path[j - 1], path[j], pair, motion)
            lowest = 0.5 * (before + distance - max_approach_speed(motion, kind))
            least[n] = min(least[n], min(lowest, distance))
            if lowest < 0.0 and first[n] == count:
                first[n] = j - 1
    return first, least


@kernel(inline="always")
def _move(start, end, pair, motion):  # type: ignore[no-untyped-def]
    """Fill the displacements of the four nodes of a pair [m], less their mean, shape [4, 3]."""
    for d in range(3):
        mean = 0.0
        for k in range(4):
            motion[k, d] = end[pair[k], d] - start[pair[k], d]
            mean += 0.25 * motion[k, d]
        for k in range(4):
            motion[k, d] -= mean


@kernel()
def _measure(x, nodes, kind, reach):  # type: ignore[no-untyped-def]
    """Return the distance of pairs beyond reach at x [m], shape [pair_count]."""
    beyond = np.zeros(len(nodes))
    weights, rates, vector = np.zeros(4), np.zeros((2, 4)), np.zeros(3)
    for n in range(len(nodes)):
        pair = nodes[n]
        closest_weights(x, pair, kind, weights, rates)
        limit = min(min(reach[pair[0]], reach[pair[1]]), min(reach[pair[2]], reach[pair[3]]))
        beyond[n] = pair_distance(x, pair, weights, vector) - limit
    return beyond
