"""Describe what the files of a recovery hold, as JSON values."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..core.garment.garmentcode import load_pattern
from ..core.garment.pattern import Pattern
from ..core.garment.reading import Reading
from ..core.scan.scan import describe_scan

MAX_LISTED_LABELS = 50
"""Largest number of labels that are listed of a scan."""


def describe_reading(reading: Reading) -> dict[str, Any]:
    """Return a description of the files' content, as JSON values."""
    pieces = reading.pieces
    garment, wearer = pieces.garment, pieces.wearer
    labels = pieces.labels if pieces.labels is not None else garment.labels
    found: dict[str, Any] = {"scan": describe_scan(garment)}
    if labels is not None:
        values, counts = np.unique(labels, return_counts=True)
        pairs = zip(values.tolist(), counts.tolist(), strict=True)
        found["labels"] = {str(value): count for value, count in list(pairs)[:MAX_LISTED_LABELS]}
    if wearer is not None:
        found["body"] = describe_scan(wearer)
    if reading.pattern is not None:
        found["pattern"] = describe_pattern(reading.pattern)
    return found


def describe_pattern(pattern: Pattern) -> dict[str, Any]:
    """Return a pattern's category and counts, as JSON values."""
    return {"panels": len(pattern.panels), "seams": len(pattern.seams), "category": pattern.category}


def check_pattern(source: str) -> dict[str, Any]:
    """Read a pattern file in a limited process, and describe it.

    Raises:
        BadInput: where it is none.
    """
    return describe_pattern(load_pattern(Path(source)))
