"""Select the garment's vertices of a clothed scan: by labels in the file or beside it, or by colour."""

from __future__ import annotations

import numpy as np

from . import refusal
from .scan import Scan
from .selection import Selection, parse_colour


def select_vertices(scan: Scan, labels: np.ndarray | None, selection: Selection) -> np.ndarray:
    """Mark the garment's vertices, bool, shape [vertex_count].

    Args:
        scan: The whole scan.
        labels: Label of each of its vertices, numbers or texts, shape [vertex_count], or None.
        selection: What to keep.

    Raises:
        LabelsMissing: where there are neither labels nor colours.
        LabelUnknown: where nothing or everything is kept, or the selection does not name what to keep.
    """
    if selection.colour is not None:
        mask = _near_colour(scan, selection.colour, selection.tolerance)
        what = f"the colour {selection.colour} (within {selection.tolerance:g})"
    elif labels is None:
        raise refusal.LabelsMissing(f"{scan.name} has no labels; {_next_step(refusal.LabelsMissing)}")
    else:
        mask, what = _kept_labels(scan, labels, selection.keep)
    share = float(mask.mean())
    if not 0.0 < share < 1.0:
        found = "no vertex" if share == 0.0 else "every vertex"
        raise refusal.LabelUnknown(f"{found} of {scan.name} has {what}; {_next_step(refusal.LabelUnknown)}")
    return mask


def select_other_cloth(scan: Scan, labels: np.ndarray | None, selection: Selection) -> np.ndarray:
    """Mark the vertices of the other clothes, bool, shape [vertex_count]; none where the selection names none.

    Raises:
        LabelsMissing: where there are no labels.
        LabelUnknown: where the scan lacks one of them.
    """
    if not selection.cloth:
        return np.zeros(len(scan.vertices), bool)
    if labels is None:
        raise refusal.LabelsMissing(f"{scan.name} has no labels; {_next_step(refusal.LabelsMissing)}")
    return _kept_labels(scan, labels, selection.cloth, "--cloth")[0]


def _kept_labels(
    scan: Scan, labels: np.ndarray, keep: tuple[str, ...], option: str = "--keep"
) -> tuple[np.ndarray, str]:
    values, index = np.unique(labels, return_inverse=True)
    texts = [str(value) for value in values.tolist()]
    shown = ", ".join(texts[:12]) + (", ..." if len(texts) > 12 else "")
    if not keep:
        if texts != ["0", "1"]:
            raise refusal.LabelUnknown(f"{scan.name} has the labels {shown}; say with --keep which is the garment.")
        keep = ("1",)
    unknown = [text for text in keep if text not in texts]
    if unknown:
        raise refusal.LabelUnknown(f"{scan.name} has no label {', '.join(unknown)}, but {shown}; correct {option}.")
    return np.isin(index.ravel(), [texts.index(text) for text in keep]), f"the label {', '.join(keep)}"


def _near_colour(scan: Scan, text: str, tolerance: float) -> np.ndarray:
    if scan.colours is None:
        raise refusal.LabelsMissing(f"{scan.name} has no vertex colours; {_next_step(refusal.LabelsMissing)}")
    colour = np.array(parse_colour(text))
    return np.asarray(np.linalg.norm(255.0 * scan.colours - colour, axis=1) <= tolerance)


def _next_step(kind: type[Exception]) -> str:
    return str(kind.__doc__).partition("; ")[2]
