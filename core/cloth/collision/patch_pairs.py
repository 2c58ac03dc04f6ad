"""Find the pairs of patches of a cloth that may come near each other on a path."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...run.kernels import kernel
from .broad import pair_boxes
from .patches import Patches


class Bounds(NamedTuple):
    """Bounds of the motion of patches on a path: `boxes`, lowest and highest corners of all their positions [m], shape
    [patch_count, 6]; `middles`, mean of the nodes at each place [m], shape [patch_count, place_count, 3]; `spread`,
    largest deviation of a node's displacement from that of the mean [m], shape [patch_count]."""

    boxes: np.ndarray
    middles: np.ndarray
    spread: np.ndarray


def find_close_patches(
    patches: Patches, path: np.ndarray, spans: np.ndarray, need: float, moved: np.ndarray | None
) -> np.ndarray:
    """Find all pairs of patches of which parts that share no node may come within a distance on a path.

    Joined patches are compared with their layout in a plane. Let Y be the positions there, B the slope of x by Y (least
    squares) and P the projection on the columns of B. For two points a and b of them

        |x_a - x_b| >= |P (x_a - x_b)| >= sigma_min(B) |Y_a - Y_b| - |v_a| - |v_b|,   v = P (x - mean) - B (Y - mean),

    for any Y; v is linear along each step, and so largest at its ends. Bends change v in third order only, so that bent
    cloth still passes the test. Patches that are not joined are compared along the line between their means, where a
    common motion cancels.

    Args:
        patches: Of the cloth.
        path: Positions between which the cloth moves straight [m], shape [place_count, node_count, 3].
        spans: Lowest and highest corner of each node's positions [m], shape [node_count, 6]; see `remove_mean_motion`.
        need: The distance [m].
        moved: Nodes of which every pair has one or more, shape [node_count]; all where None.

    Returns:
        The lower and the higher patch of each pair, ascending, shape [pair_count, 2].
    """
    parts, active = _bound_patches(path, spans, patches.corners, np.zeros(0, np.bool_) if moved is None else moved)
    bounds = Bounds(*parts)
    overlapping = pair_boxes(bounds.boxes, 0.5 * need, active)
    disjoint = _find_near_disjoint(path, patches, bounds, (overlapping, active), need)
    joined = _find_near_joined(path, patches, bounds, active, need)
    return np.concatenate([disjoint, patches.joined[joined]])


@kernel()
def remove_mean_motion(path):  # type: ignore[no-untyped-def]
    """Return a path [m], [place_count, node_count, 3], less its mean motion, which changes no distance, and each node's
    box. The boxes are lowest and highest corners, [node_count, 6]."""
    places, count = path.shape[:2]
    relative, spans, mean = path.copy(), np.zeros((count, 6)), np.zeros(3)
    spans[:, :3], spans[:, 3:] = path[0], path[0]
    for j in range(1, places):
        mean[:] = 0.0
        for v in range(count):
            for d in range(3):
                mean[d] += path[j, v, d] - path[0, v, d]
        mean /= count
        for v in range(count):
            for d in range(3):
                value = path[j, v, d] - mean[d]
                relative[j, v, d] = value
                spans[v, d], spans[v, 3 + d] = min(spans[v, d], value), max(spans[v, 3 + d], value)
    return relative, spans


@kernel()
def _bound_patches(path, spans, corners, moved):  # type: ignore[no-untyped-def]
    """Return the `Bounds` of patches, and which patches have a node of `moved`; all where `moved` is empty."""
    starts, members = corners
    count, places = len(starts) - 1, len(path)
    boxes, middles, spread = np.zeros((count, 6)), np.zeros((count, places, 3)), np.zeros(count)
    active = np.full(count, len(moved) == 0)
    for c in range(count):
        boxes[c, :3], boxes[c, 3:] = np.inf, -np.inf
        share = 1.0 / (starts[c + 1] - starts[c])
        for m in range(starts[c], starts[c + 1]):
            v = members[m]
            if len(moved) > 0 and moved[v]:
                active[c] = True
            for d in range(3):
                boxes[c, d], boxes[c, 3 + d] = min(boxes[c, d], spans[v, d]), max(boxes[c, 3 + d], spans[v, 3 + d])
                for j in range(places):
                    middles[c, j, d] += share * path[j, v, d]
        most = 0.0
        for m in range(starts[c], starts[c + 1]):
            v = members[m]
            for j in range(1, places):
                square = 0.0
                for d in range(3):
                    off = (path[j, v, d] - middles[c, j, d]) - (path[0, v, d] - middles[c, 0, d])
                    square += off * off
                most = max(most, square)
        spread[c] = np.sqrt(most)
    return (boxes, middles, spread), active


