"""Check whether a surface that came with its wearer's body is the whole person, or a garment alone."""

from __future__ import annotations

import numpy as np

from ..body.body import JOINTS, Body
from ..geometry.geometry import vertex_normals
from ..geometry.surface import TriangleSurface
from ..scan.scan import Scan

MIN_PERSON_HEIGHT_SHARE = 0.8
"""Least height of a surface that is examined as a person, as a share of the wearer's: head to feet is all of it, neck
to floor 0.86, and shirts and trousers are far below."""

MIN_ADULT_HEIGHT = 1.4
"""Height below which few adults are [m]; for a wearer of unknown height, as a built-in body before it is made."""

MAX_SHOWN_SKIN_DISTANCE = 0.025
"""Largest distance between the surface and a place of the skin that it shows [m]: twice a fitted body's misfit."""

MIN_SHOWN_SKIN_SHARE = 0.6
"""Share of a face, of both hands or of both feet that must be shown. A hood leaves the face free, a sleeve covers a
hand's back, trousers to the floor an instep."""

MIN_FACE_NORMAL_COSINE = 0.3
"""Least cosine between the face's normals and the person's heading; ears and the back of the head have less."""

HAND_JOINTS, FOOT_JOINTS = ("left_hand", "right_hand"), ("left_foot", "right_foot")
"""Joints that no garment shows by itself: fingers, and toes."""


def has_person_height(surface: Scan, wearer: Scan | None) -> bool:
    """Check whether a surface is as high as a whole person; cheap, before any body is fitted.

    Args:
        surface: What was scanned.
        wearer: The wearer's mesh; None: one of usual height.
    """
    height = MIN_ADULT_HEIGHT if wearer is None else float(np.ptp(wearer.vertices[:, 1]))
    return float(np.ptp(surface.vertices[:, 1])) >= MIN_PERSON_HEIGHT_SHARE * height


def shows_person(surface: Scan, body: Body) -> bool:
    """Check whether a surface shows its wearer's face, both hands or both feet: then it is not a garment alone.

    Args:
        surface: What was scanned.
        body: Its wearer, in the same place and pose.
    """
    part = np.array(JOINTS)[body.weights.argmax(axis=1)]
    normals = vertex_normals(body.vertices, body.faces)
    face = (part == "head") & (normals @ body.heading[2] > MIN_FACE_NORMAL_COSINE)
    places = [face, np.isin(part, HAND_JOINTS), np.isin(part, FOOT_JOINTS)]
    seen = TriangleSurface(surface.vertices, surface.faces)
    return any(
        bool((seen.distance(body.vertices[place]) < MAX_SHOWN_SKIN_DISTANCE).mean() >= MIN_SHOWN_SKIN_SHARE)
        for place in places
        if place.any()
    )
