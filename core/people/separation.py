"""Describe what is found when a person's scan is labelled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..body.body import Body
from ..run.errors import GarmentqError
from ..scan.scan import Scan
from .hem_cap import CutPart
from .part import Part


@dataclass(frozen=True)
class LimbEnd:
    """Describe where on its limb a sleeve or leg ends.

    Attributes:
        bone_place: Place [bones]: 0 at the shoulder or hip joint, 1 at elbow or knee, 2 at wrist or ankle.
        limb_share: Share of the length from the shoulder to the wrist joint, or from hip to ankle.
        bone_deviation: Standard deviation of `bone_place` [bones], or None where nothing shows it.
        share_deviation: The same of `limb_share`.
    """

    bone_place: float
    limb_share: float
    bone_deviation: float | None
    share_deviation: float | None


@dataclass(frozen=True)
class CategoryAlternative:
    """Describe the category that a garment may have instead of the one that was chosen.

    Attributes:
        category: One of `CATEGORIES`.
        probability: That it is the right one of the two.
    """

    category: str
    probability: float


@dataclass(frozen=True)
class FoundContour:
    """Describe an opening of a garment.

    Attributes:
        name: One of `CONTOUR_NAMES`.
        confidence: Probability that it is within 2 cm of where it was found.
        is_inferred: Whether nothing in the scan shows it: then it is neither fitted nor measured.
        interval: Half the width of the interval that it lies in with 0.9 [m]; None where it is hidden and not known.
        limb_end: Where on its limb it is; None for what is not around a limb.
    """

    name: str
    confidence: float
    is_inferred: bool
    interval: float | None = None
    limb_end: LimbEnd | None = None


@dataclass(frozen=True)
class FoundGarment:
    """Describe one garment of an outfit.

    Attributes:
        part: Which it is.
        confidence: Mean probability of its points' labels.
        category: One of `CATEGORIES`, from its openings on the body, or an empty text.
        contours: Its openings.
        cut: It as cut out of the surface on which the openings were found, or None.
        problem: Why it is not recovered until a person has checked the labels, or None.
        alternative: The category that it has if its sleeves or legs end a little elsewhere, or None.
    """

    part: Part
    confidence: float
    category: str
    contours: tuple[FoundContour, ...] = ()
    cut: CutPart | None = None
    problem: GarmentqError | None = None
    alternative: CategoryAlternative | None = None


@dataclass(frozen=True)
class Outfit:
    """Describe one reading of what is worn.

    Attributes:
        parts: The garments, in the order of `GARMENTS`.
        score: Log-probability, up to a constant that all readings of one scan share.
    """

    parts: tuple[Part, ...]
    score: float


@dataclass(frozen=True)
class PersonSurface:
    """Describe a person's surface, from which every garment is cut.

    Attributes:
        scan: The surface; reconstructed if the scan is a cloud.
        origin: Index in the file of the point that each vertex is, or is nearest to, shape [vertex_count].
    """

    scan: Scan
    origin: np.ndarray


@dataclass(frozen=True)
class LabelledPerson:
    """Describe a labelled person.

    Attributes:
        body: The wearer under the clothes, in the scan's place and pose [m].
        label: A `Part` for each point of the file, dropped ones included (OTHER), uint8, shape [file_count].
        confidence: Probability of each label, float32, shape [file_count].
        garments: What was found, in the order of `GARMENTS`.
        outfits: Readings, the best first.
        warnings: What the user should know, one sentence each.
        problem: Why nothing is recovered until a person has checked the labels; None where some garment is.
        surface: The person's surface where the openings were found on all of it; None where it was thinned for them.
    """

    body: Body
    label: np.ndarray
    confidence: np.ndarray
    garments: tuple[FoundGarment, ...]
    outfits: tuple[Outfit, ...]
    warnings: tuple[str, ...] = ()
    problem: GarmentqError | None = None
    surface: PersonSurface | None = None
