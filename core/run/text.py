"""Texts that can be stored: databases and files accept neither NUL nor half of a surrogate pair."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from .errors import BadInput

UNSTORABLE_CHARACTERS = re.compile("[\x00\ud800-\udfff]")
"""NUL, which PostgreSQL refuses, and lone surrogates, which UTF-8 does not have; JSON can write both."""


class TextBad(BadInput):
    """A text has NUL or half of a surrogate pair, which cannot be stored; leave it out, and write UTF-8."""

    code = "text.bad"


class JsonTextBad(ValueError):
    """Raised where JSON has a text that cannot be stored; the file's reader raises an error with its own code."""


def read_json(source: str | bytes, **options: Any) -> Any:
    """Return the JSON value of a file, as `json.loads` with its options does.

    Raises:
        JsonTextBad: where a text in it cannot be stored.
        ValueError, RecursionError: where it is not JSON.
    """
    found = json.loads(source, **options)
    is_plain = isinstance(source, str) and "\\u" not in source and not UNSTORABLE_CHARACTERS.search(source)
    if not is_plain and has_unstorable_text(found):
        raise JsonTextBad("a text holds NUL or half of a surrogate pair")
    return found


def has_unstorable_text(value: Any) -> bool:
    """Check whether a text, or any name or text in JSON values, cannot be stored."""
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
