"""Compare the shape of a drape's open contours with the scan's: a wrong part shows in it."""

from __future__ import annotations

import numpy as np

from ..body import JOINTS, PARENTS, Body
from ..mesh import polyline_length, resample_polyline
from ..pattern import Garment
from ..segment import Contour, Target, smooth_loop, unroll_neck

CORNER_SPAN = 0.03
"""Length at each side of the middle over which a neckline's direction is taken [m]: two teeth of a cut along triangles.
A round neckline of 7 cm radius turns by 25 degrees there, a V by 100."""

FINE = 400
"""Parts of half a neckline between which distances are taken: less than 1 mm each."""

AROUND = 72
"""Directions in which an edge's place along its limb is read."""

WINDOW = np.radians(60.0)
"""Width over which such places are averaged [rad]: wider than the folds of a hem, which fall elsewhere in each drape,
and narrower than a dip of front, back or side."""

MM = 1e3


def measure_contour_shapes(garment: Garment, nodes: np.ndarray, target: Target, body: Body) -> dict[str, float | None]:
    """Measure how unlike a drape's open contours are to the scan's, each unrolled into the plane.

    Args:
        garment: The recovered pattern, meshed and sewn; gives the contours, not the nodes.
        nodes: Its drape [m], shape [node_count, 3].
        target: The scan's surface; of its contours those count that can be trusted.
        body: The wearer.

    Returns:
        `shape.neck_corner_deg`: by how much more one neckline turns in its middle than the other, in front or behind,
        whichever is more. `shape.neck_mm`: the largest distance of the two lines of the neck, unrolled. `shape.NAME_mm`
        of any other contour: the largest distance along the limb or trunk that it goes round. What either has not is
        left out.
    """
    found: dict[str, float | None] = {}
    ours = {contour.name: nodes[contour.vertices] for contour in garment.contours}
    for contour in target.contours:
        if not contour.trusted or contour.name not in ours:
            continue
        mine, theirs = ours[contour.name], target.vertices[contour.vertices]
        if contour.name == "neck":
            found |= _compare_necks(mine, theirs, body)
        else:
            found[f"shape.{contour.name}_mm"] = MM * _compare_edges(mine, theirs, _axis(contour, body))
    return found


def _compare_necks(mine: np.ndarray, theirs: np.ndarray, body: Body) -> dict[str, float | None]:
    """Return the largest distance of two neck lines, and the difference of the turns of their middles."""
    lines, others = unroll_neck(mine, body), unroll_neck(theirs, body)
    if lines is None or others is None:
        return {}
    gaps, turns = [], []
    for line, other in ((lines.front, others.front), (lines.back, others.back)):
        gaps.append(max(_largest_gap(line, other), _largest_gap(other, line)))
        turns.append(abs(middle_turn(line) - middle_turn(other)))
    return {"shape.neck_corner_deg": float(np.degrees(max(turns))), "shape.neck_mm": MM * max(gaps)}


def middle_turn(line: np.ndarray) -> float:
    """Return by how much a neckline turns in its middle [rad], given half of it from the side, shape [n, 2]."""
    share = min(CORNER_SPAN / max(polyline_length(line), 1e-9), 0.5)
    fine = resample_polyline(line, 1 + FINE)
    across, down = np.abs(fine[-1] - fine[-1 - round(share * FINE)])
    return 2.0 * float(np.arctan2(down, across))


def _largest_gap(line: np.ndarray, other: np.ndarray) -> float:
    """Return the largest distance of a line's points from another line [m]."""
    fine = resample_polyline(other, 1 + FINE)
    return float(np.linalg.norm(line[:, None] - fine[None], axis=2).min(axis=1).max())


def _axis(contour: Contour, body: Body) -> np.ndarray:
    """Return the unit direction of the limb that a contour goes round; upwards for trunk, waist and hem."""
    side = contour.name.partition(".")[2]
    bones = [bone for bone in contour.bones if side and bone.startswith(side)]
    if not bones:
        return np.array([0.0, 1.0, 0.0])
    index = JOINTS.index(bones[-1])
    way = body.joints[PARENTS[index]] - body.joints[index]
    return np.asarray(way / max(float(np.linalg.norm(way)), 1e-9))


def _compare_edges(mine: np.ndarray, theirs: np.ndarray, axis: np.ndarray) -> float:
    """Return the largest distance of two closed edges along an axis, folds averaged away [m]."""
    seen = smooth_loop(theirs)
    places = [_places(loop, axis, seen.mean(axis=0)) for loop in (smooth_loop(mine), seen)]
    return float(np.abs(places[0] - places[1]).max())


def _places(loop: np.ndarray, axis: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return a closed line's places along an axis [m] in directions around it, shape [AROUND]."""
    off = loop - origin
    across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    across /= np.linalg.norm(across)
    angle = np.arctan2(off @ np.cross(axis, across), off @ across)
    wanted = np.arange(AROUND) * (2 * np.pi / AROUND)
    apart = np.abs((angle[None] - wanted[:, None] + np.pi) % (2 * np.pi) - np.pi)
    weight = np.maximum(0.0, 1.0 - apart / WINDOW) + 1e-9
    return np.asarray(weight @ (off @ axis) / weight.sum(axis=1))
