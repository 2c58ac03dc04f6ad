"""Raise a body that is only estimated under its cloth to where the cloth rests on it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from ...body.body import Body
from ...run.hooks import SILENT_HOOKS, Hooks
from ..drape.wearer import WearerGeometry

if TYPE_CHECKING:
    from .shape import ShapeProblem

OFFSET_KERNEL_STD = (0.05, 0.04, 0.03, 0.02)
"""Standard deviation, in each iteration, of the Gaussian over which places are raised alike [m]: the shape of a body is
as smooth as that, and cloth that has fallen into another fold than that of the scan makes no dent. Each iteration
brings the cloth to rest on the body that the one before left: cloth that is lifted off one place comes to rest on
others, and narrower ones, shoulders, come last. With 5 cm in all iterations the body of the labelled scan stood 9 mm
out of the cloth in places. The last is repeated until the distance is within `REST_DISTANCE_TOLERANCE`."""

REST_DISTANCE_TOLERANCE = 1e-3
"""Root mean square distance from the scan of cloth that rests on a body that is high enough [m]: registration finds the
surface to a millimetre, so less says nothing. The shoulders of the labelled scan, guessed 31 mm too low, were still 8
mm too low after one iteration of each radius."""

MAX_OFFSET_ITERATIONS = 12
"""Largest number of iterations; the labelled scan takes eight."""

MIN_CLOTH_CLEARANCE = 2e-3
"""Depth below the registered cloth at which the body ends [m]: where the body is nearer to the cloth, it is lowered."""

MAX_LOWERING_ITERATIONS = 4
"""Largest number of times that the body of an iteration is lowered where it stands out of the cloth, over the last of
`OFFSET_KERNEL_STD`."""

OFFSET_KERNEL_SIGMA_COUNT = 4.0
"""Number of standard deviations beyond which a place has no influence on a vertex."""

HALF_WEIGHT_CONTACT_SHARE = 0.05
"""Share of the surrounding cloth that has to lie on the body for its estimate to count half: a single node says
nothing."""


def is_body_estimated(body: Body) -> bool:
    """Return whether the body was found under the cloth of a dressed person, where nothing shows it."""
    return body.source.startswith("scan:")


def estimate_body_offset(problem: ShapeProblem, wearer: WearerGeometry, hooks: Hooks = SILENT_HOOKS) -> np.ndarray:
    """Estimate how far a body lies below where it carries the cloth as it was scanned [m], shape [vertex_count].

    Under the cloth of a dressed person the body is a guess, good to a centimetre or two, and cloth hangs from where it
    rests: a drape on the guess lies as much too low as the shoulders are. So the cloth is brought to rest from the
    scan, and wherever it then lies on the body, the body moves along its normal by what the scan misses there, averaged
    over the cloth that touches it near by; a vertex at x, in each round, by

        h(x) = sum_v a_v K(x - x_v) r_v / (sum_v a_v K(x - x_v) + w)

    Notation: v the nodes that touch; a_v their area; r_v how far the registered node lies further out; K a Gaussian of
    width s (`OFFSET_KERNEL_STD`); w the same sum of cloth that lies flat on a body, times `HALF_WEIGHT_CONTACT_SHARE`:
    w = HALF_WEIGHT_CONTACT_SHARE 2 pi s^2. The scan shows the cloth, so no body stands out of it: where one would, it
    is lowered.

    Args:
        problem: The fit: the mesh registered on the scan, cloth and pins.
        wearer: The body that was found under the cloth.
        hooks: Cancellation.
    """
    from ...cloth.contact import contact_forces

    heights, pattern, registered = np.zeros(len(wearer.body.vertices)), problem.garment.pattern, problem.garment.nodes
    for radius in OFFSET_KERNEL_STD + (MAX_OFFSET_ITERATIONS - len(OFFSET_KERNEL_STD)) * OFFSET_KERNEL_STD[-1:]:
        raised = wearer.raised(heights)
        on = replace(problem, scene=problem.scene.with_body(raised.grid))
        nodes = on.drape(pattern, registered, hooks).nodes
        scene = on.at(pattern)
        force, normal = contact_forces(scene, nodes)
        touching = force > 0
        missing = ((registered - nodes) * normal).sum(1)[touching]
        areas = scene.topology.rest.node_areas[touching]
        heights = heights + _average_nearby(raised.body.vertices, nodes[touching], missing, areas, radius)
        heights = _lower_protrusions(wearer, heights, registered)
        if radius == OFFSET_KERNEL_STD[-1] and float((areas * missing**2).sum()) <= REST_DISTANCE_TOLERANCE**2 * float(
            areas.sum()
        ):
            break
    return heights


def _lower_protrusions(wearer: WearerGeometry, heights: np.ndarray, cloth: np.ndarray) -> np.ndarray:
    """Lower heights [m], shape [vertex_count], where the body that they raise stands out of cloth [m], shape [n, 3]."""
    for _ in range(MAX_LOWERING_ITERATIONS):
        raised = wearer.raised(heights)
        distance, _ = raised.exposed.measure(cloth)
        low = distance < MIN_CLOTH_CLEARANCE
        if not low.any():
            break
        away, nearest = cKDTree(raised.exposed.closest(cloth[low]).foot).query(raised.body.vertices)
        heights = heights + (distance[low] - MIN_CLOTH_CLEARANCE)[nearest] * np.exp(
            -0.5 * (away / OFFSET_KERNEL_STD[-1]) ** 2
        )
    return heights


def _average_nearby(
    vertices: np.ndarray, points: np.ndarray, out: np.ndarray, areas: np.ndarray, radius: float
) -> np.ndarray:
    """Average distances [m] given at points [m], shape [n, 3], of areas [m2], over what is near each vertex."""
    near = cKDTree(vertices).sparse_distance_matrix(
        cKDTree(points), OFFSET_KERNEL_SIGMA_COUNT * radius, output_type="coo_matrix"
    )
    nearness = np.exp(-0.5 * (near.data / radius) ** 2) * areas[near.col]
    weight, moved = (np.bincount(near.row, each, len(vertices)) for each in (nearness, nearness * out[near.col]))
    return np.asarray(moved / (weight + HALF_WEIGHT_CONTACT_SHARE * 2.0 * np.pi * radius**2))
