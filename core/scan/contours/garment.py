"""Build the `Target` of a recovery from a checked scan and its wearer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from ...body.body import Body
from ...body.girths import MIN_LIMB_GIRTH
from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import face_areas, vertex_normals
from ...run.errors import BadInput
from ..scan import Scan
from ..thin import thin_scan
from .category import choose_category
from .contours import name_contours
from .loop import find_loops, smoothed_length
from .noise import smooth_noise
from .spikes import flatten_spikes
from .target import Contour, Target, mark_hidden_border


class NoContour(BadInput):
    """The garment has no open contour around the body; give one open surface (no thickness), worn by the given body."""

    code = "segment.no_contour"


class PartMissing(BadInput):
    """The garment's openings do not make a garment; give all of it, as worn by the given body."""

    code = "segment.part_missing"


class SeveralGarments(BadInput):
    """The file holds more than one garment; give each a file of its own, or label the vertices and say --keep."""

    code = "segment.several_garments"


MIN_SEPARATE_SURFACE_SHARE = 0.05
"""Share of the whole area from which a separate surface is more than a button or a stray piece."""
MAX_JOINED_SURFACE_GAP = 0.02
"""Median distance between contours of two surfaces up to which these belong together [m]: an unsewn waistband is on its
skirt's edge, a T-shirt's hem hangs 5 cm and more below the waist worn with it."""
LOWER_OPENINGS = ("hem", "leg.left", "leg.right")
"""Contours through which the body leaves a garment below; every garment has one."""
ARM_OPENING_STEMS = ("cuff", "armhole")
"""Stems of the names of contours through which an arm leaves."""


def segment_garment(scan: Scan, body: Body) -> Target:
    """Name the contours of a scanned garment, choose its category, and remove outliers and noise.

    Noise as large as half an edge makes a surface up to twice as large and its contours longer: a pattern graded to it
    would be too large, and fold. So later steps use the smoothed surface, thinned if the scan is dense.

    Raises:
        NoContour: where no open boundary encircles a bone.
        PartMissing: where the openings found are not those of a whole garment on this body.
        SeveralGarments: where there are those of two, or a closed surface too.
    """
    full, (scan, thinned) = scan, thin_scan(scan)
    check_single(scan, body)
    contours, holes = name_contours(scan.vertices, scan.faces, body, scan.unseen, scanned=True, hidden=scan.hidden)
    if not contours:
        found = f"its {len(holes)} openings encircle no bone" if holes else "its surface is closed"
        raise NoContour(
            f"{scan.name} has no open contour: {found}; give one open surface (no thickness), worn by the given body."
        )
    check_parts(contours, scan.name, is_covered=scan.hidden is not None and bool(scan.hidden.any()))
    if body.is_dress_form:
        check_carried([smoothed_length(scan.vertices[hole]) for hole in holes], scan.name)
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
        origin=None if scan is full else thinned.origin,
        hidden=mark_hidden_border(scan.faces, scan.hidden, contours),
        colours=scan.colours,
    )


def check_parts(contours: tuple[Contour, ...], name: str, is_covered: bool = False) -> None:
    """Check that a garment has the openings of a worn one: one below, and one above or at both arms.

    This refuses half a shirt and a garment upside down or beside its body. A whole garment may lack one contour (a
    neckline under a closed hood), so no more is required. Of one below another garment one end is not seen: trousers
    below a long top are two tubes.

    Args:
        contours: The named openings.
        name: The scan's, for the message.
        is_covered: Whether the garment goes on below another one.

    Raises:
        PartMissing: where nothing is open below or nothing above.
    """
    missing = _missing(contours)
    if missing and not (is_covered and len(missing) == 1):
        found = {contour.name for contour in contours}
        raise PartMissing(
            f"{name} is no whole garment on this body: of its openings only {', '.join(sorted(found))} could be named, "
            f"none {' and none '.join(missing)}; give all of the garment, upright, in its place on the body."
        )


def check_carried(hole_lengths: Sequence[float], name: str) -> None:
    """Check that a garment on a dress form has no opening that encircles nothing: sleeves, for example.

    Args:
        hole_lengths: Lengths of the borders that have no name [m].
        name: The scan's, for the message.

    Raises:
        PartMissing: where an arm or a leg would fit through one.
    """
    longest = max(hole_lengths, default=0.0)
    if longest >= MIN_LIMB_GIRTH:
        raise PartMissing(
            f"{name} has an opening of {100.0 * longest:.0f} cm that goes around nothing of the dress form, which has "
            "no arms and legs; give the body of a whole person that wears it."
        )


def check_single(scan: Scan, body: Body) -> None:
    """Check that an unlabelled file has neither several garments nor a garment with its body.

    Together these would be read as one garment of another kind with holes: a T-shirt above a skirt as a dress.

    Raises:
        SeveralGarments: where two separate surfaces are each a whole garment, or one of several has no opening.
    """
    _, piece = HalfEdges.of(scan.faces, len(scan.vertices)).vertex_pieces
    areas = np.bincount(piece[scan.faces[:, 0]], face_areas(scan.vertices, scan.faces))
    large = np.flatnonzero(areas >= MIN_SEPARATE_SURFACE_SHARE * areas.sum())
    whole: list[np.ndarray] = []
    for part in large if len(large) > 1 else ():
        faces = scan.faces[piece[scan.faces[:, 0]] == part]
        if not find_loops(faces):
            raise SeveralGarments(
                f"{scan.name} holds {len(large)} separate surfaces, one of them closed as a body is; give the garment "
                "alone, or label the scan's vertices and say --keep."
            )
        contours, _ = name_contours(scan.vertices, faces, body, scanned=True)
        if contours and not _missing(contours):
            rims = [scan.vertices[contour.vertices] for contour in contours]
            others = cKDTree(np.concatenate(whole)) if whole else None
            if others is not None and all(np.median(others.query(rim)[0]) > MAX_JOINED_SURFACE_GAP for rim in rims):
                raise SeveralGarments(
                    f"{scan.name} holds more than one garment; give each a file of its own, or label the scan's "
                    "vertices and say --keep."
                )
            whole += rims


def _missing(contours: tuple[Contour, ...]) -> list[str]:
    """Return where the openings of a worn garment are missing: below, above."""
    found = {contour.name for contour in contours}
    above = found & {"neck", "waist"} or all(
        found & {f"{arm}.{side}" for arm in ARM_OPENING_STEMS} for side in ("left", "right")
    )
    return [where for where, there in (("below", found & set(LOWER_OPENINGS)), ("above", above)) if not there]
