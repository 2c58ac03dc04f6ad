"""Cut each garment out of a labelled person's scan, for its recovery."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import Body
from ..garment.reading import Reading
from ..geometry.geometry import vertex_normals
from ..geometry.point_normals import estimate_normals, orient_normals
from ..run.errors import BadInput
from ..run.hooks import SILENT_HOOKS, Hooks
from ..scan.contours.category import choose_category
from ..scan.contours.target import Contour
from ..scan.pieces import ScanInput
from ..scan.raw import RawScan
from ..scan.reconstruct import reconstruct
from ..scan.scan import Scan
from ..scan.thin import thin_raw_scan
from .confidence import garment_confidence
from .hem_cap import cut_part
from .inner_side import find_inner_side
from .limb_ends import find_alternative, place_limb_ends
from .openings import Surroundings, find_openings
from .part import GARMENTS, Part
from .separation import FoundContour, FoundGarment, LabelledPerson, PersonSurface

MIN_GARMENT_AREA = 0.02
"""Area below which a part of the surface is no garment [m2]: a bandeau or a brief has 0.05."""


MAX_CLOUD_FACE_COUNT = 300_000
"""Largest number of triangles, two a point, of the surface made of a cloud: 4 mm of a person. The noise of the points
left is averaged as well as with more of them, at a tenth of a million points' cost."""

EXCLUDED_CONTOURS = {Part.UPPER: {"leg"}, Part.LOWER: {"neck", "armhole", "cuff"}}
"""Openings that a top and a bottom do not have."""

MAX_COVERED_BORDER_DISTANCE = 0.015
"""Largest median distance from a border to the points of another garment that covers it [m]: two samples."""


@dataclass(frozen=True)
class PointLabels:
    """Describe the labels of a scan's points.

    Attributes:
        part: A `Part` for each, shape [point_count].
        confidence: Probability of each over all readings of the outfit, shape [point_count].
        certainty: Probability of each under the best reading, shape [point_count].
    """

    part: np.ndarray
    confidence: np.ndarray
    certainty: np.ndarray


class PartNotWorn(BadInput):
    """The person does not wear this garment; name one of those that were found, or correct the labels file."""

    code = "segment.part_unknown"


def extract_garment(
    person: PersonSurface, separation: LabelledPerson, part: Part, hooks: Hooks = SILENT_HOOKS
) -> Reading:
    """Cut one garment out of a person's surface along a smooth line, without the seen part of its inner side.

    Args:
        person: The person's surface.
        separation: The same person's labels.
        part: Which garment.
        hooks: Cancellation.

    Returns:
        The input of `recover`: the garment, and the body that wears it.

    Raises:
        PartNotWorn: where no point has that label.
    """
    whole, label = person.scan, separation.label[person.origin]
    found = [garment for garment in separation.garments if garment.part == part]
    if not found or not (label == part).any():
        raise PartNotWorn(f"Nothing of {whole.name} is {part.word}; correct the labels file, or name another garment.")
    hooks.check()
    of_part = label == part
    inner = find_inner_side(whole, of_part, separation.body, label == Part.OTHER)
    cut = found[0].cut if person is separation.surface and not inner.any() else None
    garment, contours, holes = cut or cut_part(whole, of_part & ~inner, separation.body)
    hidden = _mark_inferred_contours(garment, contours, found[0].contours)
    hidden |= mark_covered_borders(garment, holes, whole.vertices[np.isin(label, GARMENTS) & (label != part)])
    garment = replace(garment, hidden=hidden)
    return Reading(ScanInput(garment, None), body=separation.body, category=found[0].category or None)


def find_garments(raw: RawScan, labels: PointLabels, surface: PersonSurface, body: Body) -> tuple[FoundGarment, ...]:
    """Find each garment's confidence, category and openings.

    Args:
        raw: The person.
        labels: Of its points.
        surface: The person's surface, of all points or fewer.
        body: The wearer.
    """
    worn = [part for part in GARMENTS if (labels.part == part).any()]
    confidences = {part: garment_confidence(labels.part, labels.confidence, part) for part in worn}
    row = raw.place[surface.origin]
    whole, label = surface.scan, labels.part[row]
    around = Surroundings.of(whole, label, labels.certainty[row], body)
    found = []
    for part in GARMENTS:
        of_part = label == part
        if part not in confidences or around.area[of_part].sum() < MIN_GARMENT_AREA:
            continue
        cut = cut_part(whole, of_part, body)
        category = choose_part_category(part, cut.contours, cut.garment, body)
        openings = find_openings(cut.garment, cut.contours, part, around)
        openings = place_limb_ends(openings, cut.contours, cut.garment.vertices, body)
        alternative = find_alternative(category, openings)
        found.append(FoundGarment(part, confidences[part], category, openings, cut, alternative=alternative))
    return tuple(found)


def choose_part_category(part: Part, contours: tuple[Contour, ...], garment: Scan, body: Body) -> str:
    """Choose the category of a garment that is known to be a top, a bottom or one piece.

    A top as long as a dress is a long top, since something is worn below it. A top that ends at the legs, or a bottom
    at the neck or arms, is labelled wrongly: it has no category, so that it is doubted.
    """
    stems = {contour.name.partition(".")[0] for contour in contours}
    if not contours or stems & EXCLUDED_CONTOURS.get(part, set()):
        return ""
    category = choose_category(contours, garment.vertices, body)
    if category == "dress" and part is not Part.ONE_PIECE:
        above = tuple(contour for contour in contours if contour.name != "hem")
        return choose_category(above, garment.vertices, body)
    return category


def mark_covered_borders(garment: Scan, holes: tuple[np.ndarray, ...], others: np.ndarray) -> np.ndarray:
    """Mark unnamed borders that another garment covers (trousers' tubes below a top), bool, shape [vertex_count]."""
    covered = np.zeros(len(garment.vertices), bool)
    tree = cKDTree(others) if len(others) else None
    for hole in holes:
        if tree is not None and np.median(tree.query(garment.vertices[hole])[0]) < MAX_COVERED_BORDER_DISTANCE:
            covered[hole] = True
    return covered


def build_person_surface(raw: RawScan, body: Body) -> PersonSurface:
    """Return a person's surface: a mesh's own, or the reconstructed one of a cloud.

    Args:
        raw: The person.
        body: The wearer, whose normals orient those of a cloud where the file's are not oriented.
    """
    raw = thin_raw_scan(raw, MAX_CLOUD_FACE_COUNT) if raw.is_cloud else raw
    points, faces, colours, origin = raw.points, raw.faces, raw.colours, raw.origin
    if raw.is_cloud:
        normals = estimate_normals(points) if raw.normals is None else raw.normals
        if not raw.is_oriented:
            normals = orient_normals(points, normals, body.vertices, vertex_normals(body.vertices, body.faces))
        made = reconstruct(points, normals, colours)
        points, faces, colours, origin = made.vertices, made.faces, made.colours, origin[made.nearest]
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
    return PersonSurface(scan, origin)


def _mark_inferred_contours(
    garment: Scan, contours: tuple[Contour, ...], openings: tuple[FoundContour, ...]
) -> np.ndarray:
    """Mark the vertices of the contours that are only inferred, bool, shape [vertex_count]."""
    inferred = {opening.name for opening in openings if opening.is_inferred}
    hidden = np.zeros(len(garment.vertices), bool)
    for contour in contours:
        if contour.name in inferred:
            hidden[contour.vertices] = True
    return hidden
