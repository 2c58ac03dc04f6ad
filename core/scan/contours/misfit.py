"""Whether a garment lies on the body that was given with it, by where its surface is."""

from __future__ import annotations

import numpy as np

from ...body.body import Body
from ...body.solid import Solid
from ...geometry.surface import TriangleSurface

MAX_CLOTH_PENETRATION = 0.02
"""Depth inside the body that noise and pressed-in cloth do not reach [m]."""

NEAR_BODY_DISTANCE = 0.03
"""Distance from the body within which some part of worn cloth lies [m]."""

MAX_PENETRATION_SHARE = 0.03
"""Largest share of the surface deeper than `MAX_CLOTH_PENETRATION`. Of 13 garments on the bodies that they were draped
or scanned on none has a point so deep; on others' bodies, in the same place, it is up to a quarter."""

MIN_NEAR_BODY_SHARE = 0.05
"""Least share of the surface within `NEAR_BODY_DISTANCE`: on their own bodies it is 39 % or more, least for a skirt; in
another place 0 to 3 %."""

MAX_MISFIT_SAMPLE_COUNT = 2000
"""Largest number of points that are checked: shares of a per cent need no more."""


def explain_misfit(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> str:
    """Return a sentence where a garment cannot have been scanned on a body; else an empty text.

    A garment that is cut loose lies on a slimmer person's body as well; that is not told.

    Args:
        points: The garment's vertices [m], shape [n, 3].
        vertices: The body's [m], shape [m, 3].
        faces: The body's, shape [k, 3].
    """
    chosen = points[:: max(1, -(-len(points) // MAX_MISFIT_SAMPLE_COUNT))]
    distance = TriangleSurface(vertices, faces).distance(chosen)
    deep = float(np.mean(Solid(vertices, faces).contains(chosen) & (distance > MAX_CLOTH_PENETRATION)))
    if deep > MAX_PENETRATION_SHARE:
        return (
            f"{100.0 * deep:.0f} % of the garment lie more than {1e3 * MAX_CLOTH_PENETRATION:.0f} mm inside the body: "
            "it was not scanned on this one, so seams and measures may be misread; "
            "give its wearer's own body, or a slimmer one."
        )
    near = float(np.mean(distance < NEAR_BODY_DISTANCE))
    if near < MIN_NEAR_BODY_SHARE:
        return (
            f"{100.0 * near:.0f} % of the garment lie within {1e3 * NEAR_BODY_DISTANCE:.0f} mm of the body: "
            "it hangs beside it, so the two files have different origins; export them together."
        )
    return ""


def find_misfit_warnings(points: np.ndarray, body: Body) -> tuple[str, ...]:
    """Return what speaks against a body for a garment's vertices [m], shape [n, 3], one sentence each.

    A model that was fitted to a clothed person lies where it was guessed; nothing is said of it.
    """
    is_given = body.source.startswith(("mesh:", "builtin:"))
    misfit = explain_misfit(points, body.vertices, body.faces) if is_given else ""
    return (misfit,) if misfit else ()
