"""Measure the labels of a raw scan against the true ones: overlap of the parts, and calibration of the confidence."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ...core.people.part import GARMENTS, Part

PERSON_PARTS = (Part.SKIN, Part.HAIR, Part.SHOES, *GARMENTS)
"""The parts that count; points that truly are not part of the person are left out."""

MIN_SURE_CONFIDENCE = 0.9
"""Least probability of its label at which a point counts as sure."""

CALIBRATION_BIN_COUNT = 15
"""Number of bins of confidence, of equal width, as the expected calibration error is usually stated (Guo et al.
2017)."""


@dataclass(frozen=True)
class LabelScore:
    """Describe how labels agree with the true ones, over the points that truly belong to the person.

    Attributes:
        accuracy: Share of the points whose part is right.
        cloth_iou: Intersection over union of all garments together against the rest.
        part_iou: Intersection over union of each part that exists in truth, or was found, by its word.
        mean_iou: Unweighted mean of `part_iou`.
    """

    accuracy: float
    cloth_iou: float | None
    part_iou: dict[str, float]
    mean_iou: float


@dataclass(frozen=True)
class Calibration:
    """Describe how the confidence of labels agrees with how often they are right.

    Attributes:
        error: Expected calibration error: mean over `CALIBRATION_BIN_COUNT` bins of |share right - mean confidence|,
            weighted by points.
        sure: Share of the points at `MIN_SURE_CONFIDENCE` or above.
        sure_right: Share of these that are right; None if there are none.
        least_sure_right: Share of the others that are right; None if there are none.
    """

    error: float
    sure: float
    sure_right: float | None
    least_sure_right: float | None


def measure_labels(truth: np.ndarray, found: np.ndarray) -> LabelScore:
    """Measure labels, shape [n], against the true ones, shape [n]; intersection over union counts points."""
    person = truth != Part.OTHER
    truth, found = truth[person], found[person]
    parts = {
        part.word: overlap for part in PERSON_PARTS if (overlap := measure_overlap(truth, found, (part,))) is not None
    }
    return LabelScore(
        accuracy=float(np.mean(truth == found)),
        cloth_iou=measure_overlap(truth, found, GARMENTS),
        part_iou=parts,
        mean_iou=float(np.mean(list(parts.values()))) if parts else 0.0,
    )


def measure_overlap(truth: np.ndarray, found: np.ndarray, parts: Iterable[int]) -> float | None:
    """Measure the intersection over union of some parts taken together; None if neither labelling has them."""
    numbers = [int(part) for part in parts]
    one, other = np.isin(truth, numbers), np.isin(found, numbers)
    either = int(np.sum(one | other))
    return float(np.sum(one & other) / either) if either else None


def measure_calibration(truth: np.ndarray, found: np.ndarray, confidence: np.ndarray) -> Calibration:
    """Measure the confidence of labels, 0 to 1, shape [n]."""
    right = truth == found
    place = np.clip((confidence * CALIBRATION_BIN_COUNT).astype(int), 0, CALIBRATION_BIN_COUNT - 1)
    count = np.bincount(place, minlength=CALIBRATION_BIN_COUNT)
    gap = np.bincount(place, right, CALIBRATION_BIN_COUNT) - np.bincount(place, confidence, CALIBRATION_BIN_COUNT)
    is_confident = confidence >= MIN_SURE_CONFIDENCE

    def share(mask: np.ndarray) -> float | None:
        return float(right[mask].mean()) if mask.any() else None

    return Calibration(
        error=float(np.abs(gap).sum() / max(1, count.sum())),
        sure=float(is_confident.mean()),
        sure_right=share(is_confident),
        least_sure_right=share(~is_confident),
    )
