"""Describe the content of a garment's file before a job runs."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..core.body.body import Body
from ..core.body.models.model_file import load_body_model
from ..core.body.spec import BuiltinWearer, Wearer, is_body_model
from ..core.people.wearer import FoundWearer, fit_wearer
from ..core.scan.contours.body_mismatch import find_misfit_warnings
from ..core.scan.contours.garment import segment_garment
from ..core.scan.contours.loop import find_loops, smoothed_length
from ..core.scan.contours.rounded_rims import straighten_scan
from ..core.scan.limits import Limits
from ..core.scan.pieces import ScanInput, load_scan_input
from ..core.scan.scan import Scan, describe_scan
from ..core.scan.selection import Selection


@dataclass(frozen=True)
class Inspection:
    """Describe what was understood of a garment's file and of the body that came with it.

    Attributes:
        name: The file's stem.
        sha256: Hash of the file's bytes (hex).
        units: Unit of the file, found or given.
        up: Up axis of the file, found or given.
        extent_m: Sides of the bounding box [m], y up.
        vertex_count: Vertices after repair.
        face_count: Faces after repair.
        area_m2: Area of the surface [m2].
        repairs: What was repaired, one sentence each.
        has_colours: Whether the vertices have colours.
        has_labels: Whether the vertices have labels.
        boundaries_m: Smoothed length of every open boundary [m], longest first.
        contours_m: Name and smoothed length of each contour [m]; None where no body was given.
        contour_bones: Name and bones of each contour; None where no body was given.
        holes_m: Smoothed length of each hole [m]; None where no body was given.
        category: The category that would be chosen; None where no body was given.
        body: What the body is and how well its skeleton fits; None where no body was given.
        remarks: Warnings about the body that was given, one sentence each.
    """

    name: str
    sha256: str
    units: str
    up: str
    extent_m: tuple[float, float, float]
    vertex_count: int
    face_count: int
    area_m2: float
    repairs: tuple[str, ...]
    has_colours: bool
    has_labels: bool
    boundaries_m: tuple[float, ...]
    contours_m: dict[str, float] | None = None
    contour_bones: dict[str, tuple[str, ...]] | None = None
    holes_m: tuple[float, ...] | None = None
    category: str | None = None
    body: dict[str, Any] | None = None
    remarks: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return everything as plain JSON values."""
        return {key: _plain(value) for key, value in asdict(self).items()}


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    return [_plain(entry) for entry in value] if isinstance(value, (tuple, list)) else value


def inspect_file(
    path: Path,
    body: Body | Wearer | None = None,
    *,
    units: str | None = None,
    up: str | None = None,
    selection: Selection | None = None,
    limits: Limits | None = None,
) -> Inspection:
    """Read a garment's file; with a body name its contours, and choose its category.

    Of a dressed person's scan the selected garment is cut out, and if no body is given it is fitted below the clothes.

    Args:
        path: The garment's mesh file.
        body: The wearer: a ready `Body`, a mesh file, a built-in body, or None.
        units: A name of `UNITS`, or None to find it.
        up: `y` or `z`, or None to find it.
        selection: Which part of a dressed person's scan is the garment; None: all of the file is.
        limits: What reading may cost.

    Raises:
        BadInput: where a file cannot be used, or no contour is found on the given body.
    """
    mesh = body if isinstance(body, Path) else None
    pieces = load_scan_input(Path(path), mesh, units=units, up=up, selection=selection, limits=limits)
    scan, wearer = straighten_scan(pieces.garment), pieces.wearer  # as the recovery will
    boundaries = sorted((smoothed_length(scan.vertices[loop]) for loop in find_loops(scan.faces)), reverse=True)
    known = _describe(scan, boundaries)
    found = find_wearer(body, pieces)
    if found is None:
        return Inspection(**known)
    found_body = found.body
    target = segment_garment(scan, found_body)
    return Inspection(
        **known,
        contours_m={contour.name: round(contour.length, 4) for contour in target.contours},
        contour_bones={contour.name: contour.bones for contour in target.contours},
        holes_m=tuple(round(smoothed_length(scan.vertices[hole]), 4) for hole in target.holes),
        category=target.category,
        remarks=(
            *(one.describe() for one in found.undeclared or () if one.is_off_body),
            *find_misfit_warnings(scan.vertices, found_body),
        ),
        body={
            "source": found_body.source,
            "height_m": round(float(np.ptp(found_body.vertices[:, 1])), 4),
            "fit_rms_mm": round(1e3 * found_body.fit_rms, 2),
            "repairs": list(wearer.repairs) if wearer is not None else [],
        },
    )


def _describe(scan: Scan, boundaries: list[float]) -> dict[str, Any]:
    found = describe_scan(scan)
    lengths = tuple(round(length, 4) for length in boundaries)
    return found | {"extent_m": tuple(found["extent_m"]), "repairs": scan.repairs, "boundaries_m": lengths}


def find_body(body: Body | Wearer | None, pieces: ScanInput) -> Body | None:
    """Return the body that `find_wearer` finds."""
    found = find_wearer(body, pieces)
    return None if found is None else found.body


def find_wearer(body: Body | Wearer | None, pieces: ScanInput) -> FoundWearer | None:
    """Return the body given with a garment, or the wearer of the scan that it was cut out of; None without either."""
    if isinstance(body, Body):
        return FoundWearer(body)
    if isinstance(body, BuiltinWearer):
        from ..core.body.builtin import builtin_body

        return FoundWearer(builtin_body(body))
    if body is not None and is_body_model(body):
        return FoundWearer(load_body_model(body))
    return None if pieces.wearer is None else fit_wearer(pieces.wearer, pieces.cloth, labels=pieces.labels)
