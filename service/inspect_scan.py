"""Find what a file holds before a job runs: a whole person, or a garment alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..core.body.builtin import BodyMissing
from ..core.body.person import fit_person
from ..core.body.presence import MIN_WHOLE_PERSON_HEIGHT, ScanPartial
from ..core.body.registration import NotHuman
from ..core.body.spec import Wearer, read_wearer
from ..core.people.person_input import (
    MAX_LISTED_NOTES,
    PersonFiles,
    PersonInput,
    check_scale,
    describe_person_input,
    read_person_input,
)
from ..core.people.separate import check_single_person
from ..core.people.whole_person import MIN_ADULT_HEIGHT, MIN_PERSON_HEIGHT_SHARE, has_person_height, shows_person
from ..core.run.errors import BadInput
from ..core.scan.limits import Limits
from ..core.scan.load import load_scan
from ..core.scan.load_raw import load_raw
from ..core.scan.pieces import load_scan_input
from ..core.scan.raw import RawScan
from ..core.scan.refusal import MeshEmpty, NoFaces, StatureUnknown
from ..core.scan.scan import Scan, describe_scan
from .inspect_garment import find_body, inspect_file

PERSON, GARMENT = "person", "garment"
"""What a file can hold."""


def inspect_person(
    path: Path, units: str | None = None, up: str | None = None, height: float | None = None
) -> dict[str, Any]:
    """Read a raw scan and find its wearer.

    Args:
        path: The file.
        units: A name of `UNITS`, or None to find it.
        up: One of `AXES_UP`, or None to find it.
        height: How high the person stands [m], or None: the unit tells.

    Returns:
        What was understood, as JSON values; `as` is `person`.

    Raises:
        BadInput: where it is no person, or cannot be used.
    """
    raw = read_person_input(PersonFiles(path, units=units, up=up, height=height)).raw
    return describe_person_input(PersonInput(raw)) | {"body": _describe_wearer(raw)}


def inspect_order(
    source: str,
    given_as: str | None = None,
    body: str | None = None,
    units: str | None = None,
    up: str | None = None,
    height: float | None = None,
    is_quick: bool = False,
) -> dict[str, Any]:
    """Describe an uploaded scan before a job is requested; runs in a limited process.

    Args:
        source: The file.
        given_as: `PERSON` or `GARMENT`, or None to find it.
        body: The description of a built-in body, or None.
        units: A name of `UNITS`, or None to find it.
        up: `y` or `z`, or None to find it.
        height: How high the person stands [m], or None: the unit tells.
        is_quick: Read the file alone; where `given_as` is None its height decides what it is.

    Returns:
        JSON values: `as`, `is_sure` (false if only the job can find that it is otherwise), `scan`, `body` (the wearer
        that was found), `category` and `contours_m` of a garment on a body, `remarks` (warnings about that body), and
        `needs`, the code and the message of what is missing for a job; any of these may be None.

    Raises:
        BadInput: where it cannot be used.
    """
    path, limits, wearer = Path(source), Limits(is_confined=True), read_wearer(body)
    raw = _read_person(path, given_as, units, up, height)
    is_high = raw is not None and float(np.ptp(raw.points[:, 1])) >= (
        MIN_WHOLE_PERSON_HEIGHT if wearer is None else MIN_PERSON_HEIGHT_SHARE * MIN_ADULT_HEIGHT
    )
    what = given_as or (PERSON if is_high else GARMENT)
    if what == PERSON and given_as is None and wearer is not None and not is_quick:
        what = classify_file(path, wearer, units, up, limits)
    needs = _find_need(what, wearer, raw, height)
    found = dict.fromkeys(("body", "category", "contours_m")) | {"as": what, "needs": needs, "remarks": []}
    found["is_sure"] = given_as is not None or not is_high or not is_quick
    if what == PERSON and raw is not None:
        found["scan"] = describe_person_input(PersonInput(raw))["scan"] | {"has_labels": raw.labels is not None}
        return found if is_quick else found | {"body": _find_wearer(raw, given_as is None and wearer is None)}
    scan = load_scan(path, units=units, up=up, limits=limits)
    found["scan"] = _describe_garment(scan)
    if is_quick or needs:
        return found
    worn = inspect_file(path, wearer, units=units, up=up, limits=limits).as_dict()
    return found | {name: worn[name] for name in ("body", "category", "contours_m", "remarks")}


def _find_need(what: str, wearer: Wearer | None, raw: RawScan | None, height: float | None) -> dict[str, str] | None:
    """Return code and message of what is missing for a job: a garment's wearer, or a person's scale."""
    if what == GARMENT:
        return {"code": BodyMissing.code, "message": BodyMissing().message} if wearer is None else None
    try:
        if raw is not None:
            check_scale(raw, height)
    except StatureUnknown as error:
        return {"code": error.code, "message": error.message}
    return None


def _read_person(
    path: Path, given_as: str | None, units: str | None, up: str | None, height: float | None
) -> RawScan | None:
    """Read a raw scan; None where it is given as a garment, or may be one since it has too few points of a person."""
    if given_as == GARMENT:
        return None
    try:
        return load_raw(path, units, up, Limits(is_confined=True), stature=height)
    except MeshEmpty:
        if given_as == PERSON:
            raise
        return None


def _describe_garment(scan: Scan) -> dict[str, Any]:
    """Describe a garment's mesh under the names that a person's scan has."""
    known = describe_scan(scan)
    shared = ("name", "units", "up", "extent_m", "vertex_count", "face_count", "has_colours", "has_labels")
    return {name: known[name] for name in shared} | {
        "is_cloud": False, "file_count": len(scan.vertices), "notes": list(scan.repairs[:MAX_LISTED_NOTES]),
    }  # fmt: skip


def _find_wearer(raw: RawScan, may_be_garment: bool) -> dict[str, Any]:
    """Describe the wearer; where the scan may be a garment's, a refusal names what that needs."""
    try:
        return _describe_wearer(raw)
    except BadInput as error:
        if may_be_garment and is_garment_refusal(error):
            error.message = explain_missing_body(error)
        raise


