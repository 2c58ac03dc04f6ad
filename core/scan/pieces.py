"""Read the files of one recovery together: a garment alone, with its body, or a dressed person with labels."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..body.models.model_file import load_body_model
from ..body.spec import is_body_model
from . import refusal
from .cut import cut_garment
from .labels import read_labels
from .limits import Limits
from .load import _find_unit_and_axis, _Mesh, _read, _to_scan, lies_on, load_pair, load_scan
from .scan import Scan
from .selection import Selection
from .units import check_choice
from .vertex_selection import select_other_cloth, select_vertices


@dataclass(frozen=True)
class ScanInput:
    """Describe what the files of a recovery hold.

    Attributes:
        garment: The garment's surface; cut out where the scan is a dressed person.
        wearer: The body's mesh, or the whole dressed person, or None.
        cloth: True at the wearer's vertices that are any cloth, shape [vertex_count]; None if it is a bare body.
        labels: Label of each vertex of the scan that was cut, numbers or texts; None without labels or a cut.
    """

    garment: Scan
    wearer: Scan | None
    cloth: np.ndarray | None = None
    labels: np.ndarray | None = None


def load_scan_input(
    scan: Path,
    body: Path | None,
    *,
    units: str | None = None,
    up: str | None = None,
    selection: Selection | None = None,
    limits: Limits | None = None,
) -> ScanInput:
    """Read a garment with its body, or cut it out of the scan of a dressed person.

    Args:
        scan: The garment's file, or with a selection the dressed person's.
        body: The wearer's file, or None.
        units: A name of `UNITS`, or None to find it.
        up: `y` or `z`, or None to find it.
        selection: Which part of the scan is the garment; None: all of it.
        limits: What reading may cost.

    Raises:
        BadInput: with a code `scan.*` where a file cannot be used.
    """
    if selection is None:
        return ScanInput(*load_pair(scan, body, units=units, up=up, limits=limits))
    check_choice(units, up)
    mesh = _read(Path(scan), limits or Limits())
    labels = _labels_of(mesh, selection, limits)
    whole = _to_scan(mesh, *_find_unit_and_axis(mesh, units, up, "body"))
    selected = select_vertices(whole, labels, selection)
    cloth = selected | select_other_cloth(whole, labels, selection)
    garment = cut_garment(whole, selected)
    if labels is not None and selection.colour is None:
        garment = _note_skin_labels(garment, labels[~cloth])
    if body is None:
        return ScanInput(garment, whole, cloth, labels)
    if is_body_model(body):
        model = load_body_model(Path(body))
        wearer = Scan(model.vertices, model.faces, name=Path(body).stem)
    else:
        wearer = load_scan(body, units=units, up=up, kind="body", limits=limits)
    if not lies_on(garment.vertices, wearer):
        raise refusal.BodyApart(
            f"the garment cut out of {garment.name} does not lie on the body; export both from the same scene."
        )
    return ScanInput(garment, wearer, labels=labels)


def _note_skin_labels(garment: Scan, labels: np.ndarray) -> Scan:
    """Note the labels that are taken for skin if there are several: other clothes among them make the body too wide."""
    bare = [str(value) for value in np.unique(labels).tolist()]
    if len(bare) < 2:
        return garment
    shown = ", ".join(bare[:12]) + (", ..." if len(bare) > 12 else "")
    note = f"Took what has the labels {shown} for skin; name other clothes among them with --cloth."
    return replace(garment, repairs=(*garment.repairs, note))


def _labels_of(mesh: _Mesh, selection: Selection, limits: Limits | None) -> np.ndarray | None:
    """Return the label of each vertex of the repaired mesh, from the file beside the scan or its own."""
    if selection.labels is None or selection.colour is not None:
        return mesh.labels
    labels = read_labels(selection.labels, selection.key, limits)
    if len(labels) != mesh.count:
        raise refusal.LabelsMismatch(
            f"{selection.labels.name} holds {len(labels)} labels for the {mesh.count} vertices of {mesh.name}; "
            "give one label per vertex, in the order of the scan's file."
        )
    return np.asarray(labels[mesh.origin])
