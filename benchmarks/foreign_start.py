"""Bring what position-based dynamics has dressed to the lengths of its panels: where `foreign_drapes.py` starts from.

Dressed under its own weight the cloth is up to 7 % too large, a waist is stretched over the hips by 12 %. Blender's
springs would let go of that at once: what hangs from the waist springs up and crumples.
"""

from __future__ import annotations

import numpy as np
import trimesh
from garmentq.core.garment.garment import Garment
from garmentq.core.recover.drape.dress import flat_length
from garmentq.core.recover.drape.layer_contact import LayerContact
from garmentq.core.recover.drape.pbd import PbdSettings, PbdState, build_distance_constraints, simulate_pbd
from garmentq.core.recover.drape.wearer import WearerGeometry
from scipy.spatial import ConvexHull

CLEARANCE = 0.007
"""From the body [m]: beyond the 5 mm that Blender keeps, so that nothing is thrown out of contact at the start."""

LIFTS, STEPS, LOOSE = 14, 6, 150
"""Parts of the way on which a waist is taken to its height, steps after each, and steps with the waist let go."""

REACH = 0.25
"""How far up a waist is taken at most [m]: from the hips to the ribs."""


def settle(garment: Garment, waist: np.ndarray, wearer: WearerGeometry) -> Garment:
    """Return the garment without weight and friction at the lengths of its panels, a waist where it fits the body.

    The waist is first taken up to where the body is as wide as it, then let go, so that what is below it finds room.

    Args:
        garment: The garment as dressed.
        waist: Nodes of the contour by which it hangs, in order, shape [n]; none where it hangs from the shoulders.
        wearer: Who wears it.
    """
    threads, grip = build_distance_constraints(garment), PbdSettings(friction=0.0, thickness=CLEARANCE)
    nodes = garment.nodes.copy()
    if len(waist):
        begin = nodes[waist]
        end = _fit_waist(begin, flat_length(garment, waist), wearer)
        for part in np.linspace(0.0, 1.0, LIFTS + 1)[1:]:
            nodes[waist] = begin + part * (end - begin)
            nodes = simulate_pbd(threads, PbdState.at_rest(nodes), wearer.grid, STEPS, settings=grip, pins=waist).nodes
    start = PbdState.at_rest(nodes)
    return garment.at(simulate_pbd(threads, start, wearer.grid, LOOSE, settings=grip, layers=LayerContact()).nodes)


def _fit_waist(points: np.ndarray, length: float, wearer: WearerGeometry) -> np.ndarray:
    """Return a waist's points [m] at its length, around the body where that, with clearance, is as wide."""
    body = trimesh.Trimesh(wearer.body.vertices, wearer.body.faces, process=False)
    low = points[:, 1].mean()
    sections = [(height, *_measure_section(body, height)) for height in np.arange(low, low + REACH, 0.005)]
    fitting = [section for section in sections if section[1] + 2.0 * np.pi * CLEARANCE <= length]
    height, _, middle = fitting[0] if fitting else min(sections, key=lambda section: section[1])
    around = points[:, [0, 2]] - points[:, [0, 2]].mean(0)
    worn = np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1).sum()
    x, z = (middle + around * (length / worn)).T
    return np.stack([x, np.full(len(points), height), z], axis=1)


def _measure_section(body: trimesh.Trimesh, height: float) -> tuple[float, np.ndarray]:
    """Return the convex girth [m] of the trunk at a height and its middle in x and z, shape [2]."""
    section = body.section(plane_origin=[0.0, height, 0.0], plane_normal=[0.0, 1.0, 0.0])
    trunk = max((loop[:, [0, 2]] for loop in section.discrete), key=lambda loop: float(np.ptp(loop, axis=0).prod()))
    hull = ConvexHull(trunk)
    corners = trunk[hull.vertices]
    return float(hull.area), 0.5 * (corners.min(0) + corners.max(0))
