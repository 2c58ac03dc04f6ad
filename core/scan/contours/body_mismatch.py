"""Check by the distances of its surface whether a garment is on the body that was given with it."""

from __future__ import annotations

import numpy as np

from ...body.body import Body
from ...body.solid import Solid
from ...geometry.surface import TriangleSurface
from ...run.errors import BadInput

MAX_CLOTH_PENETRATION = 0.02
"""Depth inside the body that noise and pressed-in cloth do not reach [m]."""

NEAR_BODY_DISTANCE = 0.03
"""Distance from the body within which some part of worn cloth is [m]."""

MAX_PENETRATION_SHARE = 0.03
"""Largest share of the surface deeper than `MAX_CLOTH_PENETRATION`: 0 for 13 garments on the bodies that they were
draped or scanned on, up to a quarter on others' bodies in the same place."""

MIN_NEAR_BODY_SHARE = 0.05
"""Least share of the surface within `NEAR_BODY_DISTANCE`: 39 % (a skirt) or more when worn, 0 to 3 % elsewhere."""

MAX_MISFIT_SAMPLE_COUNT = 2000
"""Largest number of points that are checked: shares of a per cent need no more."""


def explain_misfit(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> str:
    """Return a sentence where a garment cannot have been scanned on a body; else an empty text.

    That a loose garment is on a slimmer person's body is not detected.

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
    near_share = float(np.mean(distance < NEAR_BODY_DISTANCE))
    if near_share < MIN_NEAR_BODY_SHARE:
        return (
            f"{100.0 * near_share:.0f} % of the garment lie within {1e3 * NEAR_BODY_DISTANCE:.0f} mm of the body: "
            "it hangs beside it, so the two files have different origins; export them together."
        )
    return ""


class BodyMismatch(BadInput):
    """The garment was not scanned on this body; give its wearer's own body, in the same place."""

    code = "scan.body_mismatch"


def check_own_body(points: np.ndarray, body: Body) -> None:
    """Check that a garment's vertices [m], shape [n, 3], can have been scanned on the body of a file.

    A built-in body stands for a wearer of about its measures, so that only a warning is given of it.

    Raises:
        BodyMismatch: if it cannot.
    """
    misfit = explain_misfit(points, body.vertices, body.faces) if body.source.startswith("mesh:") else ""
    if misfit:
        raise BodyMismatch(misfit)


def find_misfit_warnings(points: np.ndarray, body: Body) -> tuple[str, ...]:
    """Return warnings about a given body for a garment's vertices [m], shape [n, 3], one sentence each.

    A model that was fitted to a clothed person is not checked: its place is estimated.
    """
    is_given = body.source.startswith(("mesh:", "builtin:"))
    misfit = explain_misfit(points, body.vertices, body.faces) if is_given else ""
    return (misfit,) if misfit else ()
