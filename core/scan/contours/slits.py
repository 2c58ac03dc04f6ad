"""Find the slits that are cut into a garment's openings: a placket in a neckline, vents in a hem, slits of cuffs."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import partial

import numpy as np

from ...body.body import Body
from .rim_gaps import average_normals, bridge_bites
from .target import Target

MAX_PLACKET_OFFSET = 0.03
"""Largest distance of the edges of a placket, or of a centre back vent, from the middle plane [m]: a placket is 3 cm
wide, and hangs open."""
MAX_SIDE_VENT_OFFSET = 0.08
"""Largest distance of a side vent's edges from the plane through the hips' joints and the spine [m]: side seams are up
to 4 cm before or behind it, and the edges hang apart."""
MIN_CUFF_SLIT_RATIO = 4.0
"""Least ratio of the length along the arm of a slit in a cuff to its width: its edges lap, or hang 2 cm apart along 10
cm; damage there is rounder."""

MIN_CUFF_SLIT_LENGTH = 0.05
"""Least length of the slit above a buttoned cuff [m]: half of what is cut, which ends below the cuff's fold."""
MAX_SLEEVE_RADIUS = 0.12
"""Largest distance of the middle of such a slit from the forearm's axis [m]: a wide sleeve hangs that far below it."""


class SlitName(StrEnum):
    """Describe a slit by its place."""

    PLACKET = "placket"
    BACK_VENT = "vent.back"
    LEFT_VENT = "vent.left"
    RIGHT_VENT = "vent.right"
    LEFT_CUFF = "vent.cuff.left"
    RIGHT_CUFF = "vent.cuff.right"


@dataclass(frozen=True)
class Slit:
    """Describe a slit.

    Attributes:
        name: Its place.
        extent: Its length [m].
    """

    name: SlitName
    extent: float


def find_slits(target: Target, body: Body) -> tuple[Slit, ...]:
    """Find the slits in the closed contours of a scan that it shows, in their order, then those above cuffs that are
    buttoned, whose borders go around nothing: holes that are long and narrow along a forearm."""
    found = []
    for contour in target.contours:
        if not (contour.is_closed and contour.trusted) or not len(target.faces):
            continue
        points = target.vertices[contour.vertices]
        normals = partial(average_normals, target.vertices, target.faces, contour.vertices)
        for gap in bridge_bites(points, normals, pointed=contour.name == "neck")[1]:
            name = name_slit(contour.name, points[gap], body)
            if name is not None:
                found.append(Slit(name, _measure_extent(contour.name, points[gap], body)))
    for hole in target.holes:
        points = target.vertices[hole]
        cuff = _find_forearm(points.mean(axis=0), body)
        name = None if cuff is None else name_slit(cuff, points, body)
        if cuff is not None and name is not None:
            extent = _measure_extent(cuff, points, body)
            found += [Slit(name, extent)] if extent > MIN_CUFF_SLIT_LENGTH else []
    return tuple(found)


def _find_forearm(place: np.ndarray, body: Body) -> str | None:
    """Return the cuff of the forearm that a place [m], shape [3], is beside; None where it is beside none."""
    for side in ("left", "right"):
        elbow, arm = body.joint(f"{side}_elbow"), body.joint(f"{side}_wrist") - body.joint(f"{side}_elbow")
        share = float((place - elbow) @ arm / (arm @ arm))
        if 0.0 < share < 1.0 and float(np.linalg.norm(place - elbow - share * arm)) < MAX_SLEEVE_RADIUS:
            return f"cuff.{side}"
    return None


def name_slit(contour: str, bay: np.ndarray, body: Body) -> SlitName | None:
    """Name a bay in a contour [m], shape [n, 3], that is a slit which is cut there; None for any other.

    Args:
        contour: The contour's name.
        bay: The points of its border.
        body: The wearer.
    """
    if contour.startswith("cuff."):
        arm = _direction(contour, body)
        off = bay - bay.mean(axis=0)
        along = off @ arm
        across = np.linalg.norm(off - along[:, None] * arm, axis=1)
        is_slit = np.ptp(along) > MIN_CUFF_SLIT_RATIO * 2.0 * across.max()
        return SlitName(f"vent.{contour}") if is_slit else None
    if contour not in ("neck", "hem"):
        return None
    part, joint = ("shoulder", "neck") if contour == "neck" else ("hip", "pelvis")
    lateral = body.sideways(part)
    lateral = lateral / np.linalg.norm(lateral)
    off, high = bay - body.joint(joint), np.ptp(bay[:, 1])
    aside, ahead = off @ lateral, off @ np.cross(lateral, (0.0, 1.0, 0.0))
    if np.abs(aside).max() < MAX_PLACKET_OFFSET and high > 2.0 * np.abs(aside).max():
        if contour == "neck":
            return SlitName.PLACKET if ahead.min() > 0.0 else None
        return SlitName.BACK_VENT if ahead.max() < 0.0 else None
    if contour == "hem" and np.abs(ahead).max() < MAX_SIDE_VENT_OFFSET and high > 2.0 * np.ptp(ahead):
        return SlitName.LEFT_VENT if aside.mean() > 0.0 else SlitName.RIGHT_VENT
    return None


def _direction(contour: str, body: Body) -> np.ndarray:
    """Return the unit direction along which a contour's slits run, shape [3]."""
    if not contour.startswith("cuff."):
        return np.array([0.0, 1.0, 0.0])
    side = contour.partition(".")[2]
    arm = body.joint(f"{side}_wrist") - body.joint(f"{side}_elbow")
    return np.asarray(arm / np.linalg.norm(arm))


def _measure_extent(contour: str, bay: np.ndarray, body: Body) -> float:
    """Return the length of a bay [m] along its contour's slits."""
    return float(np.ptp(bay @ _direction(contour, body)))
