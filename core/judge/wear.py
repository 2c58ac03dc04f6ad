"""Measure properties of every worn garment, which other objects lack."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..body.body import JOINTS, Body
from ..body.skinning import unskin, weights_at
from ..geometry.collapse import collapse_edges
from ..geometry.geometry import face_areas
from ..geometry.surface import TriangleSurface
from ..run.units import MM_PER_M
from ..scan.contours.target import Contour, Target

WEAR_SAMPLE_COUNT = 20_000
"""Number of samples of the scan: a quantile of the distances then scatters by less than 1 %."""

UPPER_CLOTH_QUANTILE = 0.75
"""Share of the cloth below the part that must be supported: every garment hangs from its uppermost quarter."""

BEARING_CLOTH_SHARE = 0.25
"""Share of that quarter whose distance from the body counts: shoulders support a shirt, a belt's width a skirt."""


def measure_wear(
    target: Target, body: Body, nodes: np.ndarray, faces: np.ndarray, seed: int
) -> dict[str, float | None]:
    """Measure whether a surface is worn as a garment is.

    `wear.rest_gap_mm`: distance from the body within which a quarter (`BEARING_CLOTH_SHARE`) of the uppermost cloth is.
    `wear.layers`: the scan's area over the detail mesh's, reduced to as many faces, so that noise adds none.

    Args:
        target: The scan's surface and contours.
        body: The wearer.
        nodes: The detail mesh [m], shape [node_count, 3].
        faces: Its faces, shape [face_count, 3].
        seed: Seed of the samples.
    """
    points, _ = TriangleSurface(target.vertices, target.faces).sample(WEAR_SAMPLE_COUNT, np.random.default_rng(seed))
    upper = points[points[:, 1] >= np.quantile(points[:, 1], UPPER_CLOTH_QUANTILE)]
    gap = np.quantile(TriangleSurface(body.vertices, body.faces).distance(upper), BEARING_CLOTH_SHARE)
    even = collapse_edges(target.vertices, target.faces, len(faces))
    area = float(face_areas(even.vertices, even.faces).sum())
    return {
        "wear.rest_gap_mm": MM_PER_M * float(gap),
        "wear.layers": area / max(float(face_areas(nodes, faces).sum()), 1e-12),
    }


def measure_sides(nodes: np.ndarray, contours: Sequence[Contour], body: Body) -> dict[str, float | None]:
    """Measure by how much left and right sleeves, or legs, end at unlike places.

    `wear.sides_mm` is the largest difference of a pair's ends along the limb, on the T-pose, so that how the limbs are
    held does not count; None of a garment without pairs.

    Args:
        nodes: The detail mesh [m], shape [node_count, 3].
        contours: Its named contours.
        body: The wearer.
    """
    ends = {contour.name: contour.vertices for contour in contours if contour.is_limb_end}
    apart = []
    for name in ends:
        stem, _, side = name.partition(".")
        if side != "left" or f"{stem}.right" not in ends:
            continue
        places = []
        for vertices in (ends[name], ends[f"{stem}.right"]):
            points = nodes[vertices]
            rest = unskin(points, weights_at(body, points, rest=False), body.transforms).mean(axis=0)
            places.append(rest[1] if stem == "leg" else abs(rest[0] - body.rest_joints[JOINTS.index("pelvis"), 0]))
        apart.append(abs(places[0] - places[1]))
    return {"wear.sides_mm": MM_PER_M * float(max(apart)) if apart else None}


def measure_upright(seen: Target) -> dict[str, float | None]:
    """Measure whether a skirt hangs the right way up.

    `wear.waist_by_hem` is the length of its waist over its hem's; None for other garments and where another one hides
    the waist: the border below a top's hem is over the hips.

    Args:
        seen: The scan's surface and contours.
    """
    waist, hem = seen.waist, seen.contour("hem")
    return {"wear.waist_by_hem": waist.length / hem.length if waist and hem else None}
