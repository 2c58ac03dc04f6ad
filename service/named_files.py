"""Find the stored files that a request names."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

HASH = re.compile(r"[0-9a-f]{64}")
"""Pattern of a key in a job's request."""


def find_hashes(value: Any) -> Iterator[str]:
    """Yield every key of a stored file that a request's JSON values name."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for part in value:
            yield from find_hashes(part)
    elif isinstance(value, str) and HASH.fullmatch(value):
        yield value
