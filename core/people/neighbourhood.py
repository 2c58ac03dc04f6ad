"""Compute statistics of the neighbourhood of every sample at several radii in one pass."""

from __future__ import annotations

import numpy as np

from ..run.kernels import kernel

NEIGHBOURHOOD_RADII = (0.012, 0.02, 0.04, 0.06)
"""Radii of the neighbourhoods [m]: a hem's edge, its step, a fold, a slice of a limb."""

STEP_SHARE = 0.25
"""Share of the radius along the limb within which neighbours belong to neither side of a step."""


def neighbourhood_statistics(
    positions: np.ndarray, normals: np.ndarray, offset: np.ndarray, along: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Compute statistics of a sample's neighbours on its own side of the cloth, whose normals are within 90 degrees.

    With q the neighbours of p within r, n the normal of p, o the offsets and t = (q - p) . along:
    mean and spread of o; step = mean of o where t > r / 4 less mean of o where t < -r / 4 (0 where a side is empty);
    mean curvature -2 sum (q - p) . n / sum |q - p|^2 [1/m], 1 / R on a ball of radius R from outside;
    spread of normals 1 - |mean of normals|; crowding log2((1 + count) / (1 + median count)).

    Args:
        positions: Positions [m], shape [n, 3].
        normals: Outward unit normals, shape [n, 3].
        offset: Offsets from the body [m], shape [n].
        along: Unit vectors along the limb, shape [n, 3].

    Returns:
        For each of `NEIGHBOURHOOD_RADII` the six values in this order, shape [n, 6].
    """
    reach = NEIGHBOURHOOD_RADII[-1]
    low = positions.min(axis=0)
    cell = np.floor((positions - low) / reach).astype(np.int64)
    shape = cell.max(axis=0) + 1
    key = (cell[:, 0] * shape[1] + cell[:, 1]) * shape[2] + cell[:, 2]
    order = np.argsort(key, kind="stable")
    rows = [np.ascontiguousarray(values[order], dtype=np.float64) for values in (positions, normals, offset, along)]
    position, normal, height, axis = rows
    sums = _sum_neighbours(
        position, normal, height, axis, key[order], cell[order], shape, np.array(NEIGHBOURHOOD_RADII) ** 2
    )
    out = np.zeros_like(sums)
    out[:, order] = sums
    count = out[:, :, 5]
    usual = np.maximum(np.median(count, axis=1, keepdims=True), 1.0)
    out[:, :, 5] = np.log2((1.0 + count) / (1.0 + usual))
    return tuple(out)


@kernel()
def _sum_neighbours(positions, normals, offset, along, key, cell, shape, squares):  # type: ignore[no-untyped-def]
    """Sum over the 27 cells around each point; everything is sorted by cell."""
    count, scales = len(positions), len(squares)
    out = np.zeros((scales, count, 6))
    for i in range(count):
        n, o, oo = np.zeros(scales), np.zeros(scales), np.zeros(scales)
        up, ups, down, downs = np.zeros(scales), np.zeros(scales), np.zeros(scales), np.zeros(scales)
        bend, square_sum = np.zeros(scales), np.zeros(scales)
        mean = np.zeros((scales, 3))
        for x in range(max(cell[i, 0] - 1, 0), min(cell[i, 0] + 2, shape[0])):
            for y in range(max(cell[i, 1] - 1, 0), min(cell[i, 1] + 2, shape[1])):
                # The three cells along z follow each other in the order.
                first = (x * shape[1] + y) * shape[2] + max(cell[i, 2] - 1, 0)
                last = (x * shape[1] + y) * shape[2] + min(cell[i, 2] + 1, shape[2] - 1)
                for j in range(np.searchsorted(key, first), np.searchsorted(key, last, side="right")):
                    square, side, t, bump = 0.0, 0.0, 0.0, 0.0
                    for a in range(3):
                        arm = positions[j, a] - positions[i, a]
                        square += arm * arm
                        side += normals[i, a] * normals[j, a]
                        t += arm * along[i, a]
                        bump += arm * normals[i, a]
                    if square > squares[scales - 1] or side <= 0.0:
                        continue
                    for s in range(scales - 1, -1, -1):
                        if square > squares[s]:
                            break
                        n[s] += 1
                        o[s] += offset[j]
                        oo[s] += offset[j] * offset[j]
                        bend[s] += bump
                        square_sum[s] += square
                        for a in range(3):
                            mean[s, a] += normals[j, a]
                        if t * t > STEP_SHARE * STEP_SHARE * squares[s]:
                            if t > 0:
                                up[s] += offset[j]
                                ups[s] += 1
                            else:
                                down[s] += offset[j]
                                downs[s] += 1
        for s in range(scales):
            average = o[s] / n[s]
            out[s, i, 0] = average
            out[s, i, 1] = np.sqrt(max(oo[s] / n[s] - average * average, 0.0))
            if ups[s] > 0 and downs[s] > 0:
                out[s, i, 2] = up[s] / ups[s] - down[s] / downs[s]
            if square_sum[s] > 0:
                out[s, i, 3] = -2.0 * bend[s] / square_sum[s]
            length = np.sqrt(mean[s, 0] ** 2 + mean[s, 1] ** 2 + mean[s, 2] ** 2)
            out[s, i, 4] = 1.0 - length / n[s]
            out[s, i, 5] = n[s]
    return out
