"""Find the planes that bound a scan: floor, walls, the top of a platform."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

MAX_PLANE_COUNT = 6
"""Largest number of planes: a floor, a ceiling and four walls."""
PLANE_TRIAL_COUNT = 300
"""Number of points whose planes are tried: with a probability of 95 % one is on a floor with 1 % of all points."""
PLANE_HALF_THICKNESS_SHARE = 0.004
"""Half the thickness of a plane, as a share of the diagonal of the points left: 8 mm for a person, more than a floor's
noise and the rounding of its edge to the shoes."""
MIN_PLANE_NORMAL_COSINE = 0.9
"""Least cosine between the normals of a plane and of its points: shoes and hems are perpendicular to it."""
MAX_FAR_SIDE_RATIO = 1.0
"""Largest number of points on the far side of a plane over that on it: the sides of a platform, or what is seen through
a door. A slice through a person has 10 times as many points on either side as in it."""
MIN_PLANE_POINT_SHARE = 0.025
"""Least share of all points on the bare part of a plane; soles, which are below shoes, have half of that."""
PLANE_CLEARANCE_HEIGHT_SHARES = (0.006, 0.25, 0.05)
"""Shares of the diagonal for heights above a plane (1.2, 50, 10 cm for a person). Points between the first two show
that a place is not bare (before a back is a chest), points between the first and the third that it is under a shoe."""
MIN_PLANE_CLEARANCE_RATIOS = (3.0, 1.2)
"""Least distances of a plane's point from the points above it [sample spacings]: to count as bare floor or wall, and to
be dropped once there is a bare place."""


@dataclass(frozen=True)
class Plane:
    """Describe a plane and the samples that it removes.

    Attributes:
        normal: Unit normal, towards the person, shape [3].
        offset: `normal @ x` of its points.
        dropped: True at samples on it with nothing above them, and at samples beyond it, shape [n].
    """

    normal: np.ndarray
    offset: float
    dropped: np.ndarray


def find_planes(points: np.ndarray, normals: np.ndarray) -> list[Plane]:
    """Find the planes that have all else on one side, the largest first.

    Oriented random sample consensus (R. Schnabel et al., Efficient RANSAC for Point-Cloud Shape Detection, 2007).

    Args:
        points: Samples uniform over the surface, any unit, shape [n, 3].
        normals: Their unit normals, of either sign, shape [n, 3].
    """
    rng = np.random.default_rng(0)
    alive = np.ones(len(points), bool)
    found: list[Plane] = []
    while len(found) < MAX_PLANE_COUNT and alive.sum() > PLANE_TRIAL_COUNT:
        plane = _find_plane(points, normals, alive, rng)
        if plane is None:
            break
        found.append(plane)
        alive &= ~plane.dropped
    return found


def _find_plane(points: np.ndarray, normals: np.ndarray, alive: np.ndarray, rng: np.random.Generator) -> Plane | None:
    points_left, across = points[alive], normals[alive]
    diagonal = float(np.linalg.norm(np.ptp(points_left, axis=0)))
    thick = PLANE_HALF_THICKNESS_SHARE * diagonal
    sample = rng.permutation(len(points_left))[: min(len(points_left), 6000)]  # enough to rank the trials by
    ranked = []
    for row in rng.choice(len(points_left), PLANE_TRIAL_COUNT, replace=False).tolist():
        normal = across[row]
        depth = (points_left[sample] - points_left[row]) @ normal
        on = (np.abs(depth) < thick) & (np.abs(across[sample] @ normal) > MIN_PLANE_NORMAL_COSINE)
        if (
            on.mean() > MIN_PLANE_POINT_SHARE
            and min((depth > thick).sum(), (depth < -thick).sum()) < MAX_FAR_SIDE_RATIO * on.sum()
        ):
            ranked.append((int(on.sum()), row))
    seen: list[tuple[np.ndarray, float]] = []
    for _, row in sorted(ranked, reverse=True):
        if any(
            abs(normal @ across[row]) > MIN_PLANE_NORMAL_COSINE and abs(normal @ points_left[row] - offset) < thick
            for normal, offset in seen
        ):
            continue  # the same plane from another of its points
        plane = _refine(points_left, across, points_left[row], across[row], thick)
        if plane is None:
            continue
        seen.append(plane)
        normal, offset = plane
        on, clear = _measure_clearance(
            points,
            alive,
            plane,
            (PLANE_CLEARANCE_HEIGHT_SHARES[0] * diagonal, PLANE_CLEARANCE_HEIGHT_SHARES[1] * diagonal),
        )
        if (clear > MIN_PLANE_CLEARANCE_RATIOS[0]).sum() >= MIN_PLANE_POINT_SHARE * alive.sum():
            on, clear = _measure_clearance(
                points,
                alive,
                plane,
                (PLANE_CLEARANCE_HEIGHT_SHARES[0] * diagonal, PLANE_CLEARANCE_HEIGHT_SHARES[2] * diagonal),
            )
            dropped = alive & (points @ normal - offset <= -thick)
            dropped[on[clear > MIN_PLANE_CLEARANCE_RATIOS[1]]] = True
            return Plane(normal, offset, dropped)
    return None


def _refine(
    points: np.ndarray, normals: np.ndarray, point: np.ndarray, normal: np.ndarray, thick: float
) -> tuple[np.ndarray, float] | None:
    """Fit the plane to its points; return its normal (towards most others) and offset, or None if it divides them."""
    for width in (2.0 * thick, thick, thick):
        on = (np.abs((points - point) @ normal) < width) & (np.abs(normals @ normal) > MIN_PLANE_NORMAL_COSINE)
        if on.sum() < 3:
            return None
        point = points[on].mean(axis=0)
        normal = np.linalg.svd(points[on] - point, full_matrices=False)[2][2]
    depth = (points - point) @ normal
    above, below = (depth > thick).sum(), (depth < -thick).sum()
    if min(above, below) > MAX_FAR_SIDE_RATIO * (len(points) - above - below):
        return None
    normal = normal if above > below else -normal
    return normal, float(normal @ point)


def _measure_clearance(
    points: np.ndarray, alive: np.ndarray, plane: tuple[np.ndarray, float], heights: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the points on a plane, and how far along it each is from the points in a range of heights, in spacings."""
    from scipy.spatial import cKDTree

    normal, offset = plane
    depth = points @ normal - offset
    low, high = heights
    rows = np.flatnonzero(alive & (np.abs(depth) < low * PLANE_HALF_THICKNESS_SHARE / PLANE_CLEARANCE_HEIGHT_SHARES[0]))
    standing = alive & (depth > low) & (depth < high)
    if not standing.any() or not len(rows):
        return rows, np.full(len(rows), np.inf)
    frame = np.linalg.svd(normal[None])[2][1:]
    neighbour_distance = cKDTree(points[rows]).query(points[rows], min(7, len(rows)))[0][:, -1]
    spacing = float(np.median(neighbour_distance) * np.sqrt(np.pi / 6))
    return rows, cKDTree(points[standing] @ frame.T).query(points[rows] @ frame.T)[0] / spacing
