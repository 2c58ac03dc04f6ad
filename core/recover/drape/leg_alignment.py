"""Align the legs of a garment with the wearer's, however far apart the wearer stands."""

from __future__ import annotations

import numpy as np

from ...body.body import Body
from ...body.girths import crotch_height
from ...geometry.connectivity import HalfEdges, find_components

MIN_GARMENT_LEG_LENGTH = 0.01
"""Length below which a part of the garment is no leg [m]: the spacing of the vertices of the body."""

MIN_LEG_OFFSET_SHARE = 0.05
"""Least distance of a leg's middle from the wearer's, as a share of the leg's width. A leg that ends at the wearer's
middle has half; flat, the crotches of trousers extend a third of a leg's width across (0.13, 0.19 and 0.24 on three),
and a skirt's middle is 0, its front and back apart or sewn."""


def align_legs(nodes: np.ndarray, faces: np.ndarray, body: Body) -> np.ndarray:
    """Shear the legs of flattened panels sideways until they slope as the body's do; return the nodes [m], [n, 3].

    They are sheared from the middle of the thighs down; above, a low crotch joins them. Drafts hang straight down. On
    legs that stand apart the outer seam of a narrow leg would start nearer to the inner side of the ankle and be pushed
    out there: both seams on one side of the foot.

    Args:
        nodes: Positions [m], shape [n, 3], in the body's place.
        faces: Shape [face_count, 3].
        body: The body in its T-pose, facing +z.
    """
    centre = body.joint("pelvis")[0]
    top = 0.5 * (crotch_height(body) + body.joint("left_knee")[1])
    below = nodes[:, 1] < top
    sides = HalfEdges.of(faces).edges
    sides = sides[below[sides].all(axis=1)]
    _, part = find_components(len(nodes), sides[:, 0], sides[:, 1])
    names, sizes = np.unique(part[below], return_counts=True)
    largest = [part == name for name in names[np.argsort(-sizes, kind="stable")[:2]]]
    shift = np.zeros(len(nodes))
    found = set()
    for side, sign in (("left", 1.0), ("right", -1.0)):
        joints = np.array([body.joint(f"{side}_{name}") for name in ("ankle", "knee", "hip")])
        for leg in largest:
            x, drop = nodes[leg, 0], top - nodes[leg, 1]
            if (
                sign * (x.mean() - centre) < MIN_LEG_OFFSET_SHARE * (x.max() - x.min())
                or drop.max() < MIN_GARMENT_LEG_LENGTH
            ):
                continue  # not a leg of this side: a skirt's middle is the wearer's
            found.add(side)
            slope = np.polyfit(drop, x, 1)[0]
            worn = np.interp(nodes[leg, 1], joints[:, 1], joints[:, 0])
            shift[leg] = worn - np.interp(top, joints[:, 1], joints[:, 0]) - slope * drop
    if len(found) == 2:
        nodes = nodes.copy()
        nodes[:, 0] += shift
    return nodes
