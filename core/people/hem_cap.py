"""Open the hem of a skirt or dress that a watertight scan has capped between the legs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import Body
from ..geometry.geometry import vertex_normals
from ..scan.contours.contours import name_contours
from ..scan.contours.target import Contour
from ..scan.cut import cut_garment
from ..scan.scan import Scan

LEG_CONTOURS = {"leg.left", "leg.right"}
"""Openings of a capped hem: the cap has a hole around each leg."""

CAP_CELL_SIZE = 0.005
"""Side of the cells whose vertices are averaged before normals are compared [m], to bound a dense scan's cost."""
CAP_NORMAL_RADIUS = 0.02
"""Radius over which normals are averaged [m]: with 4 mm of noise single faces point in any direction."""
MIN_CAP_NORMAL_COSINE = 0.7
"""Least cosine between a cap's mean normal and down: 45 degrees, that of a hem's edge, half wall and half cap."""
MIN_CAP_DEPTH = 0.13
"""Least depth of a cap below the joints of the hips [m], 5 cm below the crotch: the seat is above."""


class CutPart(NamedTuple):
    """Describe a garment cut out of a person's surface: its surface, named openings, and loops of other borders."""

    garment: Scan
    contours: tuple[Contour, ...]
    holes: tuple[np.ndarray, ...]


def cut_part(whole: Scan, is_garment: np.ndarray, body: Body) -> CutPart:
    """Cut a garment out of a person's surface; a hem that is capped between the legs is opened.

    A scanner does not see into a skirt, and software that closes every surface joins its hem to the legs, which leaves
    two holes, as of trousers. Where a garment ends at the legs, what faces down between them is left out; the result is
    used if it has one hem. Trousers still have two.

    Args:
        whole: The person's surface.
        is_garment: The garment's vertices, bool, shape [vertex_count].
        body: The wearer.
    """
    part = _cut_and_name(whole, is_garment, body)
    if not LEG_CONTOURS <= {contour.name for contour in part.contours}:
        return part
    cap = find_hem_cap(whole, is_garment, body)
    if not cap.any():
        return part
    opened = _cut_and_name(whole, is_garment & ~cap, body)
    names = {contour.name for contour in opened.contours}
    return opened if "hem" in names and not names & LEG_CONTOURS else part


def find_hem_cap(whole: Scan, is_garment: np.ndarray, body: Body) -> np.ndarray:
    """Find the part of a garment that faces down below the crotch, bool, shape [vertex_count].

    Args:
        whole: The person's surface.
        is_garment: The garment's vertices, bool, shape [vertex_count].
        body: The wearer.
    """
    hips = 0.5 * (body.joint("left_hip")[1] + body.joint("right_hip")[1])
    low = np.flatnonzero(is_garment & (whole.vertices[:, 1] < hips - MIN_CAP_DEPTH))
    cap = np.zeros(len(is_garment), bool)
    if not len(low):
        return cap
    points, normals = whole.vertices[low], vertex_normals(whole.vertices, whole.faces)[low]
    _, cell = np.unique(np.floor(points / CAP_CELL_SIZE).astype(np.int64), axis=0, return_inverse=True)
    cell = np.ravel(cell)
    size = np.bincount(cell)
    middle, mean = (
        np.stack([np.bincount(cell, values[:, axis]) for axis in range(3)], axis=1) / size[:, None]
        for values in (points, normals)
    )
    links = cKDTree(middle).sparse_distance_matrix(cKDTree(middle), CAP_NORMAL_RADIUS, output_type="coo_matrix")
    sums = np.stack([np.bincount(links.row, mean[links.col, axis], len(middle)) for axis in range(3)], axis=1) + mean
    length = np.linalg.norm(sums, axis=1)
    cap[low] = (-sums[:, 1] > MIN_CAP_NORMAL_COSINE * length)[cell]
    return cap


def _cut_and_name(whole: Scan, is_garment: np.ndarray, body: Body) -> CutPart:
    garment = cut_garment(whole, is_garment)
    return CutPart(garment, *name_contours(garment.vertices, garment.faces, body, garment.unseen, scanned=True))
