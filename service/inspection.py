"""Inspection of an uploaded scan before a job is created: it is read in a limited process."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..core.run.errors import BadInput
from ..core.run.sandbox import Bounds, IsStopped, call_limited, never_stopped

INSPECTOR = "garmentq.service.inspect_scan:inspect_order"

BOUNDS = Bounds(memory_bytes=4 * 1024**3, cpu_seconds=60, wall_seconds=100.0)
"""Limits of an inspection: reading takes 2 s, fitting the wearer of 30 000 points 6 s."""


class BodyNotBuiltin(BadInput):
    """Before a job only a built-in body can be used; write builtin:female,height=1.70, or leave the body out."""

    code = "inspection.body_file"


def inspect_scan(path: Path, options: Mapping[str, Any], is_stopped: IsStopped = never_stopped) -> dict[str, Any]:
    """Return what `service.inspect_scan.inspect_order` detects in a file.

    Args:
        path: The file.
        options: Its other arguments.
        is_stopped: As for `call_limited`.

    Raises:
        BodyNotBuiltin: if the body is a file.
        BadInput: if the file cannot be used.
    """
    from ..core.body.spec import is_builtin

    body = options.get("body")
    if body is not None and not is_builtin(body):
        raise BodyNotBuiltin()
    return call_limited(INSPECTOR, {"source": str(path.absolute()), **options}, BOUNDS, is_stopped).result
