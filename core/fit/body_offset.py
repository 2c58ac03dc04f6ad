"""Raise a body that is only estimated under its cloth to where the cloth rests on it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import gaussian_filter

from ..body import Body, DistanceGrid
from ..hooks import SILENT, Hooks

if TYPE_CHECKING:
    from .shape import ShapeProblem

ROUNDS = 4
"""Equilibria, each on the body that the one before left: cloth that is lifted off one place comes to rest on others."""

RADIUS = 0.05
"""Standard deviation of the places that are raised alike [m]: a body's shape is as smooth as that, and cloth that has
fallen into another fold than the scan's does not make a dent."""

FAINT = 0.05
"""Share of the cloth around that has to lie on the body before what it says counts half: a single node says nothing."""


def is_estimated(body: Body) -> bool:
    """Tell whether the body was found under the cloth of a dressed person, where nothing shows it."""
    return body.source.startswith("scan:")


def estimate_body_offset(problem: ShapeProblem, hooks: Hooks = SILENT) -> DistanceGrid:
    """Give the distance to a body that carries the cloth at the height at which it was scanned.

    Under the cloth of a dressed person the body is a guess, good to a centimetre or two, and cloth hangs from where it
    rests: a drape on the guess lies as much too low as the shoulders are. So the cloth is brought to rest from the
    scan, and wherever it then lies on the body, the body moves along its normal by what the scan misses there, averaged
    over the cloth that touches it near by:

        d'(x) = d(x) - sum_v a_v K(x - x_v) r_v / (sum_v a_v K(x - x_v) + w)

    Notation: v the nodes that touch; a_v their area; r_v how far the registered node lies further out; K a Gaussian of
    `RADIUS`; w the same sum of cloth that lies flat on a body, times `FAINT`.

    Args:
        problem: The fit: the mesh registered on the scan, cloth, hold and the distance to the estimated body.
        hooks: Cancellation.
    """
    from ..simulate import contact_forces

    grid = problem.scene.first.body
    assert grid is not None, "there is no body to raise"
    for _ in range(ROUNDS):
        on = replace(problem, scene=problem.scene.with_body(grid))
        drape = on.drape(problem.garment.pattern, problem.garment.nodes, hooks)
        scene = on.at(problem.garment.pattern)
        force, normal = contact_forces(scene, drape.nodes)
        touching = force > 0
        missing = ((problem.garment.nodes - drape.nodes) * normal).sum(1)[touching]
        areas = scene.topology.rest.node_areas[touching]
        grid = _moved_out(grid, drape.nodes[touching], missing, areas)
    return grid


def _moved_out(grid: DistanceGrid, points: np.ndarray, out: np.ndarray, areas: np.ndarray) -> DistanceGrid:
    """Move a body's surface out by distances [m], shape [n], given at points [m], shape [n, 3], of areas [m2]."""
    shape = np.array(grid.coefficients.shape)
    cell = np.clip(np.rint((points - grid.origin) / grid.spacing).astype(np.int64), 0, shape - 1)
    at = np.ravel_multi_index(tuple(cell.T), tuple(shape))
    sums = [np.bincount(at, values, minlength=int(shape.prod())).reshape(shape) for values in (areas, areas * out)]
    width = RADIUS / grid.spacing
    weight, moved = (gaussian_filter(each, width, mode="constant") for each in sums)
    # cloth that lies flat: one area to a plane, of which a cell holds spacing^3 / (sqrt(2 pi) RADIUS)
    flat = grid.spacing**3 / (np.sqrt(2.0 * np.pi) * RADIUS)
    return grid.inflated(moved / (weight + FAINT * flat))
