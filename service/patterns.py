"""Users' pattern documents: each is read in a limited process, and its faults are reported with their places."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..core.run.errors import BadInput
from ..core.run.sandbox import Bounds, IsStopped, call_limited, never_stopped
from .store import Store

EXAMINER = "garmentq.core.garment.examine:examine_file"

BOUNDS = Bounds(memory_bytes=1024**3, cpu_seconds=20, wall_seconds=60.0, answer_bytes=8 * 1024**2)
"""Limits of checking a document: a pattern of six panels takes 1 s, most of it to start the process."""


class PatternUnsound(BadInput):
    """The pattern cannot be cut, sewn or meshed; the findings show where."""

    code = "pattern.unsound"

    def __init__(self, message: str | None = None, findings: list[dict[str, Any]] | None = None) -> None:
        super().__init__(message)
        self.findings = findings or []


def examine_pattern(path: Path, is_stopped: IsStopped = never_stopped) -> dict[str, Any]:
    """Check a pattern file in a limited process: faults, lengths and symmetry.

    Returns:
        JSON values as `core.garment.examine.examine_file` returns them.
    """
    arguments = {"source": str(path.absolute())}
    return call_limited(EXAMINER, arguments, BOUNDS, is_stopped).result


def edit_pattern(
    document: Mapping[str, Any], operations: Sequence[Mapping[str, Any]], is_stopped: IsStopped = never_stopped
) -> dict[str, Any]:
    """Apply operations to a pattern's document in a limited process, and check the result.

    Returns:
        `pattern`, the new document, and what `examine_pattern` returns.

    Raises:
        PatternUnsound: if an operation cannot be applied, or the document is not a pattern, with the code of that
            error.
    """
    with tempfile.TemporaryDirectory() as folder:
        paths = {"source": Path(folder) / "pattern.json", "operations": Path(folder) / "operations.json"}
        for path, value in zip(paths.values(), (document, operations), strict=True):
            path.write_text(json.dumps(value), encoding="utf-8")
        arguments = {name: str(path.absolute()) for name, path in paths.items()}
        found = call_limited("garmentq.core.garment.editing.operations:edit_file", arguments, BOUNDS, is_stopped).result
    if "refused" in found:
        refused = PatternUnsound(found["refused"]["message"], [found["refused"]])
        refused.code = found["refused"]["code"]
        raise refused
    return found


def refuse_unsound(store: Store, sha256: str, is_stopped: IsStopped = never_stopped) -> None:
    """Refuse a stored pattern file that cannot be draped.

    Raises:
        PatternUnsound: with every finding.
    """
    with tempfile.TemporaryDirectory() as folder:
        found = examine_pattern(store.copy(sha256, Path(folder) / "pattern.json"), is_stopped)
    if not found["is_sound"]:
        first = next(one for one in found["findings"] if one["severity"] == "error")
        raise PatternUnsound(f"{first['message']} ({first['code']})", found["findings"])
