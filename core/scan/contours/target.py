"""Describe a garment's surface with its open contours named: the target of a recovery."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...geometry.connectivity import HalfEdges, find_components
from ...geometry.curves import Curve

CONTOUR_NAMES = (
    "neck", "waist", "hem",
    "front.left", "front.right",
    "cuff.left", "cuff.right",
    "armhole.left", "armhole.right",
    "leg.left", "leg.right",
    "placket.left", "placket.right", "wrap",
)  # fmt: skip
"""All names of open contours. Left and right are the wearer's: left is +x on a body that faces +z. The front edges of
a garment that is open in front join neckline and hem: together they are one border of the surface, in four parts. Only
a pattern names the slit of a sleeve above its buttoned cuff. `wrap` is what a wrap's outer front covers of the border:
of its neckline, an open line."""

OPEN_FRONT_CONTOURS = ("neck", "front.left", "hem", "front.right")
"""Contours that are parts of one border where a garment is open in front, in its order."""

CATEGORIES = ("tshirt", "long_sleeve_tshirt", "tank", "dress", "trousers", "shorts", "skirt", "jumpsuit")
"""All categories of garments."""

TOP_CATEGORIES = ("tshirt", "long_sleeve_tshirt", "tank")
"""Categories that hang from the shoulders and end above the legs."""


@dataclass(frozen=True)
class Contour:
    """Describe one open contour of a garment.

    Attributes:
        name: One of `CONTOUR_NAMES`.
        vertices: Vertex indices in order, garment on the left, int64, shape [loop_count].
        length: Of the curve after smoothing over 3 cm [m].
        bones: Names of the bones (by child joint, SMPL-24) that cross the disk spanned by the loop.
        trusted: False where the loop may be damage (a cut-off hem, a hole's rim) rather than design.
        hidden: Whether the garment may go on beyond it, covered or since nothing shows its end; it is not trusted then.
        is_closed: Whether its last vertex is joined to the first; not for a part of the border of an open front.
    """

    name: str
    vertices: np.ndarray
    length: float
    bones: tuple[str, ...] = ()
    trusted: bool = True
    hidden: bool = False
    is_closed: bool = True

    def curve(self, positions: np.ndarray) -> Curve:
        """Return the contour's curve at the positions of the surface's vertices [m], shape [vertex_count, 3]."""
        return Curve(positions[self.vertices], self.is_closed)

    @property
    def is_limb_end(self) -> bool:
        """Return whether a sleeve or leg ends here."""
        return self.name.partition(".")[0] in ("cuff", "armhole", "leg")


def mark_hidden_border(
    faces: np.ndarray, hidden: np.ndarray | None, contours: tuple[Contour, ...]
) -> np.ndarray | None:
    """Mark the border beyond which a garment may go on, bool, shape [vertex_count]; None where there is none.

    A border loop with any hidden vertex is hidden as a whole, including the bays that were cut off it; vertices of
    contours that are not hidden are left out.

    Args:
        faces: The surface's faces, shape [face_count, 3].
        hidden: Vertices known to be hidden, bool, shape [vertex_count], or None.
        contours: The surface's named contours.
    """
    if hidden is None or not hidden.any():
        return None
    edges = HalfEdges.of(faces, len(hidden))
    count, piece = find_components(len(hidden), edges.tail[edges.border], edges.head[edges.border])
    found = edges.border_vertices & (np.bincount(piece, hidden, count) > 0)[piece]
    for contour in contours:
        if not contour.hidden:
            found[contour.vertices] = False
    return found if found.any() else None


@dataclass(frozen=True)
class Target:
    """Describe the surface that a recovery fits.

    Attributes:
        vertices: Positions [m], shape [vertex_count, 3].
        faces: Outward counter-clockwise faces, shape [face_count, 3].
        normals: Unit vertex normals, area-weighted, shape [vertex_count, 3].
        contours: The named open contours.
        holes: Vertex loops that are damage and no contour.
        category: One of `CATEGORIES`, chosen from the contours and the bones they encircle.
        origin: Index in the scan of each vertex, shape [vertex_count]; None where the scan was not thinned.
        hidden: True at vertices of the border beyond which the garment may go on, shape [vertex_count]; None: nowhere.
        colours: RGB in 0..1 of the vertices that were scanned, the first ones, shape [n, 3]; None without colours.
    """

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray
    contours: tuple[Contour, ...]
    holes: tuple[np.ndarray, ...]
    category: str
    origin: np.ndarray | None = None
    hidden: np.ndarray | None = None
    colours: np.ndarray | None = None

    def contour(self, name: str) -> Contour | None:
        """Return a contour by its name, or None."""
        return next((c for c in self.contours if c.name == name), None)

    def distrust(self, name: str) -> Target:
        """Return the target with a contour that is not trusted."""
        return replace(
            self, contours=tuple(replace(one, trusted=False) if one.name == name else one for one in self.contours)
        )

    @property
    def waist(self) -> Contour | None:
        """Return the waist by which the garment hangs; None where it has none, or another garment hides it."""
        waist = self.contour("waist")
        return None if waist is None or waist.hidden else waist

    def contours_of_scan(self) -> tuple[Contour, ...]:
        """Return the contours with indices into the scan's vertices; thinning keeps every border vertex."""
        if self.origin is None:
            return self.contours
        return tuple(replace(contour, vertices=self.origin[contour.vertices]) for contour in self.contours)
