"""What a file is taken for before anything is run: a whole person, or a garment alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..body import Body, fit_person, is_builtin
from ..errors import BadInput
from ..scan import load_pieces
from ..scan.load_raw import load_raw
from .given import Given, describe_given
from .whole import TALL, shows_person

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
    fit = fit_person(raw.points, raw.normals, raw.is_oriented)
    found = describe_given(Given(raw))
    body = {
        "source": f"scan:{raw.name}",
        "height_m": round(float(np.ptp(fit.body.vertices[:, 1])), 4),
        "skin_rms_mm": round(1e3 * fit.skin_rms, 2),
    }
    return found | {"body": body}


def find_what(path: Path, body: Path | str, found: dict[str, Any], units: str | None, up: str | None) -> str:
    """Return what a file that came with a body is taken for, as a job does: who shows head, hands or feet is a person.

    Args:
        path: The file.
        body: The wearer's file, or the description of a built-in body.
        found: What `inspect_file` understood of both.
        units: `m`, `cm` or `mm`, or None to find it.
        up: `y` or `z`, or None to find it.
    """
    if found["body"] is None or found["extent_m"][1] < TALL * found["body"]["height_m"]:
        return GARMENT
    wearer = _find_body(path, body, units, up)
    pieces = load_pieces(path, None if is_builtin(body) else Path(body), units=units, up=up)
    return PERSON if shows_person(pieces.garment, wearer) else GARMENT


def explain_garment(error: BadInput) -> str:
    """Return why a file that came without a body is no person, and what it needs then."""
    return f"{error.message} A garment that was scanned alone needs its wearer: --body."


def _find_body(path: Path, body: Path | str, units: str | None, up: str | None) -> Body:
    from ..body import builtin_body, is_smpl, load_smpl, register_body

    if is_builtin(body):
        return builtin_body(str(body))
    if is_smpl(body):
        return load_smpl(Path(body))
    wearer = load_pieces(path, Path(body), units=units, up=up).wearer
    if wearer is None:
        raise ValueError(f"{body} is no body")
    return register_body(wearer.vertices, wearer.faces, name=wearer.name)
