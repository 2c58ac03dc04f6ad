"""Read and write the labels file: the part of each point of a scan's file, and the names of the parts."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from ..scan.labels import read_labels
from ..scan.limits import Limits
from ..scan.refusal import LabelsUnreadable
from .part import Part

LABEL_NAME_COUNT = max(Part) + 1
"""Number of `names`: a label is the index of its name."""


def write_labels(
    label: np.ndarray,
    confidence: np.ndarray,
    path: Path,
    place: np.ndarray | None = None,
    origin: np.ndarray | None = None,
) -> Path:
    """Write `labels.npz`: `label` and `confidence` for each point of the scan's file, `names`, `place` and `origin`.

    Args:
        label: A `Part` for each point of the file, shape [file_count].
        confidence: Probability of each label, shape [file_count].
        path: Destination.
        place: Index in the cleaned scan of each point of the file, or -1, shape [file_count]; None: not written.
        origin: Index in the file of each point of the cleaned scan, shape [point_count]; None: not written.
    """
    names = np.full(LABEL_NAME_COUNT, "", dtype="<U16")
    for part in Part:
        names[part] = part.word
    arrays = {"label": label.astype(np.uint8), "confidence": confidence.astype(np.float32), "names": names}
    if place is not None:
        arrays["place"] = place.astype(np.int32)
    if origin is not None:
        arrays["origin"] = origin.astype(np.int32)
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]
    return path


def has_names(path: Path) -> bool:
    """Check whether a label file names the parts of a person: an `.npz` with an array `names`."""
    if path.suffix.lower() != ".npz" or not path.is_file():
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            return "names.npy" in archive.namelist()
    except (zipfile.BadZipFile, OSError):
        return False


def read_parts(path: Path, limits: Limits | None = None) -> np.ndarray:
    """Read the label file of a person: a `Part` for each point of the scan's file, uint8, shape [file_count].

    Args:
        path: An `.npz` with `label` (integers, indices into `names`) and `names` (the words of `Part`).
        limits: What reading may cost.

    Raises:
        LabelsUnreadable: where it is no label file, or a name is no part's.
    """
    label, names = read_labels(path, "label", limits), read_labels(path, "names", limits)
    words = {part.word: part for part in Part}
    if label.dtype.kind != "i" or names.dtype.kind != "U":
        raise LabelsUnreadable(
            f"{path.name}: `label` holds integers, `names` their words; save the labels as they came."
        )
    used = np.unique(label)
    if used[0] < 0 or used[-1] >= len(names):
        raise LabelsUnreadable(f"{path.name} has the label {used[-1]} without a name; name it, or give it another.")
    unknown = [str(names[value]) for value in used if str(names[value]) not in words]
    if unknown:
        raise LabelsUnreadable(f"{path.name} has the names {', '.join(unknown)}; the parts are {', '.join(words)}.")
    table = np.zeros(len(names), np.uint8)
    for value in used:
        table[value] = words[str(names[value])]
    return np.asarray(table[label])
