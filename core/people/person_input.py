"""Read the files of a dressed person, and pass their content from a limited process as plain arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..body.body import Body
from ..body.models.model_file import load_body_model
from ..body.spec import is_body_model
from ..garment.garmentcode import load_pattern
from ..garment.pattern import Pattern
from ..run.records import read_record, write_record
from ..run.sandbox import ReaderCrashed
from ..scan.limits import Limits
from ..scan.load import load_scan
from ..scan.raw import RawScan
from ..scan.refusal import LabelsMismatch, StatureUnknown
from ..scan.scan import Scan
from .labels import read_parts

MAX_LISTED_NOTES = 20
"""Largest number of a scan's notes that a description lists."""


@dataclass(frozen=True)
class PersonFiles:
    """Describe the files of one person.

    Attributes:
        scan: The raw scan.
        labels: A label file with `names`, or None.
        body: The wearer's file, or None.
        patterns: Pattern files by the word of the garment; by the empty word that of the only one.
        units: A name of `UNITS`, of scan and body, or None to find it.
        up: `y` or `z` of both, or None to find it.
        height: How high the person stands [m], where the scan has no unit; None: its unit tells.
    """

    scan: Path
    labels: Path | None = None
    body: Path | None = None
    patterns: Mapping[str, Path] = field(default_factory=dict)
    units: str | None = None
    up: str | None = None
    height: float | None = None


@dataclass(frozen=True)
class PersonInput:
    """Describe the content of a person's files.

    Attributes:
        raw: The scan.
        label: A `Part` for each point of the file where labels were given, uint8, shape [file_count], or None.
        wearer: The wearer's mesh, or None.
        body: The wearer, if its file is of SMPL's format, or None.
        patterns: Base patterns, as `PersonFiles.patterns`.
    """

    raw: RawScan
    label: np.ndarray | None = None
    wearer: Scan | None = None
    body: Body | None = None
    patterns: Mapping[str, Pattern] = field(default_factory=dict)


def read_person_input(files: PersonFiles, limits: Limits | None = None) -> PersonInput:
    """Read all files of a person.

    Raises:
        StatureUnknown: where neither the scan's size nor the user tells how high the person is.
        BadInput: where a file cannot be used.
    """
    from ..scan.load_raw import load_raw

    raw = load_raw(files.scan, files.units, files.up, limits, stature=files.height)
    check_scale(raw, files.height)
    label = None if files.labels is None else read_parts(files.labels, limits)
    if label is not None and len(label) != len(raw.place):
        raise LabelsMismatch(
            f"{files.labels.name if files.labels else ''} holds {len(label)} labels for the {len(raw.place)} points of "
            f"{raw.name}; give one for each point of the scan's file, in its order."
        )
    wearer = body = None
    if files.body is not None and is_body_model(files.body):
        body = load_body_model(files.body)
    elif files.body is not None:
        wearer = load_scan(files.body, units=files.units, up=files.up, kind="body", limits=limits)
    return PersonInput(raw, label, wearer, body, {word: load_pattern(path) for word, path in files.patterns.items()})


def check_scale(raw: RawScan, height: float | None) -> None:
    """Check that the scale of a scan is known: by its unit, or by the height [m] that the user gave.

    Raises:
        StatureUnknown: where it is not.
    """
    if raw.units == "unknown" and height is None:
        size = float(np.ptp(raw.points[:, 1]))
        raise StatureUnknown(
            f"{raw.name} has no unit in which it is a person: a height of {size:.2f} m is a guess. "
            f"{StatureUnknown().message}"
        )


def describe_person_input(content: PersonInput) -> dict[str, Any]:
    """Describe the content of the files as JSON values."""
    raw = content.raw
    low, high = raw.points.min(axis=0), raw.points.max(axis=0)
    found: dict[str, Any] = {
        "as": "person",
        "scan": {
            "name": raw.name, "units": raw.units, "up": raw.up_axis, "is_cloud": raw.is_cloud,
            "vertex_count": len(raw.points), "face_count": len(raw.faces), "file_count": len(raw.place),
            "extent_m": [round(float(side), 4) for side in high - low], "has_colours": raw.colours is not None,
            "notes": list(raw.notes[:MAX_LISTED_NOTES]),
        },
    }  # fmt: skip
    if content.label is not None:
        values, counts = np.unique(content.label, return_counts=True)
        found["labels"] = {str(v): c for v, c in zip(values.tolist(), counts.tolist(), strict=True)}
    if content.patterns:
        found["patterns"] = {word: pattern.name for word, pattern in content.patterns.items()}
    return found


def save_person_input(content: PersonInput, path: Path) -> None:
    """Write the content of the files as plain arrays."""
    write_record(content, path)


def load_person_input(path: Path) -> PersonInput:
    """Read what `save_person_input` wrote in a limited process; it is untrusted: no pickle, nothing compressed.

    Raises:
        ReaderCrashed: where it is something else.
    """
    content = read_record(PersonInput, path)
    try:
        _check_scan_arrays(content.raw)
    except (ValueError, TypeError) as error:
        raise ReaderCrashed() from error
    return content


def _check_scan_arrays(raw: RawScan) -> None:
    """Check that the arrays of a scan fit each other; raise ValueError where they do not."""
    count, files = len(raw.points), len(raw.place)
    rows: dict[str, tuple[np.ndarray, tuple[int, ...]]] = {
        "points": (raw.points, (count, 3)), "faces": (raw.faces, (len(raw.faces), 3)), "place": (raw.place, (files,))
    }  # fmt: skip
    for name in ("normals", "colours"):
        if (array := getattr(raw, name)) is not None:
            rows[name] = (array, (count, 3))
    wrong = [name for name, (array, shape) in rows.items() if array.shape != shape or array.dtype.kind not in "iuf"]
    indices = [raw.faces.ravel(), raw.place]
    if wrong or not count or not np.isfinite(raw.points).all():
        raise ValueError("arrays of other shapes")
    if any(a.size and (a.dtype.kind not in "iu" or a.min() < -1 or a.max() >= count) for a in indices):
        raise ValueError("indices out of range")
    if raw.faces.size and raw.faces.min() < 0:
        raise ValueError("negative indices")
