"""Look for the two edges of an open front: paths that run down the front of the trunk, one on either side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..body.body import JOINTS, Body
from .colour import CONTRAST
from .features import FEATURE_LENGTH_SCALE, Features
from .limbs import BodyPlace, Limb
from .rings import (
    BEND_COST,
    CONTRAST_NOISE,
    CORRELATED_COLUMN_COUNT,
    colour_contrasts,
    edge_evidence,
    measure_noise,
    ridge_strengths,
    step_heights,
)
from .unrolled import LIMB_COLUMN_COUNT, STATION_STEP, Chart, UnrolledGrid, cut_chart

WIDTH = LIMB_COLUMN_COUNT * STATION_STEP
"""Width of the chart [m]: cells are as wide as high. Around the trunk they are 2 cm wide, and an edge is lost."""
ASIDE = 0.17
"""Distance from the middle [m] up to which an edge is looked for; further aside the chart's ends meet."""
BELOW_NECK = 0.12
"""Station [m] below the neck joint from which on edges count: higher up necklines run down the front, too."""
WINDOW = (4, 13)
"""Columns on either side and rows along, 3 and 10 cm, whose colours are averaged before they are compared: an open
front may be no wider."""
LEAST_ROWS = 10
"""Rows, 8 cm, that both edges must have in common."""


@dataclass(frozen=True)
class FrontEdges:
    """The best edges, and where they lie on the T-pose.

    Attributes:
        score: The weaker edge's log-probability against none.
        stations: Stations that both edges have [m], from the neck joint down, shape [k].
        left: Place of the left edge at each [m], towards the wearer's left from the middle, shape [k].
        right: Of the right edge, shape [k].
    """

    score: float
    stations: np.ndarray
    left: np.ndarray
    right: np.ndarray


def find_front_edges(features: Features, lab: np.ndarray, body: Body) -> FrontEdges | None:
    """Find where a front that is open shows what is worn below: the sides are higher than the middle, and differ.

    On each side the path r -> x(r) down the rows from any start to any end is the one with the largest sum of
    edge[r, x(r)] / 4 - 0.2 |x(r+1) - x(r)|, with the evidence for edges of the rings around limbs.

    Args:
        features: The samples' description.
        lab: Their colours in L*a*b*, shape [n, 3].
        body: The fitted body.

    Returns:
        The edges; None where no two of them lie side by side.
    """
    grid = unroll_front(features.place, body)
    if grid is None:
        return None
    columns = [grid.spread(channel) for channel in (lab * CONTRAST).T]
    step = step_heights(grid.spread(features.column("offset") * FEATURE_LENGTH_SCALE).T).T
    ridge = ridge_strengths(grid.spread(features.column("curvature_12")).T).T
    contrast = colour_contrasts(np.stack(columns, axis=2).transpose(1, 0, 2), WINDOW).T
    contrast *= CONTRAST_NOISE / measure_noise(contrast, CONTRAST_NOISE)  # printed cloth has edges everywhere
    x = (
        np.arange(LIMB_COLUMN_COUNT) - 0.5 * LIMB_COLUMN_COUNT
    ) * STATION_STEP  # of the border before each cell, as the differences are
    paths, scores = [], []
    for sign in (-1.0, 1.0):
        edge = np.where(grid.is_near, edge_evidence(sign * step, sign * ridge, contrast), 0.0)
        edge[:, (sign * x > 0.0) | (np.abs(x) > ASIDE)] = -np.inf
        edge[grid.stations < BELOW_NECK] = -np.inf
        score, path = find_path(edge / CORRELATED_COLUMN_COUNT, BEND_COST / CORRELATED_COLUMN_COUNT)
        scores.append(score)
        paths.append(path)
    rows = np.flatnonzero((paths[0] >= 0) & (paths[1] >= 0))
    if len(rows) < LEAST_ROWS:
        return None
    return FrontEdges(min(scores), grid.stations[rows], x[paths[0][rows]], x[paths[1][rows]])


def unroll_front(place: BodyPlace, body: Body) -> UnrolledGrid | None:
    """Return the front of the trunk cut into square cells, its columns from the wearer's right to his left."""
    neck, pelvis = (body.rest_joints[JOINTS.index(name)] for name in ("neck", "pelvis"))
    rest = place.rest
    middle = np.interp(rest[:, 1], [pelvis[1], neck[1]], [pelvis[2], neck[2]])
    mine = (place.limb == Limb.TRUNK) & (rest[:, 2] > middle) & (np.abs(rest[:, 0]) < 0.5 * WIDTH)
    members = np.flatnonzero(mine)
    if not len(members):
        return None
    turn = 2 * np.pi * (rest[members, 0] / WIDTH + 0.5)
    return cut_chart(Chart(Limb.TRUNK, members, neck[1] - rest[members, 1], turn))


def find_path(gain: np.ndarray, cost: float) -> tuple[float, np.ndarray]:
    """Return the largest sum along a path from row to row, and its columns, -1 in rows that it leaves out.

    It moves by at most one column a row, each for `cost`, and begins and ends where that gains most.

    Args:
        gain: Shape [rows, columns].
        cost: Of one column aside.
    """
    rows, columns = gain.shape
    value, back = np.zeros((rows, columns)), np.full((rows, columns), -1)
    before = np.full(columns + 2, -np.inf)
    for r in range(rows):
        ways = np.stack([before[:-2] - cost, before[1:-1], before[2:] - cost])
        chosen = ways.argmax(axis=0)
        gained = ways[chosen, np.arange(columns)]
        back[r] = np.where(gained > 0.0, np.arange(columns) + chosen - 1, -1)
        value[r] = np.maximum(gained, 0.0) + gain[r]
        before[1:-1] = value[r]
    path = np.full(rows, -1)
    row, column = np.unravel_index(int(value.argmax()), value.shape)
    score = float(value[row, column])
    while score > 0.0 and row >= 0 and column >= 0:
        path[row], column, row = column, back[row, column], row - 1
    return score, path