@kernel()
def _drift(c, d, bounds):  # type: ignore[no-untyped-def]
    """Return the largest distance by which points of two patches can approach on the path [m]."""
    _, middles, spread = bounds
    most = 0.0
    for j in range(1, middles.shape[1]):
        square = 0.0
        for e in range(3):
            off = (middles[c, j, e] - middles[c, 0, e]) - (middles[d, j, e] - middles[d, 0, e])
            square += off * off
        most = max(most, square)
    return np.sqrt(most) + spread[c] + spread[d]


@kernel()
def _find_near_disjoint(path, patches, bounds, found, need):  # type: ignore[no-untyped-def]
    """Return the pairs of patches with overlapping boxes that share no node and may come within a distance."""
    overlapping, active = found
    starts, members = patches.corners
    around, others = patches.around
    kept, count = np.zeros((len(overlapping), 2), np.int64), 0
    line = np.zeros(3)
    for n in range(len(overlapping)):
        c, d = min(overlapping[n, 0], overlapping[n, 1]), max(overlapping[n, 0], overlapping[n, 1])
        if not (active[c] or active[d]):
            continue
        joins = False
        for m in range(around[c], around[c + 1]):
            joins = joins or others[m] == d
        if joins:
            continue
        square = 0.0
        for e in range(3):
            line[e] = bounds.middles[d, 0, e] - bounds.middles[c, 0, e]
            square += line[e] * line[e]
        length, apart, drift = np.sqrt(square), True, -1.0
        for j in range(len(path)):
            low, high = np.inf, -np.inf
            for m in range(starts[c], starts[c + 1]):
                x = path[j, members[m]]
                high = max(high, line[0] * x[0] + line[1] * x[1] + line[2] * x[2])
            for m in range(starts[d], starts[d + 1]):
                x = path[j, members[m]]
                low = min(low, line[0] * x[0] + line[1] * x[1] + line[2] * x[2])
            if low - high < need * length:
                apart = False
                break
            if drift < 0.0:
                drift = _drift(c, d, bounds)
                if low - high >= (need + drift) * length:
                    break
        if not apart or length == 0.0:
            kept[count, 0], kept[count, 1] = c, d
            count += 1
    return kept[:count]


@kernel()
def _find_near_joined(path, patches, bounds, active, need):  # type: ignore[no-untyped-def]
    """Return which joined pairs of patches may come within a distance, [joined_count]; see `find_close_patches`."""
    starts, members = patches.laid
    layout, joined, gaps = patches.layout, patches.joined, patches.gaps
    is_near = np.zeros(len(joined), np.bool_)
    slope, flat = np.zeros((3, 2)), np.zeros((256, 2))
    for n in range(len(joined)):
        c, d = joined[n]
        if not (active[c] or active[d]):
            continue
        is_near[n] = True
        begin, end = starts[n], starts[n + 1]
        if gaps[n] <= need or end - begin > len(flat):
            continue
        slope[:] = 0.0
        for m in range(begin, end):
            x, w, z = path[0, members[m]], layout[m, 2], layout[m, 3]
            for e in range(3):
                slope[e, 0] += x[e] * w
                slope[e, 1] += x[e] * z
        p = slope[0, 0] ** 2 + slope[1, 0] ** 2 + slope[2, 0] ** 2
        q = slope[0, 0] * slope[0, 1] + slope[1, 0] * slope[1, 1] + slope[2, 0] * slope[2, 1]
        r = slope[0, 1] ** 2 + slope[1, 1] ** 2 + slope[2, 1] ** 2
        area = p * r - q * q
        least = 0.5 * (p + r - np.sqrt((p - r) ** 2 + 4.0 * q * q))
        if not least > 0.0 or not area > 0.0:
            continue
        room, drift = np.sqrt(least) * gaps[n] - need, -1.0
        for j in range(len(path)):
            s, t = 0.0, 0.0
            for m in range(begin, end):
                x = path[j, members[m]]
                k = m - begin
                flat[k, 0] = slope[0, 0] * x[0] + slope[1, 0] * x[1] + slope[2, 0] * x[2]
                flat[k, 1] = slope[0, 1] * x[0] + slope[1, 1] * x[1] + slope[2, 1] * x[2]
                s += flat[k, 0]
                t += flat[k, 1]
            s, t = s / (end - begin), t / (end - begin)
            most = 0.0
            for m in range(begin, end):
                k = m - begin
                y, z = layout[m, 0], layout[m, 1]
                u, v = flat[k, 0] - s - p * y - q * z, flat[k, 1] - t - q * y - r * z
                most = max(most, r * u * u - 2.0 * q * u * v + p * v * v)
            off = 2.0 * np.sqrt(most / area)
            if not room >= off:
                break
            if drift < 0.0:
                drift = _drift(c, d, bounds)
                if room >= off + drift:
                    is_near[n] = False
                    break
            if j == len(path) - 1:
                is_near[n] = False
    return is_near
