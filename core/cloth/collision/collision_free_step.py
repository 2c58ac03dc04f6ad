"""Compute how far cloth can move along straight lines before any two parts of it touch."""

from __future__ import annotations

import math

import numpy as np

from ...run.kernels import kernel
from .closest import closest_weights, pair_distance

KEPT_DISTANCE_SHARE = 0.2
"""Share of a pair's distance that one step keeps (Li et al. 2021 keep 0.1 to 0.2): after twelve consecutive steps that
the same pair limits, the distance is still above double precision's round-off."""

MIN_PAIR_REACH_SHARE = 1e-3
"""Least distance of a pair as a share of its reach, for motion that no energy opposes (of pins): 2 micrometres. Pins
that move on would otherwise keep a fifth of the distance each time, until it is round-off and cloth passes through: at
1e-17 m for a rope of ten turns. At this share the barrier's force is a thousand times that at first contact, so cloth
that can move away does."""

_MAX_ADVANCE_ITERATIONS = 200
"""Largest number of advances of one pair, after which the share so far is taken. Each covers most of the rest."""


@kernel()
def collision_free_share(x, step, pairs, least=0.0):  # type: ignore[no-untyped-def]
    """Return the largest share, 0 to 1, of a step [m], shape [node_count, 3], that keeps every pair apart.

    Additive advancement (Li, Kaufman and Jiang 2021, codimensional incremental potential contact): the nearest points
    of a pair approach by at most l = max |p_a| + max |p_b| over the time t, p the motions less their mean, so that the
    time (d - `KEPT_DISTANCE_SHARE` d_0) / l may pass before the distance is computed again. No pair touches within the
    share. No pair comes nearer than `least` times its reach; where one already is, the share is 0.
    """
    kinds, nodes, sizes = pairs
    share = 1.0
    weights, rates, vector = np.zeros(4), np.zeros((2, 4)), np.zeros(3)
    place, motion, corners = np.zeros((4, 3)), np.zeros((4, 3)), np.arange(4)
    for n in range(len(kinds)):
        pair = nodes[n]
        for d in range(3):
            mean = 0.25 * (step[pair[0], d] + step[pair[1], d] + step[pair[2], d] + step[pair[3], d])
            for k in range(4):
                motion[k, d] = step[pair[k], d] - mean
        speed = max_approach_speed(motion, kinds[n])
        if speed <= 0.0:
            continue
        closest_weights(x, pair, kinds[n], weights, rates)
        distance = pair_distance(x, pair, weights, vector)
        kept = max(KEPT_DISTANCE_SHARE * distance, least * sizes[n, 1])
        if distance <= kept:
            return 0.0
        if share * speed <= distance - kept:
            continue
        travelled = 0.0
        for _ in range(_MAX_ADVANCE_ITERATIONS):
            more = (distance - kept) / speed
            if (travelled > 0.0 and more < 1e-3 * travelled) or travelled + more >= share:
                travelled = min(travelled + more, share)
                break
            travelled += more
            for k in range(4):
                for d in range(3):
                    place[k, d] = x[pair[k], d] + travelled * motion[k, d]
            closest_weights(place, corners, kinds[n], weights, rates)
            distance = pair_distance(place, corners, weights, vector)
        share = min(share, travelled)
    return share


@kernel()
def max_approach_speed(motion, kind):  # type: ignore[no-untyped-def]
    """Return the largest speed at which the two parts of a pair can approach."""
    first = 0.0
    split = 1 if kind == 0 else 2
    second = 0.0
    for k in range(4):
        speed = motion[k, 0] * motion[k, 0] + motion[k, 1] * motion[k, 1] + motion[k, 2] * motion[k, 2]
        if k < split:
            first = max(first, speed)
        else:
            second = max(second, speed)
    return math.sqrt(first) + math.sqrt(second)
