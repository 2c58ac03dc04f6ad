"""From a checked scan and its wearer to the `Target` of a recovery."""

from __future__ import annotations

from ..body import Body
from ..errors import BadInput
from ..scan import Scan, vertex_normals
from .category import choose_category
from .contours import name_contours
from .target import Target


class NoContour(BadInput):
    """The garment has no open contour around the body; give one open surface (no thickness), worn by the given body."""

    code = "segment.no_contour"


def segment_garment(scan: Scan, body: Body) -> Target:
    """Name the contours of a scanned garment and choose its category.

    Raises:
        NoContour: where no open boundary encircles a bone.
    """
    contours, holes = name_contours(scan.vertices, scan.faces, body, scan.unseen, scanned=True)
    if not contours:
        found = f"its {len(holes)} openings encircle no bone" if holes else "its surface is closed"
        raise NoContour(
            f"{scan.name} has no open contour: {found}; give one open surface (no thickness), worn by the given body."
        )
    return Target(
        vertices=scan.vertices,
        faces=scan.faces,
        normals=vertex_normals(scan.vertices, scan.faces),
        contours=contours,
        holes=holes,
        category=choose_category(contours, scan.vertices, body),
    )
