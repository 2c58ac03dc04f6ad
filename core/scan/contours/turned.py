"""Find the part of a garment that is turned over at its neck: a collar's fall, lapels. Its outside faces the body."""

from __future__ import annotations

import numpy as np

from ...body.body import Body
from ...geometry.connectivity import find_components
from ...geometry.geometry import face_areas, face_normals
from ...geometry.surface import ClosestPoints, TriangleSurface
from .target import Contour, Target

MAX_TURNED_DISTANCE = 0.08
"""Largest distance of a turned part from the body [m]: a collar lies on the shoulders or stands off them by its own
width; what is farther away hangs free, and may face any way."""


def find_turned_faces(vertices: np.ndarray, faces: np.ndarray, neck: Contour, body: Body) -> np.ndarray:
    """Find the faces that are turned over at a garment's neck, bool, shape [face_count].

    They face the body, and others that do so join them to the neck's edge.

    Args:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: Outward faces.
        neck: The edge.
        body: The wearer.
    """
    skin = TriangleSurface(body.vertices, body.faces)
    return join_turned_faces(vertices, faces, neck, skin, skin.closest(vertices[faces].mean(axis=1)))


MIN_SHOWN_TURNED_SHARE = 0.5
"""Share of the area of what is turned over from which a scan shows its outside, which faces the body [1]: five falls
and lapels that were scanned on both sides had 0.93 to 1.05, one fused surface none."""


def free_covered_neck(target: Target, body: Body, turned_area: float) -> Target:
    """Return a target whose neck is not trusted where what is turned over there covers the edge of the garment.

    The border of a surface that shows a garment from outside alone lies behind the crease of a fall or a lapel; the
    edge of the cloth is the fall's.

    Args:
        target: The scan.
        body: The wearer.
        turned_area: Area of the panels of the pattern that are turned over [m2].
    """
    neck = target.contour("neck")
    if neck is None or turned_area == 0.0:
        return target
    shown = find_turned_faces(target.vertices, target.faces, neck, body)
    if face_areas(target.vertices, target.faces)[shown].sum() > MIN_SHOWN_TURNED_SHARE * turned_area:
        return target
    return target.distrust("neck")


def join_turned_faces(
    vertices: np.ndarray, faces: np.ndarray, neck: Contour, skin: TriangleSurface, found: ClosestPoints
) -> np.ndarray:
    """Find turned faces as `find_turned_faces`, where the points of the skin closest to their centres are known.

    Args:
        vertices, faces, neck: As there.
        skin: The wearer's surface.
        found: Its closest point to each face's centre.
    """
    inward = (face_normals(vertices, faces)[0] * skin.face_normals[found.face]).sum(axis=1) < 0.0
    inward &= found.distance < MAX_TURNED_DISTANCE
    chosen = faces[inward]
    _, piece = find_components(len(vertices), chosen[:, :2].ravel(), chosen[:, 1:].ravel())
    on_edge = np.isin(piece[chosen[:, 0]], piece[np.intersect1d(neck.vertices, chosen)])
    turned = np.zeros(len(faces), dtype=bool)
    turned[np.flatnonzero(inward)[on_edge]] = True
    return turned