def _describe_wearer(raw: RawScan) -> dict[str, Any]:
    """Find the wearer of a raw scan, and describe it; raise `BadInput` where it shows no person, or more than one."""
    check_single_person(raw)
    fit = fit_person(raw.points, raw.normals, raw.is_oriented)
    return {
        "source": f"scan:{raw.name}",
        "height_m": round(float(np.ptp(fit.body.vertices[:, 1])), 4),
        "skin_rms_mm": round(1e3 * fit.skin_rms, 2),
    }


def classify_file(
    path: Path, body: Wearer, units: str | None = None, up: str | None = None, limits: Limits | None = None
) -> str:
    """Return `PERSON` or `GARMENT` for a file that came with a body, as a job does: a person shows face, hands or feet.

    Args:
        path: The file.
        body: The wearer's file, or a built-in body.
        units: A name of `UNITS`, or None to find it.
        up: `y` or `z`, or None to find it.
        limits: What reading may cost.

    Raises:
        BadInput: where a file cannot be used.
    """
    try:
        pieces = load_scan_input(path, body if isinstance(body, Path) else None, units=units, up=up, limits=limits)
    except NoFaces:
        return PERSON  # a garment is a surface
    if not has_person_height(pieces.garment, pieces.wearer):
        return GARMENT
    worn = find_body(body, pieces)
    return PERSON if worn is not None and shows_person(pieces.garment, worn) else GARMENT


def is_garment_refusal(error: BadInput) -> bool:
    """Check whether a refusal may be due to a garment that was scanned alone."""
    return error.code in (NotHuman.code, ScanPartial.code)


def explain_missing_body(error: BadInput) -> str:
    """Return why a file without a body is no person, and what it needs if it is a garment."""
    return f"{error.message} A garment that was scanned alone needs its wearer: --body."
