"""How well labels and their probabilities are predicted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cli.bench.raw_labels import MIN_SURE_CONFIDENCE, measure_calibration
from ..core.people.part import CLOTH, PARTS

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
        sure: Share of samples at `MIN_SURE_CONFIDENCE` or more.
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
    return judge_labels(found, [posterior.max(axis=1) for posterior in posteriors], labels)


def judge_labels(found: list[np.ndarray], confidences: list[np.ndarray], labels: list[np.ndarray]) -> Judged:
    """Compare labels that were found, each with its confidence, with the true ones, one of each per scan."""
    means, cloths = [], []
    cloth = [int(part) for part in CLOTH]
    for ours, true in zip(found, labels, strict=True):
        means.append(np.mean([iou(ours == number, true == number) for number in np.unique(true)]))
        cloths.append(iou(np.isin(ours, cloth), np.isin(true, cloth)))
    ours, true, confidence = (np.concatenate(each) for each in (found, labels, confidences))
    right, sure = ours == true, confidence >= MIN_SURE_CONFIDENCE
    classes = {part.word: iou(ours == int(part), true == int(part)) for part in PARTS if (true == int(part)).any()}
    return Judged(
        accuracy=float(right.mean()),
        mean_iou=float(np.mean(means)),
        cloth_iou=float(np.mean(cloths)),
        iou=classes,
        ece=measure_calibration(true, ours, confidence).error,
        sure=float(sure.mean()),
        sure_right=float(right[sure].mean()) if sure.any() else 1.0,
    )


def iou(ours: np.ndarray, true: np.ndarray) -> float:
    """Return intersection over union of two masks, 1 where both are empty."""
    union = int((ours | true).sum())
    return float((ours & true).sum() / union) if union else 1.0


def find_temperature(logits: np.ndarray, labels: np.ndarray) -> float:
    """Return the temperature that makes logits [n, 8] of samples with column numbers [n] most probable."""
    from scipy.optimize import minimize_scalar

    def surprise(log_temperature: float) -> float:
        scaled = logits / np.exp(log_temperature)
        top = scaled.max(axis=1, keepdims=True)
        total = top[:, 0] + np.log(np.exp(scaled - top).sum(axis=1))
        return float((total - scaled[np.arange(len(labels)), labels]).mean())

    return float(np.exp(minimize_scalar(surprise, bounds=(-1.5, 2.5), method="bounded").x))
