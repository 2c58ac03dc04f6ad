"""Read the files of one recovery, unless a limited process has read them already."""

from __future__ import annotations

from pathlib import Path

from ..body.body import Body
from ..body.builtin import BodyMissing
from ..body.models.model_file import load_body_model
from ..body.spec import is_body_model
from ..garment.garmentcode import load_pattern
from ..garment.pattern import Pattern
from ..garment.reading import Reading
from ..scan.limits import Limits
from ..scan.pieces import ScanInput, load_scan_input
from .recovery import Request
from .settings import SettingsBad


def read_files(request: Request, limits: Limits | None = None) -> ScanInput:
    """Read the garment and its wearer, or cut the garment out of a dressed person's scan, unless already read.

    Raises:
        BodyMissing: where no body is given and the scan has none.
        SettingsBad: where a person's height is given with a garment.
        BadInput: where a file cannot be used.
    """
    if request.reading is not None:
        return request.reading.pieces
    selection, body, settings = request.selection, request.body, request.settings
    if body is None and selection is None:
        raise BodyMissing()
    if settings.height is not None:
        raise SettingsBad("height scales a whole person's scan; a garment has its body's unit, or --units.")
    body_file = body if isinstance(body, Path) else None
    return load_scan_input(
        request.scan, body_file, units=settings.units, up=settings.up, selection=selection, limits=limits
    )


def read_body(request: Request) -> Body | None:
    """Read the file of a body model, unless already read; None where the wearer is given in another form.

    Raises:
        BadInput: where the file is not a valid body model.
    """
    if request.reading is not None:
        return request.reading.body
    body = request.body
    return load_body_model(body) if isinstance(body, Path) and is_body_model(body) else None


def read_template(request: Request) -> Pattern | None:
    """Read the pattern file, unless already read; None where none is given.

    Raises:
        BadInput: where the file is not a pattern.
    """
    if request.reading is not None:
        return request.reading.pattern
    return None if request.template is None else load_pattern(request.template)


def read_request(request: Request, limits: Limits | None = None) -> Reading:
    """Read every file of a request.

    Raises:
        BadInput: where one cannot be used.
    """
    return Reading(read_files(request, limits), read_body(request), read_template(request))
