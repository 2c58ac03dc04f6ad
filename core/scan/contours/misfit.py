"""Whether a garment lies on the body that was given with it, by where its surface is."""

from __future__ import annotations

import numpy as np

from ...body import Body
from ...body.solid import Solid
from ...geometry import TriangleSurface

DEEP = 0.02
"""Depth inside the body that noise and pressed-in cloth do not reach [m]."""

NEAR = 0.03
"""Distance within which worn cloth lies somewhere [m]."""

DEEP_SHARE = 0.03
"""Share of the surface that may lie deep. Of 13 garments on the bodies that they were draped or scanned on none has a
point so deep; on others' bodies, in the same place, it is up to a quarter."""

NEAR_SHARE = 0.05
"""Share that must lie near: on their own bodies it is 39 % or more, least for a skirt; in another place 0 to 3 %."""

MOST = 2000
"""Points that are looked at: shares of a per cent need no more."""


def explain_misfit(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> str:
    """Return a sentence where a garment cannot have been scanned on a body; else an empty text.

    A garment that is cut loose lies on a slimmer person's body as well; that is not told.

    Args:
        points: The garment's vertices [m], shape [n, 3].
        vertices: The body's [m], shape [m, 3].
        faces: The body's, shape [k, 3].
    """
    chosen = points[:: max(1, -(-len(points) // MOST))]
    distance = TriangleSurface(vertices, faces).distance(chosen)
    deep = float(np.mean(Solid(vertices, faces).contains(chosen) & (distance > DEEP)))
    if deep > DEEP_SHARE:
        return (
            f"{100.0 * deep:.0f} % of the garment lie more than {1e3 * DEEP:.0f} mm inside the body: it was not "
            "scanned on this one, so seams and measures may be misread; give its wearer's own body, or a slimmer one."
        )
    near = float(np.mean(distance < NEAR))
    if near < NEAR_SHARE:
        return (
            f"{100.0 * near:.0f} % of the garment lie within {1e3 * NEAR:.0f} mm of the body: it hangs beside it, so "
            "the two files have different origins; export them together."
        )
    return ""


def find_remarks(points: np.ndarray, body: Body) -> tuple[str, ...]:
    """Return what speaks against a body for a garment's vertices [m], shape [n, 3], one sentence each.

    A model that was fitted to a clothed person lies where it was guessed; nothing is said of it.
    """
    is_given = body.source.startswith(("mesh:", "builtin:"))
    misfit = explain_misfit(points, body.vertices, body.faces) if is_given else ""
    return (misfit,) if misfit else ()
