"""Write labels that were corrected by hand on the cleaned scan into a labels file for the scan's own file."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from ..run.errors import BadInput
from ..run.npy import read_array
from ..scan.refusal import LabelsMismatch, LabelsUnreadable
from .labels import write_labels
from .part import Part

MAX_CORRECTED_LABEL_COUNT = 50_000_000
"""Largest number of labels that are read; more than the points of any file within the limits."""


class LabelsOld(BadInput):
    """These labels were stored by an earlier version, or handed in; label the scan anew, then correct those labels."""

    code = "labels.old"


def read_corrected_labels(path: Path) -> np.ndarray:
    """Read an untrusted `.npy` file with a `Part` for each point of the cleaned scan, uint8, shape [point_count].

    Raises:
        LabelsUnreadable: where it has no labels, or a number of no part.
    """

    def judge(shape: tuple[int, ...], kind: np.dtype) -> None:
        if len(shape) != 1 or not 0 < shape[0] <= MAX_CORRECTED_LABEL_COUNT or kind != np.uint8:
            raise ValueError("it is no row of bytes")

    try:
        with path.open("rb") as file:
            label = read_array(file, judge)
    except (ValueError, OSError, EOFError, SyntaxError) as error:
        raise LabelsUnreadable(f"{path.name} holds no labels: {str(error)[:100]}; write them as uint8.") from error
    unknown = np.setdiff1d(label, [int(part) for part in Part])
    if len(unknown):
        raise LabelsUnreadable(f"{path.name} has the label {unknown[0]}, which is no part's; write their numbers.")
    return label


def apply_corrected_labels(stored: Path, labels: np.ndarray, path: Path) -> Path:
    """Write a labels file as it was stored, with corrected labels where the cleaned scan has points.

    Copies of a split vertex are one point of the file; a label that is changed at any of them is its label.

    Args:
        stored: The `labels.npz` of a person's result.
        labels: A `Part` for each point of its `segmented.ply`, uint8, shape [point_count].
        path: Destination.

    Raises:
        LabelsOld: where the stored file does not map the points of the file to the cleaned scan.
        LabelsMismatch: where there are more or fewer labels than points.
    """
    try:
        with np.load(stored, allow_pickle=False) as arrays:
            label, place = arrays["label"].copy(), arrays["place"]
            origin = arrays["origin"] if "origin" in arrays else None
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        raise LabelsOld() from error
    kept = place >= 0
    count = int(place.max(initial=-1)) + 1 if origin is None else len(origin)
    if origin is None and len(labels) > count:
        raise LabelsOld()  # It may have copies of split vertices, which the file does not count.
    if len(labels) != count:
        raise LabelsMismatch(f"there are {len(labels)} labels for the {count} points of segmented.ply; give each one.")
    if origin is not None:
        changed = np.flatnonzero(labels != label[origin])
        labels = labels.copy()
        labels[place[origin[changed]]] = labels[changed]
    label[kept] = labels[place[kept]]
    return write_labels(label, np.ones(len(label)), path, place, origin)
