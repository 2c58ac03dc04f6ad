"""The first stage of every job: its files are read and checked in a limited process, which hands over plain arrays.

The process that holds the database's address and the store's keys never parses what a user handed in.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..core.limited import Bounds, call_limited

STAGE = "check"
"""The stage's name in progress and events."""


def check_files(checker: str, request: dict[str, Any], files: Path, is_stopped: Callable[[], bool]) -> dict[str, Any]:
    """Check the files of a job in a limited process.

    Args:
        checker: Dotted path of a function as `check_recovery` is, `package.module:function`.
        request: The job's request, as it is stored.
        files: Holds each file of the request, as FIELD/NAME.
        is_stopped: Asked now and then; True ends the process.

    Returns:
        What was understood of the files, and what that cost, as JSON values.

    Raises:
        BadInput: where a file cannot be used; the code says why.
        Cancelled: where `is_stopped` said so.
    """
    given = {"request": request, "files": str(files.absolute())}
    answer = call_limited(checker, given, Bounds(), is_stopped, files.parent)
    return answer.result | {"cpu_seconds": round(answer.cpu_seconds, 3), "peak_mb": round(answer.peak_mb, 1)}


def check_recovery(request: dict[str, Any], files: str) -> dict[str, Any]:
    """Read the files of a recovery in a limited process, and write them as arrays for the pipeline.

    Args:
        request: The job's request, as it is stored.
        files: Folder that holds each file of the request, as FIELD/NAME.

    Returns:
        What was understood, as JSON values.

    Raises:
        BadInput: where a file cannot be used.
    """
    from ..core.inputs import read_request
    from ..core.reading import describe_reading, save_reading
    from ..core.scan import Limits
    from .kinds import read_request as parse_request
    from .kinds.recover_request import READING, RecoverRequest

    folder = Path(files)
    wanted = parse_request(RecoverRequest, request).unpack(folder)
    reading = read_request(wanted, Limits(is_confined=True))
    save_reading(reading, folder / READING)
    return describe_reading(reading)
