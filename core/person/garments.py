"""Cut each garment out of a person's scan that was taken apart: what a recovery starts from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..body import Body
from ..errors import BadInput
from ..hooks import SILENT, Hooks
from ..mesh import face_areas, lump
from ..reading import Reading
from ..scan import Pieces, Scan, cut_garment
from ..scan.raw import RawScan
from ..scan.reconstruct import reconstruct
from ..segment import Contour, choose_category, name_contours
from .confidence import garment_confidence
from .openings import Surroundings, find_openings
from .part import CLOTH, GARMENTS, Part
from .points import estimate_normals, orient_normals
from .separation import FoundContour, FoundGarment, Separation

LEAST_AREA = 0.02
"""Area below which what looks like a garment is none [m2]: a bandeau or a brief has 0.05."""


class PartNotWorn(BadInput):
    """The person does not wear that; name one of the garments that were found, or correct the labels file."""

    code = "segment.part_unknown"


def cut_garment_of(raw: RawScan, separation: Separation, part: Part, hooks: Hooks = SILENT) -> Reading:
    """Cut one garment out of the scan along a smooth line.

    Args:
        raw: The person.
        separation: The same taken apart.
        part: Which garment.
        hooks: Cancellation.

    Returns:
        What `recover` starts from: the garment, the whole person with what is cloth, and the body.

    Raises:
        PartNotWorn: where nothing of the scan is that.
    """
    label = separation.label[raw.origin]
    found = [garment for garment in separation.garments if garment.part == part]
    if not found or not (label == part).any():
        raise PartNotWorn(f"Nothing of {raw.name} is {part.word}; correct the labels file, or name another garment.")
    hooks.check()
    whole, label = as_scan(raw, label, separation.body)
    garment = cut_garment(whole, label == part)
    contours, _ = name_contours(garment.vertices, garment.faces, separation.body, garment.unseen, scanned=True)
    garment = replace(garment, hidden=_mark_hidden(garment, contours, found[0].contours))
    pieces = Pieces(garment, whole, np.isin(label, CLOTH), label.astype(np.int64))
    return Reading(pieces, body=separation.body)


def find_garments(raw: RawScan, label: np.ndarray, confidence: np.ndarray, body: Body) -> tuple[FoundGarment, ...]:
    """Find what each garment is: its category by its openings, and what shows them.

    Args:
        raw: The person.
        label: A `Part` for each of its points, shape [point_count].
        confidence: Probability of each, shape [point_count].
        body: The wearer.
    """
    sure = {part: garment_confidence(label, confidence, part) for part in GARMENTS if (label == part).any()}
    whole, label = as_scan(raw, label, body)
    area = lump(face_areas(whole.vertices, whole.faces), whole.faces, len(whole.vertices))
    around = Surroundings.of(whole, label, body)
    found = []
    for part in GARMENTS:
        own = label == part
        if part not in sure or area[own].sum() < LEAST_AREA:
            continue
        garment = cut_garment(whole, own)
        contours, _ = name_contours(garment.vertices, garment.faces, body, garment.unseen, scanned=True)
        category = choose_category(contours, garment.vertices, body) if contours else ""
        openings = find_openings(garment, contours, part, around)
        found.append(FoundGarment(part, sure[part], category, openings))
    return tuple(found)


def as_scan(raw: RawScan, label: np.ndarray, body: Body) -> tuple[Scan, np.ndarray]:
    """Return a person's surface and the label of each of its vertices; a cloud gets a surface first.

    Args:
        raw: The person.
        label: Of its points, shape [point_count].
        body: The wearer: its normals say which side of a cloud is outside where the file does not.
    """
    points, faces, colours = raw.points, raw.faces, raw.colours
    if raw.is_cloud:
        normals = estimate_normals(points) if raw.normals is None else raw.normals
        normals = normals if raw.is_oriented else orient_normals(points, normals, body)
        surface = reconstruct(points, normals, colours)
        points, faces, colours, label = surface.vertices, surface.faces, surface.colours, label[surface.nearest]
    scan = Scan(
        vertices=points,
        faces=faces,
        name=raw.name,
        sha256=raw.sha256,
        units=raw.units,
        up_axis=raw.up_axis.lstrip("-"),
        colours=colours,
        repairs=raw.notes,
    )
    return scan, label


def _mark_hidden(garment: Scan, contours: tuple[Contour, ...], openings: tuple[FoundContour, ...]) -> np.ndarray:
    """Mark the vertices of the contours that are only inferred, bool, shape [vertex_count]."""
    inferred = {opening.name for opening in openings if opening.is_inferred}
    hidden = np.zeros(len(garment.vertices), bool)
    for contour in contours:
        if contour.name in inferred:
            hidden[contour.vertices] = True
    return hidden
