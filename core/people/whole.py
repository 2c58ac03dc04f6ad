"""Whether a surface that came with its wearer's body is the whole person, or a garment alone."""

from __future__ import annotations

import numpy as np

from ..body import JOINTS, Body
from ..geometry import TriangleSurface, vertex_normals
from ..scan import Scan

TALL = 0.8
"""Share of the wearer's height that a surface must have to be looked at more closely: from head to feet it is all of
it, from the neck to the floor 0.86, and no shirt or pair of trousers comes near."""

LEAST_HEIGHT = 1.4
"""Height [m] below which few adults stand; a built-in body's own is not known before it is made."""

NEAR = 0.025
"""Distance [m] within which the surface shows a place of the skin: twice the misfit of a body that was fitted."""

SHOWN = 0.6
"""Share of a face, of both hands or of both feet that must be shown. A hood leaves the face free, a sleeve covers a
hand's back, trousers to the floor an instep."""

FORWARD = 0.3
"""Cosine between the face's normals and where the person faces; ears and the back of the head have less."""

HANDS, FEET = ("left_hand", "right_hand"), ("left_foot", "right_foot")
"""Joints of what no garment shows by itself: fingers, and toes."""


def stands_tall(surface: Scan, wearer: Scan | None) -> bool:
    """Return whether a surface is as high as a whole person; cheap, before any body is fitted.

    Args:
        surface: What was scanned.
        wearer: The wearer's mesh; None: one of usual height.
    """
    height = LEAST_HEIGHT if wearer is None else float(np.ptp(wearer.vertices[:, 1]))
    return float(np.ptp(surface.vertices[:, 1])) >= TALL * height


def shows_person(surface: Scan, body: Body) -> bool:
    """Return whether a surface shows its wearer's face, both hands or both feet: then it is not a garment alone.

    Args:
        surface: What was scanned.
        body: Its wearer, in the same place and pose.
    """
    part = np.array(JOINTS)[body.weights.argmax(axis=1)]
    normals = vertex_normals(body.vertices, body.faces)
    face = (part == "head") & (normals @ body.heading[2] > FORWARD)
    places = [face, np.isin(part, HANDS), np.isin(part, FEET)]
    seen = TriangleSurface(surface.vertices, surface.faces)
    return any(bool((seen.distance(body.vertices[place]) < NEAR).mean() >= SHOWN) for place in places if place.any())
