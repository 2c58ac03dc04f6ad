"""Look up the colours of a scan at places near it."""

from __future__ import annotations

import numpy as np

from ...geometry.geometry import vertex_normals
from ...geometry.surface import TriangleSurface
from ...scan.coloured import ColouredScan
from .foreign_vertices import find_foreign_vertices

MAX_COLOUR_LOOKUP_DISTANCE = 0.01
"""Largest distance between the garment and the surface of the scan whose colour it takes [m]."""

MIN_LOOKUP_NORMAL_COSINE = 0.2
"""Smallest cosine between the garment's normal and the scan's; a face at a larger angle belongs to another fold."""

MAX_RIM_OVERHANG = 2e-3
"""Largest distance beyond the scan's rim at which the rim's colour is used [m]; further away is a hole."""

UNSEEN_COLOUR = (128, 128, 128)
"""Colour of a vertex that the scan does not show, RGB in 0..255, as `bake_texture` gives a panel without scan."""


def look_up_colours(scan: ColouredScan, points: np.ndarray, facing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the colour of a scan at each place, and whether there is one.

    It is the colour of the scan's nearest surface, if that is within `MAX_COLOUR_LOOKUP_DISTANCE` and faces the same
    way; if it belongs to another fold, the nearest face that faces the same way is used. If the scan was cut out of a
    person's, parts beside the cut that show skin or the inside of the cloth are excluded.

    Args:
        scan: The scan, coloured.
        points: Places [m], shape [n, 3].
        facing: Unit normal of the cloth at each, shape [n, 3].

    Returns:
        RGB in 0..255, shape [n, 3], and whether the scan shows the place, shape [n].
    """
    beyond = (
        find_foreign_vertices(scan)[scan.faces].any(axis=1) if scan.is_cut else np.zeros(len(scan.faces), dtype=bool)
    )
    ids = np.flatnonzero(scan.is_coloured)
    surface = TriangleSurface(scan.vertices, scan.faces[ids])
    found = surface.closest(points)
    face, place, distance = found.face.copy(), found.barycentric.copy(), found.distance.copy()
    offset = points - found.foot
    cosine = np.einsum("nd,nd->n", facing, surface.face_normals[face])
    sign = _orientation_sign(surface)
    lost = np.flatnonzero((distance <= 2.0 * MAX_COLOUR_LOOKUP_DISTANCE) & (sign * cosine < MIN_LOOKUP_NORMAL_COSINE))
    for axis in range(3):
        for side in (1.0, -1.0):
            on_axis = lost[np.argmax(np.abs(facing[lost]), axis=1) == axis]
            on_axis = on_axis[np.sign(facing[on_axis, axis]) == side]
            alike = np.flatnonzero(sign * side * surface.face_normals[:, axis] > MIN_LOOKUP_NORMAL_COSINE)
            if len(on_axis) and len(alike):
                again = TriangleSurface(surface.vertices, surface.faces[alike]).closest(points[on_axis])
                face[on_axis], place[on_axis], distance[on_axis] = alike[again.face], again.barycentric, again.distance
                offset[on_axis] = points[on_axis] - again.foot
    normal = surface.face_normals[face]
    cosine = sign * np.einsum("nd,nd->n", facing, normal)
    lateral = np.linalg.norm(offset - np.einsum("nd,nd->n", offset, normal)[:, None] * normal, axis=1)
    hole = surface.border_faces[face] & (lateral > MAX_RIM_OVERHANG)
    shown = (distance <= MAX_COLOUR_LOOKUP_DISTANCE) & (cosine >= MIN_LOOKUP_NORMAL_COSINE) & ~hole & ~beyond[ids[face]]
    return scan.colours_at(ids[face], place), shown


def colour_vertices(vertices: np.ndarray, faces: np.ndarray, scan: ColouredScan) -> np.ndarray:
    """Return the scan's colour at each vertex of a mesh on it, RGB bytes; `UNSEEN_COLOUR` where there is none.

    Args:
        vertices: Positions on the scan [m], shape [n, 3].
        faces: Triangles, shape [m, 3].
        scan: The scan in the same place.
    """
    colours, shown = look_up_colours(scan, vertices, vertex_normals(vertices, faces))
    rounded = np.clip(np.round(colours), 0, 255).astype(np.uint8)
    return np.where(shown[:, None], rounded, np.array(UNSEEN_COLOUR, np.uint8))


def _orientation_sign(surface: TriangleSurface) -> float:
    """Return 1.0 where faces point away from the centre of the surface, -1.0 where they point towards it."""
    centres = surface.vertices[surface.faces].mean(axis=1)
    middle = np.average(centres, axis=0, weights=surface.face_areas)
    flow = np.einsum("nd,nd->n", centres - middle, surface.face_normals) @ surface.face_areas
    return 1.0 if flow >= 0.0 else -1.0  # a file's faces may all point inward; of two layers the outer is larger
