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
"""The openings that a capped hem has: the cap has a hole around each leg."""

CAP_CELL_SIZE = 0.005
"""Side of the cells whose vertices are averaged before normals are compared [m]: a dense scan then costs no more than a
coarse one."""
CAP_NORMAL_RADIUS = 0.02
"""Radius over which normals are averaged [m]: of scans with 4 mm of noise, single faces point in any direction."""
MIN_CAP_NORMAL_COSINE = 0.7
"""Least cosine between a cap's mean normal and the direction down: 45 degrees. The mean over a disk at a hem's edge,
half wall and half cap, has just that."""
MIN_CAP_DEPTH = 0.13
"""Least depth of a cap below the joints of the hips [m], 5 cm below the crotch: what lies above is the seat."""


class CutPart(NamedTuple):
    """A garment cut out of a person's surface.

    Attributes:
        garment: Its surface.
        contours: Its named openings.
        holes: The loops of its other borders.
    """

    garment: Scan
    contours: tuple[Contour, ...]
    holes: tuple[np.ndarray, ...]


def cut_part(whole: Scan, own: np.ndarray, body: Body) -> CutPart:
    """Cut a garment out of a person's surface; a hem that is capped between the legs is opened.

    A scanner does not see into a skirt, and a surface that is closed at all costs goes from its hem straight to the
    legs: two holes are left, as of trousers. Where a garment ends at the legs, what faces down between them is left
    out, and where it then has one hem, this is the garment. Trousers still have two.

    Args:
        whole: The person's surface.
        own: The garment's vertices, bool, shape [vertex_count].
        body: The wearer.
    """
    part = _cut_and_name(whole, own, body)
    if not LEG_CONTOURS <= {contour.name for contour in part.contours}:
        return part
    cap = find_hem_cap(whole, own, body)
    if not cap.any():
        return part
    opened = _cut_and_name(whole, own & ~cap, body)
    names = {contour.name for contour in opened.contours}
    return opened if "hem" in names and not names & LEG_CONTOURS else part


def find_hem_cap(whole: Scan, own: np.ndarray, body: Body) -> np.ndarray:
    """Find what of a garment faces down below the crotch, bool, shape [vertex_count].

    Args:
        whole: The person's surface.
        own: The garment's vertices, bool, shape [vertex_count].
        body: The wearer.
    """
    hips = 0.5 * (body.joint("left_hip")[1] + body.joint("right_hip")[1])
    low = np.flatnonzero(own & (whole.vertices[:, 1] < hips - MIN_CAP_DEPTH))
    cap = np.zeros(len(own), bool)
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
    near = cKDTree(middle).sparse_distance_matrix(cKDTree(middle), CAP_NORMAL_RADIUS, output_type="coo_matrix")
    sums = np.stack([np.bincount(near.row, mean[near.col, axis], len(middle)) for axis in range(3)], axis=1) + mean
    length = np.linalg.norm(sums, axis=1)
    cap[low] = (-sums[:, 1] > MIN_CAP_NORMAL_COSINE * length)[cell]
    return cap


def _cut_and_name(whole: Scan, own: np.ndarray, body: Body) -> CutPart:
    garment = cut_garment(whole, own)
    return CutPart(garment, *name_contours(garment.vertices, garment.faces, body, garment.unseen, scanned=True))
