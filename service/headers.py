"""A look at the headers of many files before any of them is read: a file that is none is refused at once."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..core.run.errors import BadInput
from ..core.run.sandbox import Bounds, InputTookTooLong, call_limited

HEADER_BOUNDS = Bounds(memory_bytes=1024**3, cpu_seconds=20, wall_seconds=40.0)
"""Limits of one look at the headers of many files: 0.3 s, and 0.1 s for each text file of 10 MB."""


def check_headers(paths: Sequence[Path]) -> dict[Path, BadInput]:
    """Check headers and sizes of mesh files, all in one limited process.

    Returns:
        The refusal of each file that cannot be used.
    """
    sources = [str(path.absolute()) for path in paths]
    try:
        found = call_limited(f"{__name__}:read_headers", {"sources": sources}, HEADER_BOUNDS).result["refused"]
    except InputTookTooLong:
        return {}
    refused = {}
    for path, source in zip(paths, sources, strict=True):
        if source in found:
            code, message = found[source]
            refused[path] = BadInput(message)
            refused[path].code = code
    return refused


def read_headers(sources: list[str]) -> dict[str, Any]:
    """Read the headers of mesh files in a limited process.

    Args:
        sources: The files.

    Returns:
        JSON values: `refused` has code and message of each file that cannot be used.
    """
    from ..core.scan.header import check_header
    from ..core.scan.limits import Limits

    refused = {}
    for source in sources:
        try:
            check_header(Path(source), Limits(is_confined=True), needs_faces=False)
        except BadInput as error:
            refused[source] = (error.code, error.message)
    return {"refused": refused}
