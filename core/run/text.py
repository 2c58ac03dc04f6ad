"""Text that can be kept: no database and no file takes NUL or half of a surrogate pair."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from .errors import BadInput

UNSTORABLE_CHARACTERS = re.compile("[\x00\ud800-\udfff]")
"""NUL, which PostgreSQL refuses, and lone surrogates, which no UTF-8 has; JSON can write both."""


class TextBad(BadInput):
    """A text holds NUL or half of a surrogate pair, which nothing can keep; leave it out, and write UTF-8."""

    code = "text.bad"


class JsonTextBad(ValueError):
    """Raised where JSON holds a text that nothing can keep; who reads the file has a code for what is wrong with it."""


def read_json(source: str | bytes, **options: Any) -> Any:
    """Return the JSON value of a file, as `json.loads` with its options does.

    Raises:
        JsonTextBad: where a text in it cannot be kept.
        ValueError, RecursionError: where it is no JSON.
    """
    found = json.loads(source, **options)
    is_plain = isinstance(source, str) and "\\u" not in source and not UNSTORABLE_CHARACTERS.search(source)
    if not is_plain and has_unstorable_text(found):
        raise JsonTextBad("a text holds NUL or half of a surrogate pair")
    return found


def has_unstorable_text(value: Any) -> bool:
    """Return whether a text, or any name or text in JSON values, holds what nothing can keep."""
    waiting = [value]
    while waiting:
        one = waiting.pop()
        if isinstance(one, str):
            if UNSTORABLE_CHARACTERS.search(one):
                return True
        elif isinstance(one, Mapping):
            waiting += [*one.keys(), *one.values()]
        elif isinstance(one, list | tuple):
            waiting += one
    return False
