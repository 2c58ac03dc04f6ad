"""How well labels and their probabilities are predicted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..core.person import CLOTH, PARTS

BINS = 15
"""Bins of confidence for the calibration error."""

SURE = 0.9
"""Probability from which a point counts as surely told."""

NUMBERS = np.array([int(part) for part in PARTS])
"""Label of each column of a posterior."""


@dataclass(frozen=True)
class Judged:
    """Figures of one or several scans.

    Attributes:
        accuracy: Share of samples with the right part.
        mean_iou: Intersection over union, mean of the classes in each scan's truth, then of the scans.
        cloth_iou: Of cloth against the rest, mean of the scans.
        iou: Of each part over all samples, by its word.
        ece: Expected calibration error.
        sure: Share of samples at `SURE` or more.
        sure_right: Share of these that are right.
    """

    accuracy: float
    mean_iou: float
    cloth_iou: float
    iou: dict[str, float]
    ece: float
    sure: float
    sure_right: float


def judge(posteriors: list[np.ndarray], labels: list[np.ndarray]) -> Judged:
    """Compare posteriors in the order of `PARTS` with labels, one of each per scan."""
    found = [NUMBERS[posterior.argmax(axis=1)] for posterior in posteriors]
    means, cloths = [], []
    cloth = [int(part) for part in CLOTH]
    for ours, true in zip(found, labels, strict=True):
        means.append(np.mean([iou(ours == number, true == number) for number in np.unique(true)]))
        cloths.append(iou(np.isin(ours, cloth), np.isin(true, cloth)))
    ours, true = np.concatenate(found), np.concatenate(labels)
    confidence = np.concatenate([posterior.max(axis=1) for posterior in posteriors])
    right, sure = ours == true, confidence >= SURE
    classes = {part.word: iou(ours == int(part), true == int(part)) for part in PARTS if (true == int(part)).any()}
    return Judged(
        accuracy=float(right.mean()),
        mean_iou=float(np.mean(means)),
        cloth_iou=float(np.mean(cloths)),
        iou=classes,
        ece=calibration_error(confidence, right),
        sure=float(sure.mean()),
        sure_right=float(right[sure].mean()) if sure.any() else 1.0,
    )


def iou(ours: np.ndarray, true: np.ndarray) -> float:
    """Return intersection over union of two masks, 1 where both are empty."""
    union = int((ours | true).sum())
    return float((ours & true).sum() / union) if union else 1.0


def calibration_error(confidence: np.ndarray, right: np.ndarray) -> float:
    """Return the expected calibration error: mean gap of confidence and share right in `BINS` bins of confidence."""
    place = np.minimum((confidence * BINS).astype(int), BINS - 1)
    count = np.bincount(place, minlength=BINS)
    gap = np.bincount(place, confidence, BINS) - np.bincount(place, right, BINS)
    return float(np.abs(gap).sum() / max(count.sum(), 1))


def find_temperature(logits: np.ndarray, labels: np.ndarray) -> float:
    """Return the temperature that makes logits [n, 8] of samples with column numbers [n] most probable."""
    from scipy.optimize import minimize_scalar

    def surprise(log_temperature: float) -> float:
        scaled = logits / np.exp(log_temperature)
        top = scaled.max(axis=1, keepdims=True)
        total = top[:, 0] + np.log(np.exp(scaled - top).sum(axis=1))
        return float((total - scaled[np.arange(len(labels)), labels]).mean())

    return float(np.exp(minimize_scalar(surprise, bounds=(-1.5, 2.5), method="bounded").x))
