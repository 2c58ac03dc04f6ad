"""Find garments that the marks of a scan's cloth leave to the skin, so that the body was fitted to them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..body.body import Body
from ..geometry.geometry import vertex_normals
from ..geometry.surface import TriangleSurface
from .part import GARMENTS, PARTS
from .points import PersonPoints

MIN_UNDECLARED_SHARE = 0.05
"""Least share of the samples that a garment among the skin must have; a cut drops smaller pieces, too."""

MAX_UNMARKED_SHARE = 0.25
"""Largest share of a predicted garment that may be skin by the marks; beyond it the garment was not marked. A marked
one leaves its border, and hair that falls on it: 0.13 under long hair. Of two that look like one piece the smaller,
shorts under a shirt, is a third."""

LABEL_MAJORITY_SHARE = 0.5
"""Share of a label's unmarked samples above which the label is named as the garment's."""

MAX_SKIN_OFFSET_RMS = 9e-3
"""Largest RMS distance between the fitted body and skin [m]: bare bodies of other makes are 3.3 to 8.2 mm from it, skin
beside clothes 1.9 to 7 mm (docs/lab/body.md). Garments that were taken for skin were 13 to 36 mm off."""


@dataclass(frozen=True)
class UndeclaredGarment:
    """Describe a garment that was taken for skin.

    Attributes:
        part: Its word: `lower`.
        labels: The labels that are mostly it, the most frequent first, else the one that most of it has; empty where
            the scan has no labels.
        is_whole: Whether these labels are mostly it.
        offset: RMS distance from the body that is fitted below it instead of to it [m].
    """

    part: str
    labels: tuple[str, ...]
    is_whole: bool
    offset: float

    @property
    def is_off_body(self) -> bool:
        """Check whether it is farther from the body than skin is."""
        return self.offset > MAX_SKIN_OFFSET_RMS

    def describe(self) -> str:
        """Return a sentence for the user, with the next step."""
        names = ", ".join(self.labels)
        what = f"Label {names}" if self.labels else "What is not of the garment's colour"
        position = (
            f"{what} was taken for skin, but holds what looks like a garment ({self.part}) and lies "
            f"{1e3 * self.offset:.0f} mm (RMS) off the body below it"
        )
        if self.labels and self.is_whole:
            return f"{position}; give --cloth {','.join(self.labels)} if it is cloth."
        return f"{position}; give that garment a label of its own, and name it with --cloth."


def find_undeclared_garments(
    points: PersonPoints,
    unmarked: np.ndarray,
    marked: np.ndarray,
    labels: np.ndarray | None,
    fit_below: Callable[[np.ndarray], Body],
) -> tuple[UndeclaredGarment, ...]:
    """Find the garments among the skin by the marks, and the distance of each from the body below it.

    A garment that is predicted without the marks, and is skin by them, may be skin all the same: then a body that is
    fitted as below cloth coincides with it. So each is measured; those that are off the body are reported.

    Args:
        points: The samples.
        unmarked: Their posterior without the marks, shape [n, part_count].
        marked: Which of them are cloth by the marks, bool, shape [n].
        labels: Label of each sample, numbers or texts, shape [n], or None.
        fit_below: Fits the body below what is cloth, bool, shape [n].
    """
    found, likeliest = [], unmarked.argmax(axis=1)
    for part in GARMENTS:
        of_part = likeliest == PARTS.index(part)
        left = of_part & ~marked
        if left.sum() < MIN_UNDECLARED_SHARE * len(of_part) or left.sum() <= MAX_UNMARKED_SHARE * of_part.sum():
            continue
        body = fit_below(marked | left)
        _, nearest = cKDTree(body.vertices).query(points.positions[left])
        outward = (vertex_normals(body.vertices, body.faces)[nearest] * points.normals[left]).sum(axis=1) > 0.0
        distance = TriangleSurface(body.vertices, body.faces).distance(points.positions[left])[outward]
        offset = float(np.sqrt((distance**2).mean())) if len(distance) else 0.0
        found.append(UndeclaredGarment(part.word, *_name_labels(labels, left, marked), offset))
    return tuple(found)


def _name_labels(labels: np.ndarray | None, left: np.ndarray, marked: np.ndarray) -> tuple[tuple[str, ...], bool]:
    """Return the labels that are mostly among some samples, or else the most frequent there, and whether one is."""
    if labels is None:
        return (), False
    values, counts = np.unique(labels[left], return_counts=True)
    order = np.argsort(-counts, kind="stable")
    is_mostly = np.array([counts[n] > LABEL_MAJORITY_SHARE * (~marked & (labels == values[n])).sum() for n in order])
    chosen = values[order][is_mostly] if is_mostly.any() else values[order][:1]
    return tuple(str(value) for value in chosen.tolist()), bool(is_mostly.any())
