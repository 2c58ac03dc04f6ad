"""What a file is taken for before anything is run: a whole person, or a garment alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..body import Body, NotHuman, builtin_body, fit_person, is_builtin, is_smpl, load_smpl, register_body
from ..body.presence import ScanPartial
from ..errors import BadInput
from ..scan import Pieces, load_pieces
from ..scan.load_raw import load_raw
from ..scan.refusal import NoFaces
from .given import Given, describe_given
from .separate import check_alone
from .whole import shows_person, stands_tall

PERSON, GARMENT = "person", "garment"
"""What a file can be taken for."""


def inspect_person(path: Path, units: str | None = None, up: str | None = None) -> dict[str, Any]:
    """Read a raw scan and find its wearer.

    Returns:
        What was understood, as JSON values; `as` is `person`.

    Raises:
        BadInput: where it is no person, or cannot be used.
    """
    raw = load_raw(path, units, up)
    check_alone(raw)
    fit = fit_person(raw.points, raw.normals, raw.is_oriented)
    found = describe_given(Given(raw))
    body = {
        "source": f"scan:{raw.name}",
        "height_m": round(float(np.ptp(fit.body.vertices[:, 1])), 4),
        "skin_rms_mm": round(1e3 * fit.skin_rms, 2),
    }
    return found | {"body": body}


def find_what(path: Path, body: Path | str, units: str | None = None, up: str | None = None) -> str:
    """Return what a file that came with a body is taken for, as a job does: who shows head, hands or feet is a person.

    Args:
        path: The file.
        body: The wearer's file, or the description of a built-in body.
        units: `m`, `cm` or `mm`, or None to find it.
        up: `y` or `z`, or None to find it.

    Raises:
        BadInput: where a file cannot be used.
    """
    try:
        pieces = load_pieces(path, None if is_builtin(body) else Path(body), units=units, up=up)
    except NoFaces:
        return PERSON  # a garment is a surface
    if not stands_tall(pieces.garment, pieces.wearer):
        return GARMENT
    return PERSON if shows_person(pieces.garment, _find_body(body, pieces)) else GARMENT


def is_no_person(error: BadInput) -> bool:
    """Return whether a refusal may be of a garment that was scanned alone."""
    return error.code in (NotHuman.code, ScanPartial.code)


def explain_garment(error: BadInput) -> str:
    """Return why a file that came without a body is no person, and what it needs where it is a garment."""
    return f"{error.message} A garment that was scanned alone needs its wearer: --body."


def _find_body(body: Path | str, pieces: Pieces) -> Body:
    if is_builtin(body) or pieces.wearer is None:
        return builtin_body(str(body))
    if is_smpl(body):
        return load_smpl(Path(body))
    return register_body(pieces.wearer.vertices, pieces.wearer.faces, name=pieces.wearer.name)
