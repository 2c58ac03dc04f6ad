"""What is understood of an uploaded scan before a job is asked for: it is read in a limited process."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..core.run.errors import BadInput
from ..core.run.sandbox import Bounds, IsStopped, call_limited, never_stopped

INSPECTOR = "garmentq.core.people.inspect:inspect_order"

BOUNDS = Bounds(memory_bytes=4 * 1024**3, cpu_seconds=60, wall_seconds=100.0)
"""What looking at a scan may cost: reading takes 2 s, finding the wearer of 30 000 points 6 s."""


class BodyNotBuiltin(BadInput):
    """Before a job only a built-in body is looked at; write builtin:female,height=1.70, or leave the body out."""

    code = "inspection.body_file"


def inspect_scan(path: Path, options: Mapping[str, Any], is_stopped: IsStopped = never_stopped) -> dict[str, Any]:
    """Return what `core.people.inspect.inspect_order` understands of a file.

    Args:
        path: The file.
        options: Arguments of it besides the file.
        is_stopped: As `call_limited` has it.

    Raises:
        BodyNotBuiltin: where the body is a file.
        BadInput: where the file cannot be used.
    """
    from ..core.body.spec import is_builtin

    body = options.get("body")
    if body is not None and not is_builtin(body):
        raise BodyNotBuiltin()
    return call_limited(INSPECTOR, {"source": str(path.absolute()), **options}, BOUNDS, is_stopped).result
