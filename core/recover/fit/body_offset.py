"""Raise a body that is only estimated under its cloth to where the cloth rests on it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from ...body.body import Body
from ...run.hooks import SILENT_HOOKS, Hooks
from ..drape.wearer import WearerGeometry

if TYPE_CHECKING:
    from .shape import ShapeProblem


@dataclass(frozen=True)
class OffsetSettings:
    """Describe how a body is raised.

    Attributes:
        kernel_stds: Standard deviation, in each iteration, of the Gaussian over which places are raised alike [m]: a
            body is as smooth as that, and other folds than the scan's make no dents. Each iteration brings the cloth to
            rest on the last body: cloth lifted off one place comes to rest on narrower ones, shoulders last. With 5 cm
            throughout the labelled scan's body was up to 9 mm outside the cloth. The last repeats up to `tolerance`.
        tolerance: RMS distance from the scan of cloth at rest on a body that is high enough [m]: as accurate as
            registration. The labelled scan's shoulders, 31 mm too low, were 8 mm too low after one iteration a radius.
        iterations: Largest number of iterations; the labelled scan takes eight.
        clearance: Depth of the body below the registered cloth [m]: where it is nearer to the cloth, it is lowered.
        lowerings: Largest number of times that an iteration lowers the body where it is outside the cloth.
        half_weight: Share of the surrounding cloth that has to touch the body for its estimate to count half, against
            single nodes.
    """

    kernel_stds: tuple[float, ...] = (0.05, 0.04, 0.03, 0.02)
    tolerance: float = 1e-3
    iterations: int = 12
    clearance: float = 2e-3
    lowerings: int = 4
    half_weight: float = 0.05


OFFSET_KERNEL_SIGMA_COUNT = 4.0
"""Number of standard deviations beyond which a place has no influence on a vertex."""


def is_body_estimated(body: Body) -> bool:
    """Return whether the body was estimated under the cloth of a dressed person."""
    return body.source.startswith("scan:")


def estimate_body_offset(
    problem: ShapeProblem,
    wearer: WearerGeometry,
    hooks: Hooks = SILENT_HOOKS,
    settings: OffsetSettings = OffsetSettings(),
) -> np.ndarray:
    """Estimate how far a body is below where it carries the cloth as scanned [m], shape [vertex_count].

    Under the cloth of a dressed person the body is accurate to a centimetre or two, and a drape on it is as much too
    low as its shoulders are. So the cloth is brought to rest from the scan. Where it then touches the body, the body
    moves along its normal by the remaining distance to the scan, averaged over touching cloth near by; a vertex at x,
    in each round, by
        h(x) = sum_v a_v K(x - x_v) r_v / (sum_v a_v K(x - x_v) + w)

    Notation: v touching nodes; a_v their area; r_v distance of the registered node outwards; K a Gaussian of width s
    (`kernel_stds`); w = `half_weight` 2 pi s^2, that share of the same sum for cloth flat on a body.
    Where the body would be outside the scanned cloth, it is lowered.

    Args:
        problem: The fit: the mesh registered on the scan, cloth and pins.
        wearer: The body that was estimated under the cloth.
        hooks: Cancellation.
        settings: Widths, iterations and their end.
    """
    from ...cloth.contact import contact_forces

    heights, pattern, registered = np.zeros(len(wearer.body.vertices)), problem.garment.pattern, problem.garment.nodes
    radii = settings.kernel_stds
    for radius in radii + (settings.iterations - len(radii)) * radii[-1:]:
        on = replace(problem, scene=problem.scene.with_body(wearer.raised_distance.raise_by(heights)))
        nodes = on.drape(pattern, registered, hooks).nodes
        scene = on.at(pattern)
        force, normal = contact_forces(scene, nodes)
        touching = force > 0
        missing = ((registered - nodes) * normal).sum(1)[touching]
        areas = scene.topology.rest.node_areas[touching]
        heights = heights + _average_nearby(
            wearer.body.raised(heights).vertices, nodes[touching], missing, areas, radius, settings.half_weight
        )
        heights = _lower_protrusions(wearer, heights, registered, settings)
        allowed = settings.tolerance**2 * float(areas.sum())
        if radius == radii[-1] and float((areas * missing**2).sum()) <= allowed:
            break
    return heights


def _lower_protrusions(
    wearer: WearerGeometry, heights: np.ndarray, cloth: np.ndarray, settings: OffsetSettings
) -> np.ndarray:
    """Lower heights [m], shape [vertex_count], where the raised body is outside the cloth [m], shape [n, 3]."""
    for _ in range(settings.lowerings):
        distance, outward = wearer.raised_distance.raise_by(heights).measure(cloth)
        low = distance < settings.clearance
        if not low.any():
            break
        feet = cloth[low] - distance[low, None] * outward[low]
        body_distance, nearest = cKDTree(feet).query(wearer.body.raised(heights).vertices)
        nearness = np.exp(-0.5 * (body_distance / settings.kernel_stds[-1]) ** 2)
        heights = heights + (distance[low] - settings.clearance)[nearest] * nearness
    return heights


def _average_nearby(
    vertices: np.ndarray, points: np.ndarray, out: np.ndarray, areas: np.ndarray, radius: float, half_weight: float
) -> np.ndarray:
    """Average distances [m] given at points [m], shape [n, 3], of areas [m2], over those near each vertex."""
    pairs = cKDTree(vertices).sparse_distance_matrix(
        cKDTree(points), OFFSET_KERNEL_SIGMA_COUNT * radius, output_type="coo_matrix"
    )
    nearness = np.exp(-0.5 * (pairs.data / radius) ** 2) * areas[pairs.col]
    weight, moved = (np.bincount(pairs.row, each, len(vertices)) for each in (nearness, nearness * out[pairs.col]))
    return np.asarray(moved / (weight + half_weight * 2.0 * np.pi * radius**2))
