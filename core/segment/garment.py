"""From a checked scan and its wearer to the `Target` of a recovery."""

from __future__ import annotations

from dataclasses import replace

from ..body import Body
from ..errors import BadInput
from ..scan import Scan, vertex_normals
from .category import choose_category
from .contours import name_contours
from .loop import smoothed_length
from .noise import flatten_spikes, smooth_noise
from .target import Target


class NoContour(BadInput):
    """The garment has no open contour around the body; give one open surface (no thickness), worn by the given body."""

    code = "segment.no_contour"


def segment_garment(scan: Scan, body: Body) -> Target:
    """Name the contours of a scanned garment, choose its category, and take off outliers and noise.

    Noise as large as half an edge makes a surface up to twice as large and its contours longer: a pattern graded to it
    would be too large, and fold. So what grading, drape and deformer see is the smoothed surface.

    Raises:
        NoContour: where no open boundary encircles a bone.
    """
    contours, holes = name_contours(scan.vertices, scan.faces, body, scan.unseen, scanned=True)
    if not contours:
        found = f"its {len(holes)} openings encircle no bone" if holes else "its surface is closed"
        raise NoContour(
            f"{scan.name} has no open contour: {found}; give one open surface (no thickness), worn by the given body."
        )
    vertices, spikes = flatten_spikes(scan.vertices, scan.faces)
    vertices, noise = smooth_noise(vertices, scan.faces)
    if noise > 0.0 or spikes.any():
        contours = tuple(replace(c, length=smoothed_length(vertices[c.vertices])) for c in contours)
    return Target(
        vertices=vertices,
        faces=scan.faces,
        normals=vertex_normals(vertices, scan.faces),
        contours=contours,
        holes=holes,
        category=choose_category(contours, scan.vertices, body),
    )
